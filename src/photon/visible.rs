//! Importance of points for the picture.

use super::{Bandwidth, Kernel, Photon, PhotonMap, Scratch};
use crate::color::Rgb;
use crate::math::Bounds;
use glam::Vec3;

/// A point that a camera path sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisiblePoint {
    /// Position.
    pub position: Vec3,
    /// Unit geometric normal on the visible side.
    pub normal: Vec3,
    /// Derivative of the picture with respect to irradiance: throughput times BRDF, up to a common
    /// factor.
    pub weight: f32,
}

/// Visible points in a kd-tree; their density is the importance of photons.
///
/// Visible points are the importons of Peter and Pietrek 1998, "Importance driven construction
/// of photon maps", for directly visible surfaces.
#[derive(Debug)]
pub struct VisiblePointMap {
    points: PhotonMap,
    bandwidth: Bandwidth,
    /// First radius of searches: most points have a larger spacing \[length].
    dense: f32,
}

/// Number of nearest points per estimate.
const NEIGHBOURS: u32 = 16;

/// Number of points where the spacing is measured.
const PROBES: usize = 256;

impl VisiblePointMap {
    /// Builds the map. Photons count within `radius` \[length] of a point, on its side of the
    /// surface.
    ///
    /// `radius` is that of the photon estimates. It grows if the points are too sparse to cover the
    /// visible surfaces. Points that are not finite or have no weight are left out.
    #[must_use]
    pub fn new(points: impl IntoIterator<Item = VisiblePoint>, radius: f32) -> Self {
        let point = |p: VisiblePoint| Photon::new(p.position, Rgb::splat(p.weight * p.weight), p.normal, p.normal);
        let stored: Vec<Photon> = points.into_iter().filter_map(point).collect();
        let size = Bounds::from_points(stored.iter().map(|p| p.position)).extent().length();
        let probes: Vec<Photon> = stored.iter().step_by(stored.len().div_ceil(PROBES).max(1)).copied().collect();
        let points = PhotonMap::build(stored);
        let spacing =
            |p: &Photon| points.kth_photon_distance(p.position, p.data.normal().normalize(), NEIGHBOURS, size);
        let mut spacings: Vec<f32> = probes.iter().filter_map(spacing).collect();
        spacings.sort_by(f32::total_cmp);
        let typical = spacings.get(spacings.len() / 2).copied().unwrap_or(0.0);
        let dense = spacings.get(spacings.len() / 10).copied().unwrap_or(0.0);
        Self { points, bandwidth: Bandwidth { radius: radius.max(typical), k: NEIGHBOURS }, dense }
    }

    /// Sum of squared weights per area at `p`, on the side of the unit geometric `normal`.
    ///
    /// A photon of flux Φ changes the irradiance of the n points around it by ΦK each. It adds Φ²
    /// times this importance, times a factor of the kernel, to the sum of squared changes of the
    /// picture.
    #[inline]
    #[must_use]
    pub fn importance(&self, p: Vec3, normal: Vec3, scratch: &mut Scratch) -> f32 {
        // Consecutive photons are far apart: the last search radius is no good guess.
        scratch.set_first_radius(self.dense);
        self.points.estimate(p, normal, self.bandwidth, Kernel::Box, scratch, |_| Rgb::ONE).radiance.x
    }
}

#[cfg(test)]
mod tests;
