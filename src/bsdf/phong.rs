//! Energy-conserving Phong reflection.

use super::{Bsdf, BsdfSample};
use crate::color::{self, Rgb};
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// f(wo, wi) = (kd + ks·cosˢα)/π, with α the angle between `wi` and the mirror direction of `wo`.
///
/// See Lafortune and Willems 1994. The lobe peaks at ks·c under irradiance π·c, as in the course's
/// model. It reflects at most 2ks/(s+2), so [`Phong::new`] scales both to keep kd + 2ks/(s+2) ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    diffuse: Rgb,
    specular: Rgb,
    shininess: f32,
    /// Probability of sampling the lobe.
    lobe: f32,
}

impl Phong {
    /// Coefficients in \[0, ∞) and exponent ≥ 0. All channels are scaled by one factor to conserve
    /// energy.
    #[must_use]
    pub fn new(diffuse: Rgb, specular: Rgb, shininess: f32) -> Self {
        let total = diffuse + specular * (2.0 / (shininess + 2.0));
        let scale = 1.0 / total.max_element().max(1.0);
        let (diffuse, specular) = (diffuse * scale, specular * scale);
        let glossy = color::channel_mean(specular) * 2.0 / (shininess + 2.0);
        let sum = glossy + color::channel_mean(diffuse);
        Self { diffuse, specular, shininess, lobe: if sum > 0.0 { glossy / sum } else { 0.0 } }
    }

    /// Samples one of the two parts by `chance` in \[0, 1), divided by its probability: a
    /// Lambertian BSDF, or the lobe alone.
    #[must_use]
    pub fn select_lobe(&self, chance: f32) -> Bsdf {
        if chance < self.lobe {
            Bsdf::Phong(Self { diffuse: Rgb::ZERO, specular: self.specular / self.lobe, lobe: 1.0, ..*self })
        } else {
            Bsdf::Diffuse(self.diffuse / (1.0 - self.lobe))
        }
    }

    /// Cosine between `wi` and the mirror direction of `wo`, at most 1. Rounding above 1 would
    /// overflow at exponents beyond 10⁸.
    #[inline]
    fn cos_to_mirror_direction(wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        (n * (2.0 * wo.dot(n)) - wo).dot(wi).min(1.0)
    }

    #[inline]
    pub(super) fn evaluate(&self, wo: Vec3, wi: Vec3, n: Vec3) -> Rgb {
        let cos = Self::cos_to_mirror_direction(wo, wi, n);
        // 0⁰ is 1, as in the course's model.
        let lobe = if cos > 0.0 || self.shininess == 0.0 { libm::powf(cos.max(0.0), self.shininess) } else { 0.0 };
        (self.diffuse + self.specular * lobe) * FRAC_1_PI
    }

    /// Samples the mixture of both lobes; `n` is on the side of `wo`.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, n: Vec3, lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let mirror = n * (2.0 * wo.dot(n)) - wo;
        let wi = if lobe < self.lobe {
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
        (pdf > 0.0).then_some(BsdfSample {
            wi,
            weight,
            pdf,
            specular: false,
            transmitted: false,
            uses_geometric_normal: false,
        })
    }

    /// Solid-angle pdf of the mixture \[1/sr], for directions on one side of `n`.
    #[inline]
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3, n: Vec3) -> f32 {
        let glossy = warp::power_cosine_pdf(Self::cos_to_mirror_direction(wo, wi, n), self.shininess);
        self.lobe * glossy + (1.0 - self.lobe) * warp::cosine_hemisphere_pdf(wi.dot(n).abs())
    }
}
