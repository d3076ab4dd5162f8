//! Smooth interfaces between two transparent media.

use super::{BsdfSample, TransportMode, refract};
use crate::color::Rgb;
use glam::Vec3;

/// A smooth interface between two transparent media, whose normal points to the outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Refractive index of the inside, relative to the outside.
    pub eta: f32,
}

/// The reflected and the refracted direction at a smooth dielectric, with their Fresnel factors.
#[derive(Clone, Copy, Debug)]
pub struct DielectricSplit {
    /// Unit direction of reflection, and the Fresnel reflectance.
    pub reflected: (Vec3, f32),
    /// Unit direction of refraction, and the Fresnel transmittance; 0 under total reflection.
    pub transmitted: (Vec3, f32),
    /// Number by which the throughput of a refracted path is divided.
    ///
    /// The number is (n_far/n_near)² for radiance and 1 for flux. The refractive index is n_near on
    /// the side of `wo`, and n_far on the other side.
    pub transmitted_radiance_divisor: f32,
    /// Two flags, for the reflected and for the refracted direction: true if the direction was
    /// computed with the geometric normal instead of the shading normal.
    ///
    /// See [`BsdfSample::uses_geometric_normal`].
    pub uses_geometric_normal: [bool; 2],
}

impl Dielectric {
    /// Returns the reflected and the refracted direction for the unit vector `wo`.
    ///
    /// `wo` points away from the interface. `ns` is the shading normal, `ng` the geometric normal.
    /// Both are on the outer side.
    #[inline]
    #[must_use]
    pub fn reflect_and_refract(&self, wo: Vec3, ns: Vec3, ng: Vec3, transport: TransportMode) -> DielectricSplit {
        let outside = wo.dot(ng) >= 0.0;
        let (near_ns, near_ng, eta) = if outside { (ns, ng, self.eta) } else { (-ns, -ng, 1.0 / self.eta) };
        // If the shading normal would send light to the wrong side of the surface, use the
        // geometric normal.
        let mut uses_geometric_normal = wo.dot(near_ns) <= 0.0;
        let mut bent = refract(wo, if uses_geometric_normal { near_ng } else { near_ns }, eta);
        if bent.transmittance > 0.0 && bent.transmitted.dot(near_ng) >= 0.0 {
            bent = refract(wo, near_ng, eta);
            uses_geometric_normal = true;
        }
        let transmitted_radiance_divisor = match transport {
            TransportMode::Radiance => eta * eta,
            TransportMode::Importance => 1.0,
        };
        let (mirrored, mirror_uses_geometric_normal) = reflect_above_surface(wo, near_ns, ng);
        DielectricSplit {
            reflected: (mirrored, bent.reflectance),
            transmitted: (bent.transmitted, bent.transmittance),
            transmitted_radiance_divisor,
            uses_geometric_normal: [mirror_uses_geometric_normal, uses_geometric_normal],
        }
    }

    /// Samples reflection or refraction by `lobe` in \[0, 1).
    ///
    /// The probability of reflection is the Fresnel reflectance. `wo` and the outer normals `ns`
    /// and `ng` are those of [`Dielectric::reflect_and_refract`].
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32, transport: TransportMode) -> BsdfSample {
        let split = self.reflect_and_refract(wo, ns, ng, transport);
        if lobe < split.reflected.1 {
            BsdfSample::specular_sample(split.reflected.0, Rgb::ONE, false, split.uses_geometric_normal[0])
        } else {
            // 1 − reflectance in f32 loses digits if the transmittance is small. The weight
            // corrects this error of the probability.
            let through = 1.0 - split.reflected.1;
            let exact = if through < 0.5 { split.transmitted.1 / through } else { 1.0 };
            let weight = Rgb::splat(exact / split.transmitted_radiance_divisor);
            BsdfSample::specular_sample(split.transmitted.0, weight, true, split.uses_geometric_normal[1])
        }
    }
}

/// Reflects `wo` about the shading normal `ns`, or about the geometric normal `ng` where needed.
///
/// `ng` is used if the direction reflected about `ns` would lie below the surface. Returns the
/// reflected unit direction, and true if `ng` was used.
#[inline]
pub(super) fn reflect_above_surface(wo: Vec3, ns: Vec3, ng: Vec3) -> (Vec3, bool) {
    let mirrored = |n: Vec3| n * (2.0 * wo.dot(n)) - wo;
    let wi = mirrored(ns);
    let is_above_surface = wi.dot(ng) * wo.dot(ng) > 0.0;
    if is_above_surface { (wi.normalize(), false) } else { (mirrored(ng).normalize(), true) }
}
