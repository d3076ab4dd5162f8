//! The adjoint factor of shading normals (Veach 1997, section 5.3).
//!
//! A shading normal replaces |wi · ng| by |wi · ns| in the integrand of camera paths. Light paths
//! carry flux over true areas, so this factor must correct them.

use super::BsdfSample;
use glam::Vec3;

impl BsdfSample {
    /// Factor of a light path's throughput besides `weight`, with `wo` to the previous vertex.
    ///
    /// The factor is [`shading_normal_correction`], or 1 if the shading normal took no part. In the
    /// latter case the quotient would be wrong, and its mean infinite under steep normals.
    #[inline]
    #[must_use]
    pub fn adjoint_correction(&self, wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        if self.uses_geometric_normal { 1.0 } else { shading_normal_correction(wo, self.wi, ns, ng) }
    }
}

/// Factor of a light path's throughput at a scattering event, with `wo` to the previous vertex.
#[inline]
#[must_use]
pub fn shading_normal_correction(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let denominator = wo.dot(ng) * wi.dot(ns);
    if denominator == 0.0 { 0.0 } else { (wo.dot(ns) * wi.dot(ng) / denominator).abs() }
}

/// Factor of flux that is stored at a surface.
///
/// Density estimates need the irradiance by the shading normal, but photons land by the geometric
/// normal.
#[inline]
#[must_use]
pub fn photon_deposit_factor(wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let landed = wo.dot(ng);
    if landed == 0.0 { 0.0 } else { (wo.dot(ns) / landed).abs() }
}
