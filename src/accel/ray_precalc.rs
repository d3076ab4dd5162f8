//! Per-ray constants of box and triangle tests.

use crate::math::Ray;
use glam::{Vec3, Vec3A};

/// Constants of one ray.
///
/// A power of two scales the direction until its largest component lies in \[1, 2). Neither
/// reciprocals nor products then leave the range of f32, and no digit changes.
pub(super) struct RayPrecalc {
    pub origin: [f32; 3],
    /// Reciprocal of the direction along each axis.
    pub reciprocal: [f32; 3],
    /// Index of the nearer plane along each axis: 1 if the direction is negative or a negative
    /// zero, else 0.
    pub near: [usize; 3],
    /// Permuted axes: the direction is largest along the last one.
    pub axes: [usize; 3],
    /// Slopes of the first two permuted axes over the third.
    pub shear: [f32; 2],
    /// Direction along the third permuted axis.
    pub depth: f64,
    pub t_max: f32,
    /// Length of the caller's direction in the scaled unit, and its inverse; both are powers of
    /// two.
    pub unit: f32,
    pub per_unit: f32,
}

impl RayPrecalc {
    /// True if the ray can hit anything: origin and direction are finite, and the direction is not
    /// zero.
    #[inline]
    pub fn can_hit_anything(ray: &Ray) -> bool {
        ray.direction != Vec3::ZERO && ray.direction.is_finite() && ray.origin.is_finite()
    }

    /// Constants of a ray for which [`Self::can_hit_anything`] is true.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        // Both the power of two and its inverse must be normal numbers.
        let exponent = (size.max_element().to_bits() >> 23).clamp(1, 253);
        let (per_unit, unit) = (f32::from_bits(exponent << 23), f32::from_bits((254 - exponent) << 23));
        let direction = Vec3A::from(ray.direction * unit);
        // An infinite reciprocal times a zero distance would be NaN.
        let bound = Vec3A::splat(f32::MAX);
        let r = (Vec3A::ONE / direction).min(bound).max(-bound).to_array();
        let z = if size.x > size.y { 0 } else { 1 };
        let z = if size.z > size.x.max(size.y) { 2 } else { z };
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
        let d = direction.to_array();
        Self {
            origin: ray.origin.to_array(),
            reciprocal: r,
            near: [usize::from(r[0] < 0.0), usize::from(r[1] < 0.0), usize::from(r[2] < 0.0)],
            axes: [x, y, z],
            shear: [d[x] * r[z], d[y] * r[z]],
            depth: f64::from(d[z]),
            t_max: ray.t_max * per_unit,
            unit,
            per_unit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reciprocals_are_finite_and_lengths_normalised() {
        for length in [1e-45, 1e-30, 1.0, 3e38] {
            let p = RayPrecalc::new(&Ray::new(Vec3::ZERO, Vec3::new(0.0, -0.0, -length)));
            assert_eq!(p.reciprocal[..2], [f32::MAX, f32::MIN]);
            assert!(p.reciprocal[2] < 0.0 && p.reciprocal[2].is_finite());
            assert_eq!((p.near, p.axes[2]), ([0, 1, 1], 2));
            assert_eq!(p.unit * p.per_unit, 1.0);
            assert!(length < 1e-38 || (1.0..4.0).contains(&-p.depth), "{length} {}", p.depth);
        }
    }
}
