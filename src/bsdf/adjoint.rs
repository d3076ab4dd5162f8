//! Corrections of photon paths at shading normals (Veach 1997, section 5.3).
//!
//! `ns` is the shading normal and `ng` the geometric normal. Camera paths weight light from
//! direction `wi` by |wi · ns| instead of |wi · ng|. Photon paths carry flux through the true
//! surface, so their throughput needs a correction.

use super::BsdfSample;
use glam::Vec3;

impl BsdfSample {
    /// Returns the factor by which a photon path's throughput is multiplied in addition to
    /// [`weight`](Self::weight). It corrects the path for the shading normal.
    ///
    /// The factor is [`shading_normal_correction`], or 1 if
    /// [`uses_geometric_normal`](Self::uses_geometric_normal) is set. The unit vector `wo` points
    /// to the previous vertex of the path. `ns` is the shading normal, `ng` the geometric normal.
    #[inline]
    #[must_use]
    pub fn adjoint_correction(&self, wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
        if self.uses_geometric_normal { 1.0 } else { shading_normal_correction(wo, self.wi, ns, ng) }
    }
}

/// Returns the factor that corrects the throughput of a photon path for the shading normal `ns`.
///
/// The factor is |wo · ns| |wi · ng| / (|wo · ng| |wi · ns|), or 0 if the denominator is 0. The
/// unit vector `wo` points to the previous vertex of the photon path, and `wi` to the next one.
/// `ng` is the geometric normal.
#[inline]
#[must_use]
pub fn shading_normal_correction(wo: Vec3, wi: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let denominator = wo.dot(ng) * wi.dot(ns);
    if denominator == 0.0 { 0.0 } else { (wo.dot(ns) * wi.dot(ng) / denominator).abs() }
}

/// Returns the factor on a stored photon's flux that shading normals require:
/// |wo · ns| / |wo · ng|, or 0 if the denominator is 0.
///
/// The unit vector `wo` points back along the photon path. `ns` is the shading normal of the
/// surface, `ng` the geometric normal. The density of photons is proportional to |wo · ng|, but the
/// radiance estimate needs the irradiance on a surface with normal `ns`.
#[inline]
#[must_use]
pub fn deposit_shading_normal_correction(wo: Vec3, ns: Vec3, ng: Vec3) -> f32 {
    if ns == ng {
        return 1.0;
    }
    let cos = wo.dot(ng);
    if cos == 0.0 { 0.0 } else { (wo.dot(ns) / cos).abs() }
}
