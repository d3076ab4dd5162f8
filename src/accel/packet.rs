//! Packets of triangles and their watertight intersection.

use super::ShapeHit;
use super::ray_precalc::RayPrecalc;
use glam::{DVec3, Vec3};
use wide::f32x8;

/// Number of triangles in a packet: one in each SIMD lane.
pub(super) const LANES: usize = 8;

/// Up to [`LANES`] triangles, which are tested against a ray together by SIMD instructions.
///
/// Unused lanes hold NaN, which fails every comparison.
#[repr(C)]
pub(super) struct TrianglePacket {
    /// Coordinates of the corners, as `corners[axis][corner]`.
    corners: [[f32x8; 3]; 3],
    /// Index of the triangle in each lane; `u32::MAX` for unused lanes.
    indices: [u32; LANES],
}

/// Hit on a triangle or on another primitive, with barycentric weights that are not normalized yet.
#[derive(Clone, Copy)]
pub(super) struct LeafHit {
    /// Ray parameter t for the scaled direction of [`RayPrecalc`]; it may have any sign.
    pub t: f32,
    /// Barycentric weights of a triangle's second and third corner, times `weight_sum`. The
    /// division by `weight_sum` is postponed, because most hits are discarded.
    ///
    /// For a primitive other than a triangle, the two numbers are the `shape_coords` of its
    /// [`ShapeHit`].
    pub unnormalized_weights: [f64; 2],
    /// Sum of the weights of all three corners, by which `unnormalized_weights` are divided at the
    /// end. For a primitive other than a triangle, the sum is 1, so that its shape coordinates do
    /// not change.
    pub weight_sum: f64,
}

impl LeafHit {
    /// Converts the hit on a primitive other than a triangle, with its ray parameter for the
    /// unscaled direction.
    #[inline]
    pub fn of_other_primitive(ShapeHit { t, shape_coords: uv }: ShapeHit, precalc: &RayPrecalc) -> Self {
        Self {
            t: t * precalc.inverse_direction_scale,
            unnormalized_weights: uv.to_array().map(f64::from),
            weight_sum: 1.0,
        }
    }

    /// Normalized barycentric weights of a triangle's second and third corner. For another
    /// primitive, the `shape_coords` of its hit.
    #[inline]
    pub fn barycentric(&self) -> (f32, f32) {
        (
            (self.unnormalized_weights[0] / self.weight_sum) as f32,
            (self.unnormalized_weights[1] / self.weight_sum) as f32,
        )
    }
}

impl TrianglePacket {
    /// Packet of at most [`LANES`] triangles: the elements of `triangles` with the indices
    /// `members`.
    pub fn new(triangles: &[[Vec3; 3]], members: &[u32]) -> Self {
        let coordinate = |axis: usize, corner: usize| {
            let mut lanes = [f32::NAN; LANES];
            for (lane, &index) in lanes.iter_mut().zip(members) {
                *lane = triangles[index as usize][corner][axis];
            }
            f32x8::from(lanes)
        };
        let mut indices = [u32::MAX; LANES];
        indices[..members.len()].copy_from_slice(members);
        Self { corners: std::array::from_fn(|a| std::array::from_fn(|c| coordinate(a, c))), indices }
    }

    /// Calls `found` with the index and the hit of each triangle that the infinite line of the ray
    /// meets.
    ///
    /// The ray parameter of a hit may be negative or beyond `t_max`.
    #[inline]
    pub fn for_each_line_hit(&self, precalc: &RayPrecalc, mut found: impl FnMut(u32, LeafHit)) {
        let mut lanes = self.candidate_lanes(precalc);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if let Some(hit) = self.intersect_lane(lane, precalc) {
                found(self.indices[lane], hit);
            }
        }
    }

    /// Bit mask of the lanes whose triangle the infinite line of the ray may hit. The test is
    /// conservative and runs in f32.
    ///
    /// The sign of an edge function tells on which side of an edge the line passes. A lane is left
    /// out if two edge functions have opposite signs. The mask thus contains all hits, and near
    /// misses whose edge functions round to zero. Without fused operations, rounding may lose the
    /// sign of an edge function, but never reverses it.
    #[inline]
    pub fn candidate_lanes(&self, precalc: &RayPrecalc) -> u32 {
        let [ax, ay, az] = precalc.axis_permutation;
        let [px, py, pz] = [&self.corners[ax], &self.corners[ay], &self.corners[az]];
        let ox = f32x8::splat(precalc.origin[ax]);
        let oy = f32x8::splat(precalc.origin[ay]);
        let oz = f32x8::splat(precalc.origin[az]);
        let (sx, sy) = (f32x8::splat(precalc.shear[0]), f32x8::splat(precalc.shear[1]));
        let z = [pz[0] - oz, pz[1] - oz, pz[2] - oz];
        let x = [px[0] - ox - sx * z[0], px[1] - ox - sx * z[1], px[2] - ox - sx * z[2]];
        let y = [py[0] - oy - sy * z[0], py[1] - oy - sy * z[1], py[2] - oy - sy * z[2]];
        let u = x[2] * y[1] - y[2] * x[1];
        let v = x[0] * y[2] - y[0] * x[2];
        let w = x[1] * y[0] - y[1] * x[0];
        let low = u.fast_min(v).fast_min(w);
        let high = u.fast_max(v).fast_max(w);
        (low.simd_ge(f32x8::ZERO) | high.simd_le(f32x8::ZERO)).to_bitmask()
    }

    /// Hit on the triangle in `lane` by the infinite line of the ray; t may have any sign.
    ///
    /// The corners are sheared in f32 so that the ray becomes the z axis, exactly as in
    /// [`candidate_lanes`](Self::candidate_lanes). Products of these coordinates are exact in f64,
    /// so each edge function has the right sign. Therefore a ray through a common edge cannot miss
    /// both triangles.
    #[inline]
    pub fn intersect_lane(&self, lane: usize, precalc: &RayPrecalc) -> Option<LeafHit> {
        let [ax, ay, az] = precalc.axis_permutation;
        let [px, py, pz] = [&self.corners[ax], &self.corners[ay], &self.corners[az]];
        let [ox, oy, oz] = [precalc.origin[ax], precalc.origin[ay], precalc.origin[az]];
        let [sx, sy] = precalc.shear;
        let corner = |c: usize| {
            let at = |p: &[f32x8; 3]| p[c].as_array()[lane & (LANES - 1)];
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
        // The sum of the edge functions is multiplied by the z component of the ray's direction, so
        // that one division gives t.
        let volume = (u + v + w) * precalc.permuted_direction_z;
        let t = (u * a.z + v * b.z + w * c.z) / volume;
        (volume != 0.0).then_some(LeafHit { t: t as f32, unnormalized_weights: [v, w], weight_sum: u + v + w })
    }

    /// True if the ray hits a triangle of the packet at a ray parameter in (0, `t_max`).
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
