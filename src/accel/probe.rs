//! A ray made ready for boxes and triangles.

use crate::math::Ray;
use wide::f32x8;

/// The constants of one ray.
///
/// Its direction is scaled by a power of two until the largest component lies in \[1, 2), so that neither reciprocals nor
/// products leave the range of f32, whatever length the caller chose. No digit changes.
pub(super) struct Probe {
    pub origin: [f32; 3],
    /// Origin and reciprocal of the direction along each axis, for eight boxes at a time.
    pub origins: [f32x8; 3],
    pub reciprocals: [f32x8; 3],
    /// 1 where the direction is negative along the axis, so that the upper plane is the near one.
    pub near: [usize; 3],
    /// Axes after permutation: the last is the one along which the direction is largest.
    pub axes: [usize; 3],
    /// Slopes of the first two permuted axes over the third.
    pub shear: [f32; 2],
    /// Direction along the third permuted axis.
    pub depth: f64,
    pub t_max: f32,
    /// Lengths of the caller's direction in one of ours, and its inverse; both powers of two.
    pub unit: f32,
    pub per_unit: f32,
}

impl Probe {
    /// `None` where the direction is zero or not finite, or the origin is not finite: such rays hit nothing.
    #[inline]
    pub fn new(ray: &Ray) -> Option<Self> {
        let largest = ray.direction.abs().max_element();
        if !(largest > 0.0 && ray.direction.is_finite() && ray.origin.is_finite()) {
            return None;
        }
        // Both the power of two and its inverse must be normal numbers.
        let exponent = (largest.to_bits() >> 23).clamp(1, 253);
        let (per_unit, unit) = (f32::from_bits(exponent << 23), f32::from_bits((254 - exponent) << 23));
        let (d, origin) = ((ray.direction * unit).to_array(), ray.origin.to_array());
        let z = if d[0].abs() > d[1].abs() { 0 } else { 1 };
        let z = if d[2].abs() > d[z].abs() { 2 } else { z };
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
        // An infinite reciprocal times a distance of zero would be no number.
        let reciprocal = |d: f32| (1.0 / d).clamp(-f32::MAX, f32::MAX);
        let [rx, ry, rz] = [reciprocal(d[0]), reciprocal(d[1]), reciprocal(d[2])];
        Some(Self {
            origin,
            origins: [f32x8::splat(origin[0]), f32x8::splat(origin[1]), f32x8::splat(origin[2])],
            reciprocals: [f32x8::splat(rx), f32x8::splat(ry), f32x8::splat(rz)],
            near: [usize::from(rx < 0.0), usize::from(ry < 0.0), usize::from(rz < 0.0)],
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z]],
            depth: f64::from(d[z]),
            t_max: ray.t_max * per_unit,
            unit,
            per_unit,
        })
    }
}
