//! Constants of a ray that box tests and triangle tests share.

use crate::math::Ray;
use glam::{Vec3, Vec3A};

/// Constants of one ray that box tests and triangle tests use.
///
/// The direction is scaled by a power of two, without rounding, so that its component of largest
/// magnitude is in \[1, 2). The power of two must be a normal f32, and so must its inverse. The
/// scaled component may therefore reach 4 if the unscaled one is near the largest f32. If the
/// unscaled one is subnormal, the scaled one is below 1. The scaling keeps reciprocals and products
/// in the range of f32. In box and triangle tests, ray parameters refer to the scaled direction.
pub(super) struct RayPrecalc {
    /// Origin of the ray. Unlike the direction, it is not scaled.
    pub origin: [f32; 3],
    /// Reciprocal of each component of the scaled direction, clamped to the range of finite f32.
    pub reciprocal_direction: [f32; 3],
    /// For each axis, the box plane that the ray crosses first: 0 for the lower one, 1 for the
    /// upper one.
    ///
    /// The side is 1 if the direction's component is negative or a negative zero.
    pub near_sides: [usize; 3],
    /// Permutation of the axes 0, 1, 2. Its last axis is the axis of the direction's largest
    /// component in magnitude.
    pub axis_permutation: [usize; 3],
    /// Ratios by which the triangle test shears space, so that the ray runs along one axis: the
    /// direction components along `axis_permutation[0]` and `axis_permutation[1]`, divided by the
    /// component along `axis_permutation[2]`.
    pub shear: [f32; 2],
    /// Component of the scaled direction along `axis_permutation[2]`.
    pub permuted_direction_z: f64,
    /// Exclusive upper bound of the ray parameter, for the scaled direction.
    pub t_max: f32,
    /// Factor from the ray's own direction to the scaled direction: a power of two.
    ///
    /// The ray parameter t for the ray's own direction is `direction_scale` times the t for the
    /// scaled direction.
    pub direction_scale: f32,
    /// Factor from the ray parameter t for the ray's own direction to the t for the scaled
    /// direction: 1 / `direction_scale`.
    pub inverse_direction_scale: f32,
}

impl RayPrecalc {
    /// True if origin and direction are finite and the direction is not zero; other rays hit
    /// nothing.
    #[inline]
    pub fn can_hit_anything(ray: &Ray) -> bool {
        ray.direction != Vec3::ZERO && ray.direction.is_finite() && ray.origin.is_finite()
    }

    /// Computes the constants of `ray`, for which [`Self::can_hit_anything`] must be true.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        // Both the power of two and its inverse must be normal numbers.
        let exponent = (size.max_element().to_bits() >> 23).clamp(1, 253);
        let (inverse_direction_scale, direction_scale) =
            (f32::from_bits(exponent << 23), f32::from_bits((254 - exponent) << 23));
        let direction = Vec3A::from(ray.direction * direction_scale);
        // An infinite reciprocal times a zero distance would be NaN.
        let bound = Vec3A::splat(f32::MAX);
        let r = (Vec3A::ONE / direction).min(bound).max(-bound).to_array();
        let z = if size.x > size.y { 0 } else { 1 };
        let z = if size.z > size.x.max(size.y) { 2 } else { z };
        let (x, y) = ([1, 2, 0][z], [2, 0, 1][z]);
        let d = direction.to_array();
        Self {
            origin: ray.origin.to_array(),
            reciprocal_direction: r,
            near_sides: [usize::from(r[0] < 0.0), usize::from(r[1] < 0.0), usize::from(r[2] < 0.0)],
            axis_permutation: [x, y, z],
            shear: [d[x] * r[z], d[y] * r[z]],
            permuted_direction_z: f64::from(d[z]),
            t_max: ray.t_max * inverse_direction_scale,
            direction_scale,
            inverse_direction_scale,
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
            assert_eq!(p.reciprocal_direction[..2], [f32::MAX, f32::MIN]);
            assert!(p.reciprocal_direction[2] < 0.0 && p.reciprocal_direction[2].is_finite());
            assert_eq!((p.near_sides, p.axis_permutation[2]), ([0, 1, 1], 2));
            assert_eq!(p.direction_scale * p.inverse_direction_scale, 1.0);
            assert!(
                length < 1e-38 || (1.0..4.0).contains(&-p.permuted_direction_z),
                "{length} {}",
                p.permuted_direction_z
            );
        }
    }
}
