//! Eight points or pieces of lines, of which a vector unit rejects most at once.
//!
//! The tests here keep all that exact arithmetic would keep, and a few more: bounds are in γ(n) of Higham 2002, section 3.1, for
//! unit directions.

use crate::math::{Ray, gamma};
use glam::Vec3;
use wide::f32x8;

/// Items of a packet.
pub(super) const LANES: usize = 8;

type Vectors = [f32x8; 3];

fn splat(v: Vec3) -> Vectors {
    v.to_array().map(f32x8::splat)
}

#[inline]
fn minus(a: Vectors, b: Vectors) -> Vectors {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
fn dot(a: Vectors, b: Vectors) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn cross(a: Vectors, b: Vectors) -> Vectors {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// At least the length.
#[inline]
fn size(v: Vectors) -> f32x8 {
    v[0].abs() + v[1].abs() + v[2].abs()
}

/// A ray and a radius for eight items at a time.
pub(super) struct Wanted {
    origin: Vectors,
    direction: Vectors,
    radius: f32x8,
}

impl Wanted {
    pub fn new(ray: &Ray, radius: f32) -> Self {
        Self { origin: splat(ray.origin), direction: splat(ray.direction), radius: f32x8::splat(radius) }
    }
}

/// The slots of a mask, from the lowest.
#[inline]
pub(super) fn slots(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let slot = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            slot
        })
    })
}

/// Eight places; vacant ones are infinitely far.
pub(super) struct Points(Vectors);

impl Points {
    pub fn new(places: impl Iterator<Item = Vec3>) -> Self {
        let mut points = [f32x8::splat(f32::INFINITY); 3];
        for (slot, place) in places.take(LANES).enumerate() {
            for (axis, lanes) in points.iter_mut().enumerate() {
                lanes.as_mut_array()[slot] = place[axis];
            }
        }
        Self(points)
    }

    /// A mask of those that may be within the radius of the line.
    ///
    /// Rounding the place errs by γ(1), its projection by γ(4), taking that away by γ(3) of the distance, all by √3 more over three axes.
    #[inline]
    pub fn near_line(&self, wanted: &Wanted) -> u32 {
        let to = minus(self.0, wanted.origin);
        let t = dot(to, wanted.direction);
        let [x, y, z] = wanted.direction;
        let off = minus(to, [x * t, y * t, z * t]);
        let reach = wanted.radius + size(to) * f32x8::splat(gamma(24));
        dot(off, off).simd_le(reach * reach).to_bitmask()
    }

    /// A mask of those nearer to a place than a radius, given by its reciprocal, and their squared distances in squares of the radius.
    #[inline]
    pub fn near(&self, place: Vec3, per_radius: f32) -> (u32, f32x8) {
        let scale = f32x8::splat(per_radius);
        let [x, y, z] = minus(self.0, splat(place));
        let to = [x * scale, y * scale, z * scale];
        let x2 = dot(to, to);
        (x2.simd_lt(f32x8::ONE).to_bitmask(), x2)
    }
}

/// A part of a beam: from where to where along it. The end counts for the next part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub beam: u32,
    pub from: f32,
    pub to: f32,
}

/// Eight pieces; vacant ones are nowhere.
pub(super) struct Pieces {
    start: Vectors,
    direction: Vectors,
    from: f32x8,
    to: f32x8,
    pub beams: [u32; LANES],
}

impl Pieces {
    /// Of pieces with their beams' starts and directions.
    pub fn new(pieces: impl Iterator<Item = (Piece, Vec3, Vec3)>) -> Self {
        let nowhere = [f32x8::ZERO; 3];
        let (from, to) = (f32x8::splat(f32::INFINITY), f32x8::splat(f32::NEG_INFINITY));
        let mut all = Self { start: nowhere, direction: nowhere, from, to, beams: [0; LANES] };
        for (slot, (piece, start, direction)) in pieces.take(LANES).enumerate() {
            for axis in 0..3 {
                all.start[axis].as_mut_array()[slot] = start[axis];
                all.direction[axis].as_mut_array()[slot] = direction[axis];
            }
            all.from.as_mut_array()[slot] = piece.from;
            all.to.as_mut_array()[slot] = piece.to;
            all.beams[slot] = piece.beam;
        }
        all
    }

    pub fn piece(&self, slot: usize) -> Piece {
        Piece { beam: self.beams[slot], from: self.from.as_array()[slot], to: self.to.as_array()[slot] }
    }

    /// A mask of those that the line may pass within the radius.
    ///
    /// The common normal errs by √3 γ(2) ≤ γ(4), heights along it by γ(8) of the distance of the origins, and its squared length times
    /// places along the beam by γ(14) of that distance and of the place.
    #[inline]
    pub fn near_line(&self, wanted: &Wanted) -> u32 {
        let error = f32x8::splat(gamma(16));
        let between = minus(self.start, wanted.origin);
        let distance = size(between);
        let normal = cross(wanted.direction, self.direction);
        let sin2 = dot(normal, normal);
        let height = dot(between, normal).abs();
        let near = height.simd_le(wanted.radius * sin2.sqrt() + error * (distance + wanted.radius));
        let along = dot(cross(between, wanted.direction), normal);
        let slack = error * (distance + self.to);
        let after = along.simd_ge(self.from * sin2 - slack);
        let before = along.simd_le(self.to * sin2 + slack);
        (near & after & before).to_bitmask()
    }
}
