//! Packets of eight points or eight beam pieces, tested against a line with SIMD instructions.
//!
//! The tests are conservative: rounding errors may add points or pieces to the result, but never
//! remove them. The error bounds use γ(n) (Higham 2002, "Accuracy and Stability of Numerical
//! Algorithms", section 3.1) and assume unit directions.

use crate::math::{Ray, rounding_error_bound};
use glam::Vec3;
use wide::f32x8;

/// Number of points or beam pieces in a packet. SIMD instructions process all of them at once.
pub(super) const LANES: usize = 8;

/// Eight 3D vectors, one in each SIMD lane: the x, y and z components.
type Vec3x8 = [f32x8; 3];

/// Copies the vector `v` to all SIMD lanes.
fn broadcast_to_lanes(v: Vec3) -> Vec3x8 {
    v.to_array().map(f32x8::splat)
}

#[inline]
fn subtract(a: Vec3x8, b: Vec3x8) -> Vec3x8 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
fn dot(a: Vec3x8, b: Vec3x8) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross(a: Vec3x8, b: Vec3x8) -> Vec3x8 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns |x| + |y| + |z|, an upper bound of the length of `v`.
#[inline]
fn manhattan_length(v: Vec3x8) -> f32x8 {
    v[0].abs() + v[1].abs() + v[2].abs()
}

/// A query for all points or beams near a line: the line and the search radius, broadcast to all
/// SIMD lanes.
pub(super) struct LineQuery {
    origin: Vec3x8,
    direction: Vec3x8,
    radius: f32x8,
}

impl LineQuery {
    /// Creates the query for points or beams at most `radius` \[length] away from the infinite line
    /// through `ray`.
    pub fn new(ray: &Ray, radius: f32) -> Self {
        Self {
            origin: broadcast_to_lanes(ray.origin),
            direction: broadcast_to_lanes(ray.direction),
            radius: f32x8::splat(radius),
        }
    }
}

/// Iterates over the positions of the bits that are 1 in `mask`, lowest first.
#[inline]
pub(super) fn indices_of_set_bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let slot = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            slot
        })
    })
}

/// Positions of up to eight points; unused lanes hold infinity.
pub(super) struct PointPacket(Vec3x8);

impl PointPacket {
    /// Creates a packet of the first eight positions of `points`.
    pub fn new(points: impl Iterator<Item = Vec3>) -> Self {
        let mut packet = [f32x8::splat(f32::INFINITY); 3];
        for (slot, point) in points.take(LANES).enumerate() {
            for (axis, lanes) in packet.iter_mut().enumerate() {
                lanes.as_mut_array()[slot] = point[axis];
            }
        }
        Self(packet)
    }

    /// Returns a bit mask: bit i is set if point i of the packet may lie within `query`'s radius of
    /// the query line.
    ///
    /// The test is conservative: a point inside the radius never loses its bit by rounding errors.
    /// Let γ(n) bound the relative error of n roundings. The test allows the error γ(24). This
    /// covers γ(1) of the vector from the line's origin, γ(4) of its projection on the line, and
    /// γ(3) of its perpendicular component, times √3 for three axes.
    #[inline]
    pub fn points_near_line(&self, query: &LineQuery) -> u32 {
        let to = subtract(self.0, query.origin);
        let t = dot(to, query.direction);
        let [x, y, z] = query.direction;
        let off = subtract(to, [x * t, y * t, z * t]);
        let reach = query.radius + manhattan_length(to) * f32x8::splat(rounding_error_bound(24));
        dot(off, off).simd_le(reach * reach).to_bitmask()
    }

    /// Returns a bit mask of the points at distances d < r from `center`, and the value d²/r² for
    /// each lane.
    ///
    /// Bit i of the mask stands for point i of the packet. `inverse_radius` is 1/r \[1/length].
    #[inline]
    pub fn points_within_radius(&self, center: Vec3, inverse_radius: f32) -> (u32, f32x8) {
        let scale = f32x8::splat(inverse_radius);
        let [x, y, z] = subtract(self.0, broadcast_to_lanes(center));
        let to = [x * scale, y * scale, z * scale];
        let x2 = dot(to, to);
        (x2.simd_lt(f32x8::ONE).to_bitmask(), x2)
    }
}

/// A piece of a photon beam: the half-open interval \[`from`, `to`) of distances along the beam.
#[derive(Clone, Copy, Debug)]
pub(super) struct BeamPiece {
    /// Index of the beam in the photon beam map.
    pub beam: u32,
    /// Distance from the beam's start to the start of the piece \[length].
    pub from: f32,
    /// Distance from the beam's start to the end of the piece \[length].
    pub to: f32,
}

/// Up to eight beam pieces. A piece is a range of distances along a beam. In unused lanes, this
/// range is empty, so these lanes match no query.
pub(super) struct BeamPiecePacket {
    beam_start: Vec3x8,
    direction: Vec3x8,
    from: f32x8,
    to: f32x8,
    /// Index of the beam of each piece in the [`PhotonBeamMap`](super::PhotonBeamMap); meaningless
    /// in unused lanes.
    pub beams: [u32; LANES],
}

impl BeamPiecePacket {
    /// Creates a packet of the first eight of `pieces`, each with the start and unit direction of
    /// its beam.
    pub fn new(pieces: impl Iterator<Item = (BeamPiece, Vec3, Vec3)>) -> Self {
        let nowhere = [f32x8::ZERO; 3];
        let (from, to) = (f32x8::splat(f32::INFINITY), f32x8::splat(f32::NEG_INFINITY));
        let mut all = Self { beam_start: nowhere, direction: nowhere, from, to, beams: [0; LANES] };
        for (slot, (piece, start, direction)) in pieces.take(LANES).enumerate() {
            for axis in 0..3 {
                all.beam_start[axis].as_mut_array()[slot] = start[axis];
                all.direction[axis].as_mut_array()[slot] = direction[axis];
            }
            all.from.as_mut_array()[slot] = piece.from;
            all.to.as_mut_array()[slot] = piece.to;
            all.beams[slot] = piece.beam;
        }
        all
    }

    /// Returns the beam piece in lane `slot`.
    pub fn beam_piece_in_lane(&self, slot: usize) -> BeamPiece {
        BeamPiece { beam: self.beams[slot], from: self.from.as_array()[slot], to: self.to.as_array()[slot] }
    }

    /// Returns a bit mask: bit i is set if beam piece i of the packet may come within `query`'s
    /// radius of the query line.
    ///
    /// The test is conservative: a piece inside the radius never loses its bit by rounding errors.
    /// Let γ(n) bound the relative error of n roundings. The test allows the error γ(16). The
    /// vector normal to line and beam has the error √3 γ(2) ≤ γ(4). Distances along this normal
    /// have the error γ(8), relative to the distance D of the two origins. A position s along the
    /// beam has the error γ(14), relative to D + s.
    #[inline]
    pub fn beam_pieces_near_line(&self, query: &LineQuery) -> u32 {
        let error = f32x8::splat(rounding_error_bound(16));
        let between = subtract(self.beam_start, query.origin);
        let distance = manhattan_length(between);
        let normal = cross(query.direction, self.direction);
        let sin2 = dot(normal, normal);
        let height = dot(between, normal).abs();
        let near = height.simd_le(query.radius * sin2.sqrt() + error * (distance + query.radius));
        let along = dot(cross(between, query.direction), normal);
        let slack = error * (distance + self.to);
        let after = along.simd_ge(self.from * sin2 - slack);
        let before = along.simd_le(self.to * sin2 + slack);
        (near & after & before).to_bitmask()
    }
}
