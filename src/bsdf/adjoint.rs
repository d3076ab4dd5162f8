//! Corrections of light paths at shading normals (Veach 1997, section 5.3).
//!
//! A shading normal replaces |wi · ng| by |wi · ns| in the integrand of camera paths. Light paths
//! carry flux over true areas, so their throughput needs a correction.

use super::BsdfSample;
use glam::Vec3;

impl BsdfSample {
    /// Factor of a light path's throughput, to be multiplied by [`weight`](Self::weight).
    ///
    /// The factor is [`shading_normal_correction`], or 1 if the sample was scattered by the
    /// geometric normal.
    #[inline]
    #[must_use]
    pub fn adjoint_correction(&self, wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        if self.uses_geometric_normal { 1.0 } else { shading_normal_correction(wo, self.wi, ns, ng) }
    }
}

/// Factor of a light path's throughput that corrects for shading normals:
/// |wo · ns| |wi · ng| / (|wo · ng| |wi · ns|).
///
/// The unit vector `wo` points to the previous vertex of the light path, `wi` to the next one.
#[inline]
#[must_use]
pub fn shading_normal_correction(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let denominator = wo.dot(ng) * wi.dot(ns);
    if denominator == 0.0 { 0.0 } else { (wo.dot(ns) * wi.dot(ng) / denominator).abs() }
}

/// Factor of the flux of a photon stored at a surface: |wo · ns| / |wo · ng|.
///
/// The density of photons is proportional to |wo · ng|, but the radiance estimate needs the
/// irradiance with respect to the shading normal. The unit vector `wo` points to the photon's
/// origin.
#[inline]
#[must_use]
pub fn photon_deposit_factor(wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let cos = wo.dot(ng);
    if cos == 0.0 { 0.0 } else { (wo.dot(ns) / cos).abs() }
}
