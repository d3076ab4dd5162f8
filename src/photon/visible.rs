//! Importance of photons for the picture, estimated from the density of surface points that the
//! camera sees.

use super::{Bandwidth, Kernel, Photon, PhotonMap, PhotonSearchBuffers};
use crate::color::Rgb;
use crate::math::Bounds;
use glam::Vec3;
use rayon::prelude::*;

/// Surface point that a camera path reaches, with its importance for the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisiblePoint {
    /// World-space position of the point on the surface.
    pub position: Vec3,
    /// Upper bound of the rounding error of `position` along each axis \[length].
    pub position_error: Vec3,
    /// Unit geometric normal on the side from which photons count.
    pub normal: Vec3,
    /// Importance of the point: camera path throughput times BSDF \[1/sr], averaged over RGB. This
    /// is the radiance that the pixel gains per irradiance at the point, up to a factor that is
    /// equal for all points.
    pub weight: f32,
}

/// Surface points that the camera sees, in a kd-tree. From them follows how important a photon is
/// for the picture: its importance is large near many of these points of large weight.
///
/// Visible points correspond to the importons of Peter and Pietrek 1998, "Importance Driven
/// Construction of Photon Maps".
#[derive(Debug)]
pub struct VisiblePointMap {
    /// Visible points, stored as photons. The flux of such a photon is the squared weight of the
    /// point.
    points: PhotonMap,
    bandwidth: Bandwidth,
    /// Distance \[length] at which a search expects the 16th nearest visible point; the search
    /// begins with 1.25 times this distance. For one visible point in ten, the 16th neighbour is
    /// nearer.
    expected_kth_distance: f32,
}

/// Largest number of nearest visible points from which the importance of a photon is estimated.
const NEIGHBOURS: u32 = 16;

/// Number of visible points, at most, at which the distance to the 16th nearest neighbour is
/// measured. The first search radius is derived from these distances.
const MAX_RADIUS_SAMPLES: usize = 256;

impl VisiblePointMap {
    /// Builds the map of visible `points`.
    ///
    /// `radius` \[length] is the radius of the render's density estimates. A photon has importance
    /// if a visible point lies within this radius, on the photon's side of the surface. If the
    /// visible points are sparse, the radius grows to the median distance of their 16th neighbours.
    /// Points with zero weight or non-finite position are left out.
    #[must_use]
    pub fn new(points: impl IntoIterator<Item = VisiblePoint>, radius: f32) -> Self {
        let point = |p: VisiblePoint| Photon::new(p.position, Rgb::splat(p.weight * p.weight), p.normal, p.normal);
        let stored: Vec<Photon> = points.into_iter().filter_map(point).collect();
        let diagonal = Bounds::from_points(stored.iter().map(|p| p.position)).extent().length();
        let radius_samples: Vec<Photon> =
            stored.iter().step_by(stored.len().div_ceil(MAX_RADIUS_SAMPLES).max(1)).copied().collect();
        let points = PhotonMap::build(stored);
        let spacing = |p: &Photon| {
            points.kth_photon_distance(p.position, p.attributes.normal().normalize(), NEIGHBOURS, diagonal)
        };
        let mut spacings: Vec<f32> = radius_samples.par_iter().filter_map(spacing).collect();
        spacings.sort_by(f32::total_cmp);
        let median_spacing = spacings.get(spacings.len() / 2).copied().unwrap_or(0.0);
        let first_search_radius = spacings.get(spacings.len() / 10).copied().unwrap_or(0.0);
        Self {
            points,
            bandwidth: Bandwidth { radius: radius.max(median_spacing), k: NEIGHBOURS },
            expected_kth_distance: first_search_radius,
        }
    }

    /// Returns the importance of photons at `p`: the sum of squared weights of the visible points
    /// near `p`, per area \[1/length²].
    ///
    /// Only visible points on the side of the unit geometric `normal` count. The squared
    /// contribution of a photon of flux Φ to the picture is proportional to Φ² times this
    /// importance.
    #[inline]
    #[must_use]
    pub fn squared_photon_importance(&self, p: Vec3, normal: Vec3, scratch: &mut PhotonSearchBuffers) -> f32 {
        // Consecutive photons are far apart, so the radius of the last search is a poor start.
        scratch.set_expected_kth_distance(self.expected_kth_distance);
        self.points.estimate_radiance(p, normal, self.bandwidth, Kernel::Box, scratch, |_| Rgb::ONE).radiance.x
    }
}

#[cfg(test)]
mod tests;
