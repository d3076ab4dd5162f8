//! Thin sheets that scatter light diffusely to both sides, such as paper, cloth and leaves.

use super::sample::NonSpecularSample;
use crate::color::{self, Rgb};
use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Lambertian reflection and Lambertian transmission. Both sides of the sheet scatter alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    reflectance: Rgb,
    transmittance: Rgb,
}

impl DiffuseTransmission {
    /// Creates the BSDF from a `reflectance` and a `transmittance`, each in \[0, 1].
    ///
    /// If reflectance plus transmittance exceeds 1 in a color channel, both are divided by the
    /// largest sum of any channel.
    #[must_use]
    pub fn new(reflectance: Rgb, transmittance: Rgb) -> Self {
        let largest_sum = (reflectance + transmittance).max_element().max(1.0);
        Self { reflectance: reflectance / largest_sum, transmittance: transmittance / largest_sum }
    }

    /// True if the sheet scatters no light.
    #[inline]
    pub(super) fn is_black(&self) -> bool {
        self.reflectance == Rgb::ZERO && self.transmittance == Rgb::ZERO
    }

    /// BSDF f(wo, wi) \[1/sr]. `crosses` is true if `wo` and `wi` are on different sides.
    #[inline]
    pub(super) fn evaluate(&self, crosses: bool) -> Rgb {
        FRAC_1_PI * if crosses { self.transmittance } else { self.reflectance }
    }

    /// Probability with which [`DiffuseTransmission::sample`] reflects light instead of
    /// transmitting it.
    ///
    /// The probability is r/(r + t), where r and t are the means of reflectance and transmittance
    /// over the color channels; 0 if r is 0.
    #[inline]
    fn reflection_probability(&self) -> f32 {
        let (r, t) = (color::channel_mean(self.reflectance), color::channel_mean(self.transmittance));
        if r > 0.0 { r / (r + t) } else { 0.0 }
    }

    /// Solid-angle pdf \[1/sr] with which [`DiffuseTransmission::sample`] samples a direction at
    /// the cosine `cos` ≥ 0 to the shading normal.
    ///
    /// `crosses` is true if the direction and `wo` are on different sides.
    #[inline]
    pub(super) fn pdf(&self, cos: f32, crosses: bool) -> f32 {
        let reflects = self.reflection_probability();
        let side = if crosses { 1.0 - reflects } else { reflects };
        side * warp::cosine_hemisphere_pdf(cos)
    }

    /// Samples a direction of reflection or transmission; `None` if the sheet is black or the
    /// direction lies in the surface.
    ///
    /// The unit normal `facing_ns` is the shading normal on the side of `wo`. `lobe` in \[0, 1)
    /// selects the side, and `u` in \[0, 1)² the direction.
    #[inline]
    pub(super) fn sample(&self, facing_ns: Vec3, lobe: f32, u: Vec2) -> Option<NonSpecularSample> {
        let local = warp::square_to_cosine_hemisphere(u);
        // A direction on the horizon has a pdf of 0, so it has no MIS weight.
        if self.is_black() || local.z <= 0.0 {
            return None;
        }
        let reflects = self.reflection_probability();
        let is_transmitted = lobe >= reflects;
        let (normal, scattered, probability) = if is_transmitted {
            (-facing_ns, self.transmittance, 1.0 - reflects)
        } else {
            (facing_ns, self.reflectance, reflects)
        };
        let wi = Frame::from_normal(normal).to_world(local);
        let pdf = probability * warp::cosine_hemisphere_pdf(local.z);
        Some(NonSpecularSample { wi, weight: scattered / probability, pdf, is_transmitted })
    }
}
