//! Smooth dielectric interfaces.

use super::{BsdfSample, Transport, refract};
use crate::color::Rgb;
use glam::Vec3;

/// A smooth interface; the normal points to the outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index inside over index outside.
    pub eta: f32,
}

/// The two continuations of a walk at a dielectric, each with the weight it carries when both are followed.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// The mirrored direction and its share.
    pub reflected: (Vec3, f32),
    /// The refracted direction and its share; the share is zero under total reflection.
    pub transmitted: (Vec3, f32),
    /// What the transmitted radiance is divided by: (n_near/n_far)² for radiance, 1 for flux.
    pub squeeze: f32,
}

impl Dielectric {
    /// Both continuations from direction `wo`.
    #[inline]
    #[must_use]
    pub fn split(&self, wo: Vec3, ns: Vec3, ng: Vec3, transport: Transport) -> Split {
        let outside = wo.dot(ng) >= 0.0;
        let (near_ns, near_ng, eta) = if outside { (ns, ng, self.eta) } else { (-ns, -ng, 1.0 / self.eta) };
        // Where the shading normal would send light through the wrong side, the surface is taken as it is.
        let n = if wo.dot(near_ns) > 0.0 { near_ns } else { near_ng };
        let mut bent = refract(wo, n, eta);
        if bent.reflectance < 1.0 && bent.transmitted.dot(near_ng) >= 0.0 {
            bent = refract(wo, near_ng, eta);
        }
        let squeeze = match transport {
            Transport::Radiance => eta * eta,
            Transport::Importance => 1.0,
        };
        Split {
            reflected: (reflect_above(wo, near_ns, ng), bent.reflectance),
            transmitted: (bent.transmitted, 1.0 - bent.reflectance),
            squeeze,
        }
    }

    /// One continuation, chosen by its share.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, ns: Vec3, ng: Vec3, lobe: f32, transport: Transport) -> BsdfSample {
        let split = self.split(wo, ns, ng, transport);
        if lobe < split.reflected.1 {
            BsdfSample { wi: split.reflected.0, weight: Rgb::ONE, pdf: 0.0, specular: true, transmitted: false }
        } else {
            let weight = Rgb::splat(1.0 / split.squeeze);
            BsdfSample { wi: split.transmitted.0, weight, pdf: 0.0, specular: true, transmitted: true }
        }
    }
}

/// The mirror image of `wo` about `ns`, or about `ng` where the former would dive below the surface.
#[inline]
pub(super) fn reflect_above(wo: Vec3, ns: Vec3, ng: Vec3) -> Vec3 {
    let mirrored = |n: Vec3| n * (2.0 * wo.dot(n)) - wo;
    let wi = mirrored(ns);
    let same_side = wi.dot(ng) * wo.dot(ng) > 0.0;
    if same_side { wi.normalize() } else { mirrored(ng).normalize() }
}
