//! The photon map: a kd-tree of crate kiddo.

use super::{Photon, PhotonData};
use crate::math::morton_order;
use glam::{Mat3, Vec3};
use kiddo::leaf_strategy::VecOfArenas;
use kiddo::{Eytzinger, KdTree, SquaredEuclidean};
use rayon::prelude::*;

const BUCKET: usize = 32;

type Tree = KdTree<f32, PhotonData, Eytzinger, VecOfArenas<f32, PhotonData, 3, BUCKET>, 3, BUCKET>;

/// Photons indexed by place.
///
/// kiddo cycles through the axes by depth and would waste every third split on an axis-aligned wall, so places are turned by a
/// fixed rotation that aligns with nothing, on insertion and on query.
pub struct PhotonMap {
    tree: Option<Tree>,
    len: usize,
    /// Least radius of an estimate over its nearest photons \[length].
    pub(super) least: f32,
}

impl std::fmt::Debug for PhotonMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PhotonMap").field("len", &self.len).finish()
    }
}

/// A rotation about (1, 2, 3)/√14 by 0.7 rad, rounded to f32.
const TURN: Mat3 = Mat3::from_cols(
    Vec3::new(0.781_639_2, 0.550_117_2, -0.293_957_9),
    Vec3::new(-0.482_929_3, 0.832_030_1, 0.272_956_3),
    Vec3::new(0.394_739_8, -0.071_392_5, 0.916_015_1),
);

/// Photons that share one place bit for bit, beyond a bucket's worth, are merged: kiddo must keep them in one leaf.
const MOST_ALIKE: usize = BUCKET;

impl PhotonMap {
    /// Indexes photons. The result does not depend on the number of threads.
    #[must_use]
    pub fn build(mut photons: Vec<Photon>) -> Self {
        photons.par_iter_mut().for_each(|p| p.position = TURN * p.position);
        // Along a curve the build and the leaves are coherent.
        let order = morton_order(&photons, |p| p.position);
        photons = order.par_iter().map(|i| photons[*i as usize]).collect();
        merge_alike(&mut photons);
        let len = photons.len();
        let at = |p: &Photon, axis: usize| p.position[axis];
        // Construction fails only for mutable trees and for generated indices; neither is used here.
        let tree =
            if photons.is_empty() { None } else { Tree::new_from_source_parallel(&photons, at, |_, p| p.data).ok() };
        Self { tree, len, least: 0.0 }
    }

    /// The same map, where estimates over the nearest photons take all within `least` \[length] instead where they are nearer than that:
    /// the nearest of light that meets in a point tell only how near the point is.
    #[must_use]
    pub fn with_least(self, least: f32) -> Self {
        Self { least, ..self }
    }

    /// How many photons are stored.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether no photon is stored.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Visits every photon within `radius` of `p` with its flux and squared distance. Allocates nothing.
    #[inline]
    pub fn visit(&self, p: Vec3, radius: f32, mut visitor: impl FnMut(&PhotonData, f32)) {
        let Some(tree) = &self.tree else { return };
        if !p.is_finite() {
            return;
        }
        tree.query(&(TURN * p).to_array())
            .within::<SquaredEuclidean<f32>>(radius * radius)
            .unsorted()
            .visit(|found| visitor(&found.item, found.distance));
    }
}

/// Replaces crowds at one place and on one side by a single photon of their summed flux and mean direction.
fn merge_alike(photons: &mut Vec<Photon>) {
    let crowded = photons.chunk_by(|a, b| a.position == b.position).any(|run| run.len() > MOST_ALIKE);
    // Equal places share a Morton cell but need not be adjacent in it; a crowd large enough to matter fills its cell.
    if !crowded {
        return;
    }
    let mut merged: Vec<Photon> = Vec::with_capacity(photons.len());
    for run in photons.chunk_by(|a, b| a.position == b.position) {
        if run.len() <= MOST_ALIKE {
            merged.extend_from_slice(run);
            continue;
        }
        let mut run = run.to_vec();
        run.sort_by_key(|p| p.data.side());
        for side in run.chunk_by(|a, b| a.data.side() == b.data.side()) {
            let flux: glam::DVec3 = side.iter().map(|p| p.data.flux().as_dvec3()).sum();
            let from: Vec3 = side.iter().map(|p| p.data.from() * p.data.flux().element_sum()).sum();
            let normal = side[0].data.normal().normalize();
            let position = side[0].position;
            // The place is already turned; the plane's offset is that of the crowd.
            let photon = Photon::new(position, flux.as_vec3(), from.normalize_or(normal), normal);
            merged.extend(photon.map(|p| Photon { position, data: p.data.at_offset_of(&side[0].data) }));
        }
    }
    *photons = merged;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::sampling::{Dimension, Key, Purpose};

    fn photon(position: Vec3, power: f32) -> Photon {
        Photon::new(position, Rgb::splat(power), Vec3::Z, Vec3::Z).unwrap()
    }

    fn random(n: u64, place: impl Fn(Vec3) -> Vec3) -> Vec<Photon> {
        let draw = |i| {
            let key = Key::new(2).purpose(Purpose::Test).with(i);
            place(key.uniform_2d(Dimension::LightPosition).extend(key.uniform(Dimension::Light)))
        };
        (0..n).map(|i| photon(draw(i), 1.0)).collect()
    }

    fn count(map: &PhotonMap, p: Vec3, r: f32) -> usize {
        let mut n = 0;
        map.visit(p, r, |_, _| n += 1);
        n
    }

    #[test]
    fn the_turn_is_a_rotation() {
        let identity = TURN.transpose() * TURN;
        assert!(identity.abs_diff_eq(Mat3::IDENTITY, 3e-7), "{identity}");
        assert!((TURN.determinant() - 1.0).abs() < 3e-7);
    }

    #[test]
    fn nothing_and_one_photon() {
        let empty = PhotonMap::build(Vec::new());
        assert!(empty.is_empty() && count(&empty, Vec3::ZERO, 1e9) == 0);
        let one = PhotonMap::build(vec![photon(Vec3::ONE, 1.0)]);
        assert_eq!((one.len(), count(&one, Vec3::ONE, 0.1), count(&one, Vec3::ZERO, 0.1)), (1, 1, 0));
    }

    /// Against a plain scan: photons are found exactly, give or take those within rounding of the rim.
    #[test]
    fn queries_find_what_a_scan_finds() {
        let layouts: [fn(Vec3) -> Vec3; 4] =
            [|u| u, |u| Vec3::new(u.x, 0.25, u.y), |u| Vec3::new(u.x, 0.5, 0.5), |u| (u * 4.0).floor() * 0.25];
        for layout in layouts {
            let photons = random(20_000, layout);
            let map = PhotonMap::build(photons.clone());
            let expected = photons.len();
            let kept = map.len();
            assert!(kept == expected || expected - kept > 1000, "only crowds are merged");
            for (i, r) in [(3usize, 0.05f32), (777, 0.2), (9999, 0.011)] {
                let p = photons[i].position;
                let mut power = 0.0;
                map.visit(p, r, |data, _| power += data.flux().x);
                let scan = |r: f32| photons.iter().filter(|q| (q.position - p).length() <= r).count() as f32;
                assert!(power >= scan(r - 1e-5) * 0.9999 && power <= scan(r + 1e-5) * 1.0001, "{power} {}", scan(r));
            }
        }
    }

    #[test]
    fn a_million_photons_on_one_wall() {
        let map = PhotonMap::build(random(1_000_000, |u| Vec3::new(u.x, 0.0, u.y)));
        assert_eq!(map.len(), 1_000_000);
        let n = count(&map, Vec3::new(0.5, 0.0, 0.5), 0.1);
        let expected = 1e6 * std::f64::consts::PI * 0.01;
        assert!((n as f64 - expected).abs() < 5.0 * expected.sqrt(), "{n}");
    }

    #[test]
    fn a_crowd_at_one_point_is_one_photon_of_its_whole_power() {
        let mut photons = vec![photon(Vec3::splat(0.3), 2.0); 100_000];
        photons.extend(random(1000, |u| u));
        let map = PhotonMap::build(photons);
        assert_eq!(map.len(), 1001);
        let mut power = 0.0;
        map.visit(Vec3::splat(0.3), 1e-4, |data, d2| {
            assert_eq!(d2, 0.0);
            power += data.flux().x;
        });
        assert!((power / 200_000.0 - 1.0).abs() < 1e-5);
    }
}
