//! Packets of triangles and their watertight intersection.

use super::ray_precalc::RayPrecalc;
use glam::{DVec3, Vec3};
use wide::f32x8;

/// Number of triangles in a packet, one per SIMD lane.
pub(super) const LANES: usize = 8;

type Lane = f32x8;

/// Up to [`LANES`] triangles that are tested together.
///
/// Unused lanes hold NaN, which fails every comparison.
#[repr(C)]
pub(super) struct TrianglePacket {
    /// Coordinates of the corners, as `corners[axis][corner]`.
    corners: [[Lane; 3]; 3],
    indices: [u32; LANES],
}

/// Hit of a triangle or another primitive in a leaf.
///
/// For another primitive, `weights` are two numbers that the caller's closure returned, and `total`
/// is 1.
#[derive(Clone, Copy)]
pub(super) struct LeafHit {
    /// Ray parameter t of any sign, which refers to the scaled direction of [`RayPrecalc`].
    pub t: f32,
    /// Barycentric weights of the second and third corner, times `total`.
    ///
    /// The division by `total` is postponed, since few hits are used.
    pub weights: [f64; 2],
    /// Sum of the weights of all three corners before normalisation.
    pub total: f64,
}

impl LeafHit {
    #[inline]
    pub fn barycentric(&self) -> (f32, f32) {
        ((self.weights[0] / self.total) as f32, (self.weights[1] / self.total) as f32)
    }
}

impl TrianglePacket {
    pub fn new(triangles: &[[Vec3; 3]], members: &[u32]) -> Self {
        let coordinate = |axis: usize, corner: usize| {
            let mut lanes = [f32::NAN; LANES];
            for (lane, &index) in lanes.iter_mut().zip(members) {
                *lane = triangles[index as usize][corner][axis];
            }
            Lane::from(lanes)
        };
        let mut indices = [u32::MAX; LANES];
        indices[..members.len()].copy_from_slice(members);
        Self { corners: std::array::from_fn(|a| std::array::from_fn(|c| coordinate(a, c))), indices }
    }

    /// Calls `found` with index and hit of each triangle that the line of the ray hits.
    ///
    /// The ray parameter may be negative or beyond `t_max`.
    #[inline]
    pub fn for_each_hit(&self, precalc: &RayPrecalc, mut found: impl FnMut(u32, LeafHit)) {
        let mut lanes = self.candidate_lanes(precalc);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if let Some(hit) = self.intersect_lane(lane, precalc) {
                found(self.indices[lane], hit);
            }
        }
    }

    /// Bit mask of the lanes whose triangle the line of the ray may hit, by a test in f32.
    ///
    /// The mask contains all hits, and near misses whose edge functions round to zero. A lane is
    /// left out if two edge functions have opposite signs. Without fused operations, rounding may
    /// lose the sign of an edge function, but never reverses it.
    #[inline]
    pub fn candidate_lanes(&self, precalc: &RayPrecalc) -> u32 {
        let [ax, ay, az] = precalc.axes;
        let [px, py, pz] = [&self.corners[ax], &self.corners[ay], &self.corners[az]];
        let ox = Lane::splat(precalc.origin[ax]);
        let oy = Lane::splat(precalc.origin[ay]);
        let oz = Lane::splat(precalc.origin[az]);
        let (sx, sy) = (Lane::splat(precalc.shear[0]), Lane::splat(precalc.shear[1]));
        let z = [pz[0] - oz, pz[1] - oz, pz[2] - oz];
        let x = [px[0] - ox - sx * z[0], px[1] - ox - sx * z[1], px[2] - ox - sx * z[2]];
        let y = [py[0] - oy - sy * z[0], py[1] - oy - sy * z[1], py[2] - oy - sy * z[2]];
        let u = x[2] * y[1] - y[2] * x[1];
        let v = x[0] * y[2] - y[0] * x[2];
        let w = x[1] * y[0] - y[1] * x[0];
        let low = u.fast_min(v).fast_min(w);
        let high = u.fast_max(v).fast_max(w);
        (low.simd_ge(Lane::ZERO) | high.simd_le(Lane::ZERO)).to_bitmask()
    }

    /// Hit of the ray's line with the triangle in `lane`; `t` may have any sign.
    ///
    /// The corners are sheared in f32 so that the ray becomes the z axis, exactly as in
    /// [`candidate_lanes`](Self::candidate_lanes). Products of these coordinates are exact in f64,
    /// so each edge function has the right sign. Therefore a ray through a common edge cannot miss
    /// both triangles.
    #[inline]
    pub fn intersect_lane(&self, lane: usize, precalc: &RayPrecalc) -> Option<LeafHit> {
        let [ax, ay, az] = precalc.axes;
        let [px, py, pz] = [&self.corners[ax], &self.corners[ay], &self.corners[az]];
        let [ox, oy, oz] = [precalc.origin[ax], precalc.origin[ay], precalc.origin[az]];
        let [sx, sy] = precalc.shear;
        let corner = |c: usize| {
            let at = |p: &[Lane; 3]| p[c].as_array()[lane & (LANES - 1)];
            let z = at(pz) - oz;
            DVec3::new(f64::from(at(px) - ox - sx * z), f64::from(at(py) - oy - sy * z), f64::from(z))
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        // Scaled by the depth, so that one division gives `t`.
        let volume = (u + v + w) * precalc.depth;
        let t = (u * a.z + v * b.z + w * c.z) / volume;
        (volume != 0.0).then_some(LeafHit { t: t as f32, weights: [v, w], total: u + v + w })
    }

    /// True if a triangle is hit at `0 < t < t_max`.
    #[inline]
    pub fn any_hit(&self, precalc: &RayPrecalc) -> bool {
        let mut lanes = self.candidate_lanes(precalc);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if self.intersect_lane(lane, precalc).is_some_and(|c| 0.0 < c.t && c.t < precalc.t_max) {
                return true;
            }
        }
        false
    }
}
