//! Smooth dielectric interfaces.

use super::{BsdfSample, Transport, refract};
use crate::color::Rgb;
use glam::Vec3;

/// A smooth interface; its normal points outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Relative refractive index: inside over outside.
    pub eta: f32,
}

/// Reflection and refraction at a dielectric, with the weights of following both.
#[derive(Clone, Copy, Debug)]
pub struct DielectricSplit {
    /// The reflected direction and its reflectance.
    pub reflected: (Vec3, f32),
    /// The refracted direction and its transmittance; 0 under total internal reflection.
    pub transmitted: (Vec3, f32),
    /// Divisor of transmitted radiance: (n_near/n_far)² for radiance, 1 for flux.
    pub squeeze: f32,
    /// True if both used the geometric normal: see [`BsdfSample::flat`].
    pub uses_geometric_normal: [bool; 2],
}

impl Dielectric {
    /// Reflection and refraction of direction `wo`.
    #[inline]
    #[must_use]
    pub fn split(&self, wo: Vec3, ns: Vec3, ng: Vec3, transport: Transport) -> DielectricSplit {
        let outside = wo.dot(ng) >= 0.0;
        let (near_ns, near_ng, eta) = if outside { (ns, ng, self.eta) } else { (-ns, -ng, 1.0 / self.eta) };
        // If the shading normal would send light to the wrong side, use the geometric normal.
        let mut uses_geometric_normal = wo.dot(near_ns) <= 0.0;
        let mut bent = refract(wo, if uses_geometric_normal { near_ng } else { near_ns }, eta);
        if bent.transmittance > 0.0 && bent.transmitted.dot(near_ng) >= 0.0 {
            bent = refract(wo, near_ng, eta);
            uses_geometric_normal = true;
        }
        let squeeze = match transport {
            Transport::Radiance => eta * eta,
            Transport::Importance => 1.0,
        };
        let (mirrored, mirrored_flat) = reflect_above_surface(wo, near_ns, ng);
        DielectricSplit {
            reflected: (mirrored, bent.reflectance),
            transmitted: (bent.transmitted, bent.transmittance),
            squeeze,
            uses_geometric_normal: [mirrored_flat, uses_geometric_normal],
        }
    }

    /// Samples reflection or refraction by the reflectance.
    ///
    /// `lobe` has steps of 2⁻²⁴. A weight corrects the rounding of a small transmittance.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32, transport: Transport) -> BsdfSample {
        let split = self.split(wo, ns, ng, transport);
        if lobe < split.reflected.1 {
            let (wi, uses_geometric_normal) = (split.reflected.0, split.uses_geometric_normal[0]);
            BsdfSample { wi, weight: Rgb::ONE, pdf: 0.0, specular: true, transmitted: false, uses_geometric_normal }
        } else {
            let through = 1.0 - split.reflected.1;
            let exact = if through < 0.5 { split.transmitted.1 / through } else { 1.0 };
            let weight = Rgb::splat(exact / split.squeeze);
            let (wi, uses_geometric_normal) = (split.transmitted.0, split.uses_geometric_normal[1]);
            BsdfSample { wi, weight, pdf: 0.0, specular: true, transmitted: true, uses_geometric_normal }
        }
    }
}

/// Mirror image of `wo` about `ns`, or about `ng` if the former lies below the surface; true for
/// the latter.
#[inline]
pub(super) fn reflect_above_surface(wo: Vec3, ns: Vec3, ng: Vec3) -> (Vec3, bool) {
    let mirrored = |n: Vec3| n * (2.0 * wo.dot(n)) - wo;
    let wi = mirrored(ns);
    let reflection_masking_shadowing = wi.dot(ng) * wo.dot(ng) > 0.0;
    if reflection_masking_shadowing { (wi.normalize(), false) } else { (mirrored(ng).normalize(), true) }
}
