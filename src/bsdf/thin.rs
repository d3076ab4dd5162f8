//! Thin sheets, which transmit light without displacement.

use super::fresnel::{fresnel_reflectance_and_cosine, fresnel_transmittance};
use super::{BsdfSample, dielectric};
use crate::color::{self, Rgb};
use glam::Vec3;

/// A thin sheet: two parallel smooth interfaces, with all reflections between them.
///
/// Transmitted light keeps its direction. The medium is the same on both sides, so refraction does
/// not scale radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Refractive index of the sheet, relative to its surroundings.
    pub eta: f32,
    /// Internal transmittance of the sheet along its normal, in \[0, 1]. Fresnel reflection is not
    /// included.
    pub internal_transmittance: Rgb,
}

impl ThinDielectric {
    /// Reflectance and transmittance of the sheet, where `cos` ≥ 0 is the cosine of incidence.
    ///
    /// Let R be the reflectance of one interface and τ the internal transmittance along the
    /// refracted ray. The sheet's reflectance is R + (1−R)²τ²R/(1−R²τ²), and its transmittance is
    /// (1−R)²τ/(1−R²τ²).
    #[inline]
    #[must_use]
    pub fn reflectance_and_transmittance(&self, cos: f32) -> (Rgb, Rgb) {
        let (cos, eta) = (f64::from(cos.clamp(0.0, 1.0)), f64::from(self.eta));
        let (r, cos_t) = fresnel_reflectance_and_cosine(cos, eta);
        let t = if cos_t > 0.0 { fresnel_transmittance(cos, cos_t, eta) as f32 } else { 0.0 };
        if t <= 0.0 {
            return (Rgb::ONE, Rgb::ZERO);
        }
        let (r, length) = (r as f32, (1.0 / cos_t) as f32);
        let clear = self.internal_transmittance == Rgb::ONE;
        let kept = if clear { Rgb::ONE } else { self.internal_transmittance.map(|t| libm::powf(t, length)) };
        // `rest` is 1 − R²τ², as a product that does not cancel if nearly all light is reflected.
        let rest = (Rgb::ONE - kept + kept * t) * (Rgb::ONE + kept * r);
        let through = kept * (t * t) / rest;
        (Rgb::splat(r) + through * kept * r, through)
    }

    /// Transmittance for light that arrives along −`wo` and keeps its direction.
    ///
    /// `wo` points away from the sheet, `ns` is the shading normal on the side of `wo`, and `ng`
    /// the geometric normal. Transmission by [`ThinDielectric::sample`] has the same weight on
    /// average.
    #[inline]
    pub(super) fn straight_transmittance(&self, wo: Vec3, ns: Vec3, ng: Vec3) -> Rgb {
        let (cos, ..) = reflection_cosine_and_direction(wo, ns, ng);
        self.reflectance_and_transmittance(cos).1
    }

    /// Samples reflection or transmission by `lobe` in \[0, 1); `None` if the sheet absorbs all
    /// light.
    ///
    /// The probability of each is proportional to its reflectance or transmittance, averaged over
    /// the color channels. `wo` points away from the sheet, `ns` is the shading normal on the side
    /// of `wo`, and `ng` the geometric normal.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32) -> Option<BsdfSample> {
        let (cos, mirrored, uses_geometric_normal) = reflection_cosine_and_direction(wo, ns, ng);
        let (reflectance, transmittance) = self.reflectance_and_transmittance(cos);
        let (r, t) = (color::channel_mean(reflectance), color::channel_mean(transmittance));
        let reflects = r / (r + t);
        if r + t == 0.0 {
            return None;
        }
        let is_transmitted = lobe >= reflects;
        let (wi, weight) =
            if is_transmitted { (-wo, transmittance / (1.0 - reflects)) } else { (mirrored, reflectance / reflects) };
        Some(BsdfSample::specular_sample(wi, weight, is_transmitted, uses_geometric_normal && !is_transmitted))
    }
}

/// Returns three values: the cosine of incidence at a sheet, the mirrored direction of `wo`, and
/// true if the geometric normal `ng` was used instead of the shading normal `ns`.
#[inline]
fn reflection_cosine_and_direction(wo: Vec3, ns: Vec3, ng: Vec3) -> (f32, Vec3, bool) {
    let (mirrored, uses_geometric_normal) = dielectric::reflect_above_surface(wo, ns, ng);
    // The bisector of both directions is the normal that was used for reflection.
    (wo.dot((wo + mirrored).normalize_or_zero()), mirrored, uses_geometric_normal)
}
