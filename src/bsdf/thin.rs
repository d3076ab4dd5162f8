//! ThinDielectric sheets, whose transmitted light is not displaced.

use super::fresnel::{fresnel_reflectance, fresnel_transmittance};
use super::{BsdfSample, dielectric};
use crate::color::{self, Rgb};
use glam::Vec3;

/// Two parallel smooth interfaces with all reflections between them; symmetric.
///
/// Light passes straight through. Both sides are one medium, so radiance is not scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Index of the sheet over that of its surroundings.
    pub eta: f32,
    /// Transmittance of one perpendicular crossing, in \[0, 1].
    pub transmittance: Rgb,
}

/// Reflection and transmission at a sheet, with the weights of following both.
#[derive(Clone, Copy, Debug)]
pub struct ThinDielectricSplit {
    /// The reflected direction and its reflectance.
    pub reflected: (Vec3, Rgb),
    /// The transmitted direction and its transmittance.
    pub transmitted: (Vec3, Rgb),
    /// True if reflection used the geometric normal: see [`BsdfSample::flat`].
    pub uses_geometric_normal: bool,
}

impl ThinDielectric {
    /// Reflectance and transmittance of the sheet, where `cos ≥ 0` is the cosine outside.
    ///
    /// With R of one interface and τ of one crossing: R + (1−R)²τ²R/(1−R²τ²) and (1−R)²τ/(1−R²τ²),
    /// sums of geometric series.
    #[inline]
    #[must_use]
    pub fn reflectance_and_transmittance(&self, cos: f32) -> (Rgb, Rgb) {
        let (cos, eta) = (f64::from(cos.clamp(0.0, 1.0)), f64::from(self.eta));
        let (r, cos_t) = fresnel_reflectance(cos, eta);
        let t = if cos_t > 0.0 { fresnel_transmittance(cos, cos_t, eta) as f32 } else { 0.0 };
        if t <= 0.0 {
            return (Rgb::ONE, Rgb::ZERO);
        }
        let (r, length) = (r as f32, (1.0 / cos_t) as f32);
        let clear = self.transmittance == Rgb::ONE;
        let kept = if clear { Rgb::ONE } else { self.transmittance.map(|t| libm::powf(t, length)) };
        // 1 − R²τ² without cancellation if nearly all light is reflected.
        let rest = (Rgb::ONE - kept + kept * t) * (Rgb::ONE + kept * r);
        let through = kept * (t * t) / rest;
        (Rgb::splat(r) + through * kept * r, through)
    }

    /// Reflection and transmission of direction `wo`.
    #[inline]
    #[must_use]
    pub fn split(&self, wo: Vec3, ns: Vec3, ng: Vec3) -> ThinDielectricSplit {
        let (mirrored, uses_geometric_normal) = dielectric::reflect_above_surface(wo, ns, ng);
        // The cosine to the normal that reflected, which is not always `ns`.
        let cos = wo.dot((wo + mirrored).normalize_or_zero());
        let (reflected, transmitted) = self.reflectance_and_transmittance(cos);
        ThinDielectricSplit { reflected: (mirrored, reflected), transmitted: (-wo, transmitted), uses_geometric_normal }
    }

    /// Samples reflection or transmission by their mean weights.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32) -> Option<BsdfSample> {
        let ThinDielectricSplit { reflected, transmitted, uses_geometric_normal } = self.split(wo, ns, ng);
        let (r, t) = (color::channel_mean(reflected.1), color::channel_mean(transmitted.1));
        let reflects = r / (r + t);
        if r + t == 0.0 {
            return None;
        }
        let directions_cross_surface = lobe >= reflects;
        let ((wi, share), probability) =
            if directions_cross_surface { (transmitted, 1.0 - reflects) } else { (reflected, reflects) };
        Some(BsdfSample {
            wi,
            weight: share / probability,
            pdf: 0.0,
            specular: true,
            transmitted: directions_cross_surface,
            uses_geometric_normal: uses_geometric_normal && !directions_cross_surface,
        })
    }
}
