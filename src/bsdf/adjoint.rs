//! The adjoint factor of shading normals (Veach 1997, section 5.3), in one place.
//!
//! A shading normal replaces |wi · ng| by |wi · ns| in what a camera walk integrates. A walk from a light carries flux over
//! true areas and must make up for it.

use super::BsdfSample;
use glam::Vec3;

impl BsdfSample {
    /// What a walk from a light is multiplied by besides the weight, with `wo` to where it came from: [`shading_normal_factor`], or 1 where
    /// the shading normal had no part in it. (That quotient is not what such light is due, and under steep normals its denominator passes
    /// through zero, so that its mean is infinite.)
    #[inline]
    #[must_use]
    pub fn adjoint(&self, wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        if self.flat { 1.0 } else { shading_normal_factor(wo, self.wi, ns, ng) }
    }
}

/// The factor by which a walk from a light is multiplied at a scattering, with `wo` to where it came from.
#[inline]
#[must_use]
pub fn shading_normal_factor(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let denominator = wo.dot(ng) * wi.dot(ns);
    if denominator == 0.0 { 0.0 } else { (wo.dot(ns) * wi.dot(ng) / denominator).abs() }
}

/// The factor for flux that is stored at a surface to be gathered there: what a camera walk sees is the irradiance by the
/// shading normal, while photons land by the geometric one.
#[inline]
#[must_use]
pub fn deposit_factor(wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let landed = wo.dot(ng);
    if landed == 0.0 { 0.0 } else { (wo.dot(ns) / landed).abs() }
}
