//! Which places matter to the picture.

use super::{Bandwidth, Kernel, Photon, PhotonMap, Scratch};
use crate::color::Rgb;
use crate::math::Bounds;
use glam::Vec3;

/// Where a camera walk ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisiblePoint {
    /// Place.
    pub position: Vec3,
    /// Unit geometric normal on the seen side.
    pub normal: Vec3,
    /// How much the picture changes with the irradiance there: the walk's throughput times the BRDF, up to a factor common to
    /// all points.
    pub weight: f32,
}

/// VisiblePointMap points indexed by place.
///
/// They are the importons of Peter and Pietrek (1998, "Importance driven construction of photon maps"), for surfaces seen
/// directly.
#[derive(Debug)]
pub struct VisiblePointMap {
    points: PhotonMap,
    bandwidth: Bandwidth,
    /// Where searches begin: few places are denser.
    dense: f32,
}

/// Points whose density is the importance.
const NEIGHBOURS: u32 = 16;

/// Points at which their distances are measured.
const PROBES: usize = 256;

impl VisiblePointMap {
    /// Indexes points. Whatever lies within `radius` \[length] of one, on its side of the surface, matters: that should be the radius
    /// within which photons are gathered. It is widened where points are too sparse to cover what they stand for. Points that
    /// are not finite, or without weight, are left out.
    #[must_use]
    pub fn new(points: impl IntoIterator<Item = VisiblePoint>, radius: f32) -> Self {
        let point = |p: VisiblePoint| Photon::new(p.position, Rgb::splat(p.weight * p.weight), p.normal, p.normal);
        let stored: Vec<Photon> = points.into_iter().filter_map(point).collect();
        let size = Bounds::of(stored.iter().map(|p| p.position)).extent().length();
        let probes: Vec<Photon> = stored.iter().step_by(stored.len().div_ceil(PROBES).max(1)).copied().collect();
        let points = PhotonMap::build(stored);
        let spacing = |p: &Photon| points.kth_distance(p.position, p.data.normal().normalize(), NEIGHBOURS, size);
        let mut spacings: Vec<f32> = probes.iter().filter_map(spacing).collect();
        spacings.sort_by(f32::total_cmp);
        let typical = spacings.get(spacings.len() / 2).copied().unwrap_or(0.0);
        let dense = spacings.get(spacings.len() / 10).copied().unwrap_or(0.0);
        Self { points, bandwidth: Bandwidth { radius: radius.max(typical), k: NEIGHBOURS }, dense }
    }

    /// The sum of squared weights per area around a point of a surface with unit geometric `normal` on the lit side.
    ///
    /// A photon of flux Φ changes the irradiance at the n points around it by ΦK each, so it adds Φ² times this, and a factor
    /// that depends on the kernel alone, to the sum of the squared changes of the picture.
    #[inline]
    #[must_use]
    pub fn importance(&self, p: Vec3, normal: Vec3, scratch: &mut Scratch) -> f32 {
        // Photons land here and there, so the last search tells nothing of the next.
        scratch.begin_with(self.dense);
        self.points.estimate(p, normal, self.bandwidth, Kernel::Box, scratch, |_| Rgb::ONE).radiance.x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Dimension, Key, Purpose, sobol_2d};

    /// 4096 points of weight 3 on the unit square of the floor, seen from above.
    fn floor(radius: f32) -> VisiblePointMap {
        let key = Key::new(4).purpose(Purpose::Test);
        let point = |i| {
            let u = sobol_2d(i, key, Dimension::Film);
            VisiblePoint { position: Vec3::new(u.x, 0.0, u.y), normal: Vec3::Y, weight: 3.0 }
        };
        VisiblePointMap::new((0..4096).map(point), radius)
    }

    #[test]
    fn importance_is_squared_weight_per_area_on_the_seen_side() {
        let visible = floor(0.05);
        let at = |x: f32, y: f32, normal: Vec3| visible.importance(Vec3::new(x, y, 0.5), normal, &mut Scratch::new());
        // Distances to 16th neighbours scatter by 1/√16; the mean of 64 by an eighth of that: five sigma.
        let mean = (0..64).map(|i| at(0.2 + 0.01 * i as f32, 0.0, Vec3::Y)).sum::<f32>() / 64.0;
        assert!((mean / (9.0 * 4096.0) - 1.0).abs() < 5.0 / 32.0, "{mean}");
        assert_eq!(at(0.5, 0.0, Vec3::NEG_Y), 0.0);
        assert_eq!(at(0.5, 0.1, Vec3::Y), 0.0);
        assert_eq!(at(1.1, 0.0, Vec3::Y), 0.0);
        assert!(at(1.01, 0.0, Vec3::Y) > 0.0, "what is gathered beyond the last point matters");
    }

    #[test]
    fn points_cover_what_they_stand_for_however_small_the_radius() {
        let visible = floor(1e-6);
        for i in 0..64 {
            let p = Vec3::new(0.2 + 0.01 * i as f32, 0.0, 0.5);
            assert!(visible.importance(p, Vec3::Y, &mut Scratch::new()) > 0.0);
        }
    }

    #[test]
    fn nothing_visible_nothing_matters() {
        let lost = VisiblePoint { position: Vec3::NAN, normal: Vec3::Y, weight: 1.0 };
        let dark = VisiblePoint { position: Vec3::ZERO, normal: Vec3::Y, weight: 0.0 };
        let visible = VisiblePointMap::new([lost, dark], 1.0);
        assert_eq!(visible.importance(Vec3::ZERO, Vec3::Y, &mut Scratch::new()), 0.0);
    }
}
