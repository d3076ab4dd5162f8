//! Packets of triangles and their watertight intersection.

use super::ray_precalc::RayPrecalc;
use glam::{DVec3, Vec3};
use wide::f32x8;

/// Triangles in a packet.
pub(super) const LANES: usize = 8;

type Lane = f32x8;

/// Up to [`LANES`] triangles; lanes not in use hold NaN, which no comparison lets through.
#[repr(C)]
pub(super) struct Packet {
    /// Coordinates by axis, then by corner.
    corners: [[Lane; 3]; 3],
    indices: [u32; LANES],
}

/// Where a line meets a triangle.
#[derive(Clone, Copy)]
pub(super) struct Crossing {
    /// In the probe's units, of any sign.
    pub t: f32,
    /// Of the second and third corner, in parts of `total`: few crossings are worth the division.
    pub weights: [f64; 2],
    pub total: f64,
}

impl Crossing {
    #[inline]
    pub fn barycentric(&self) -> (f32, f32) {
        ((self.weights[0] / self.total) as f32, (self.weights[1] / self.total) as f32)
    }
}

impl Packet {
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

    /// Shows `found` the index of each triangle that a ray meets, and where.
    #[inline]
    pub fn hits(&self, probe: &RayPrecalc, mut found: impl FnMut(u32, Crossing)) {
        let mut lanes = self.candidates(probe);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if let Some(crossing) = self.hit(lane, probe) {
                found(self.indices[lane], crossing);
            }
        }
    }

    /// A mask of the lanes whose edge functions do not differ in sign: all that the ray's line meets, and those that it misses
    /// by so little that a difference of products rounds to zero.
    ///
    /// Rounding is monotone, so without fused operations a sign is never wrong, at worst lost.
    #[inline]
    pub fn candidates(&self, probe: &RayPrecalc) -> u32 {
        let [ax, ay, az] = probe.axes;
        let [px, py, pz] = [&self.corners[ax], &self.corners[ay], &self.corners[az]];
        let ox = Lane::splat(probe.origin[ax]);
        let oy = Lane::splat(probe.origin[ay]);
        let oz = Lane::splat(probe.origin[az]);
        let (sx, sy) = (Lane::splat(probe.shear[0]), Lane::splat(probe.shear[1]));
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

    /// Where the ray's line meets the triangle in `lane`: `t` in the probe's units, of any sign, and the weights of the second
    /// and third corner.
    ///
    /// The sheared corners are those of [`candidates`](Self::candidates), to the bit. Their products are exact in f64 and a
    /// difference of exact numbers keeps its sign and all but its last digit, so neighbours agree on their common edge and
    /// the hit lies on the triangle however thin it looks.
    #[inline]
    pub fn hit(&self, lane: usize, probe: &RayPrecalc) -> Option<Crossing> {
        let [ax, ay, az] = probe.axes;
        let [px, py, pz] = [&self.corners[ax], &self.corners[ay], &self.corners[az]];
        let [ox, oy, oz] = [probe.origin[ax], probe.origin[ay], probe.origin[az]];
        let [sx, sy] = probe.shear;
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
        // Times the depth, so that one division gives `t`.
        let volume = (u + v + w) * probe.depth;
        let t = (u * a.z + v * b.z + w * c.z) / volume;
        (volume != 0.0).then_some(Crossing { t: t as f32, weights: [v, w], total: u + v + w })
    }

    /// Whether any triangle meets the ray at `0 < t < t_max`.
    #[inline]
    pub fn any(&self, probe: &RayPrecalc) -> bool {
        let mut lanes = self.candidates(probe);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if self.hit(lane, probe).is_some_and(|c| 0.0 < c.t && c.t < probe.t_max) {
                return true;
            }
        }
        false
    }
}
