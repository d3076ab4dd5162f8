//! Energy-conserving Phong reflection (Lafortune and Willems 1994).

use super::Bsdf;
use super::sample::NonSpecularSample;
use crate::color::{self, Rgb};
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The modified Phong BRDF f(wo, wi) = (kd + ks·cosˢα)/π (Lafortune and Willems 1994).
///
/// α is the angle between `wi` and the mirror direction of `wo`. The glossy lobe reflects at most
/// 2ks/(s + 2), so [`Phong::new`] scales both coefficients to keep kd + 2ks/(s + 2) ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Diffuse coefficient kd of the BRDF.
    diffuse: Rgb,
    /// Glossy coefficient ks of the BRDF.
    specular: Rgb,
    /// Exponent s of the glossy lobe.
    shininess: f32,
    /// Probability of sampling the glossy lobe.
    glossy_probability: f32,
}

impl Phong {
    /// Creates the BRDF from the coefficients kd = `diffuse` ≥ 0 and ks = `specular` ≥ 0, and the
    /// exponent `shininess` ≥ 0.
    ///
    /// If the BRDF could reflect more light than arrives, both coefficients are multiplied by the
    /// same factor below 1 in all channels.
    #[must_use]
    pub fn new(diffuse: Rgb, specular: Rgb, shininess: f32) -> Self {
        let total = diffuse + specular * (2.0 / (shininess + 2.0));
        let scale = 1.0 / total.max_element().max(1.0);
        let (diffuse, specular) = (diffuse * scale, specular * scale);
        let glossy = color::channel_mean(specular) * 2.0 / (shininess + 2.0);
        let sum = glossy + color::channel_mean(diffuse);
        Self { diffuse, specular, shininess, glossy_probability: if sum > 0.0 { glossy / sum } else { 0.0 } }
    }

    /// Returns the glossy or the diffuse lobe as a BSDF, selected by `u` in \[0, 1).
    ///
    /// The lobe is divided by the probability of its selection.
    #[must_use]
    pub fn select_lobe(&self, u: f32) -> Bsdf {
        if u < self.glossy_probability {
            Bsdf::Phong(Self {
                diffuse: Rgb::ZERO,
                specular: self.specular / self.glossy_probability,
                glossy_probability: 1.0,
                ..*self
            })
        } else {
            Bsdf::Diffuse(self.diffuse / (1.0 - self.glossy_probability))
        }
    }

    /// Cosine between `wi` and the direction into which the normal `n` mirrors `wo`.
    ///
    /// Values above 1 are rounding errors and become 1, because a large power of them would
    /// overflow.
    #[inline]
    fn cos_to_mirror_direction(wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        (n * (2.0 * wo.dot(n)) - wo).dot(wi).min(1.0)
    }

    /// BRDF f(wo, wi) \[1/sr]. `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3) -> Rgb {
        let cos = Self::cos_to_mirror_direction(wo, wi, n);
        // 0⁰ counts as 1.
        let lobe = if cos > 0.0 || self.shininess == 0.0 { libm::powf(cos.max(0.0), self.shininess) } else { 0.0 };
        (self.diffuse + self.specular * lobe) * FRAC_1_PI
    }

    /// Samples the glossy or the diffuse lobe, where the shading normal `n` is on the side of `wo`.
    ///
    /// `lobe` in \[0, 1) selects the lobe, and `u` in \[0, 1)² the direction. Returns `None` if the
    /// direction points into the surface.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, n: Vec3, lobe: f32, u: Vec2) -> Option<NonSpecularSample> {
        let mirror = n * (2.0 * wo.dot(n)) - wo;
        let wi = if lobe < self.glossy_probability {
            Frame::from_normal(mirror.normalize()).to_world(warp::square_to_power_cosine(u, self.shininess))
        } else {
            Frame::from_normal(n).to_world(warp::square_to_cosine_hemisphere(u))
        };
        let cos = wi.dot(n);
        if cos <= 0.0 {
            return None;
        }
        let pdf = self.pdf(wo, wi, n);
        let weight = self.evaluate(wo, wi, n) * (cos / pdf);
        (pdf > 0.0).then_some(NonSpecularSample { wi, weight, pdf, is_transmitted: false })
    }

    /// Solid-angle pdf \[1/sr] with which [`Phong::sample`] samples `wi`, given `wo`.
    ///
    /// `wo` and `wi` must be on one side of the shading normal `n`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        let glossy = warp::power_cosine_pdf(Self::cos_to_mirror_direction(wo, wi, n), self.shininess);
        self.glossy_probability * glossy
            + (1.0 - self.glossy_probability) * warp::cosine_hemisphere_pdf(wi.dot(n).abs())
    }
}
