//! Rays in the object space of a shape.

use super::hit::ray_to_f64;
use crate::math::{Ray, Transform};
use glam::DVec3;

/// Origin and direction of the world-space `ray` in object space.
///
/// The direction is not normalised, so the ray parameter t of a point is the same in world space
/// and in object space.
#[inline]
pub(super) fn ray_to_object_space(ray: &Ray, to_world: &Transform) -> (DVec3, DVec3) {
    let (o, d) = ray_to_f64(ray);
    let inverse = to_world.inverse();
    (inverse.transform_point3(o), inverse.transform_vector3(d))
}

/// Object-space line of a ray, with arc length τ as parameter.
///
/// τ is 0 at the point nearest to the object's origin. Shapes lie near that origin, so solutions
/// for τ keep their digits even if the ray starts far away.
pub(super) struct ObjectRay {
    /// Object-space point of the line at τ = 0, nearest to the object's origin.
    pub base: DVec3,
    /// Unit direction in object space.
    pub direction: DVec3,
    /// Signed object-space distance from the ray's origin to `base`; negative if `base` lies behind
    /// the origin.
    pub distance_to_base: f64,
    /// Change of τ per unit of the ray parameter t: the length of the object-space direction.
    pub direction_length: f64,
}

impl ObjectRay {
    /// Object-space line of the world-space `ray`, for an object under the map `to_world`.
    #[inline]
    pub fn new(ray: &Ray, to_world: &Transform) -> Self {
        let (o, d) = ray_to_object_space(ray, to_world);
        let length = d.length();
        let direction = d / length;
        let start = -o.dot(direction);
        // The second projection removes the rounding error of the first, which grows with the
        // distance of the ray's origin.
        let base = o + direction * start;
        let more = -base.dot(direction);
        Self { base: base + direction * more, direction, distance_to_base: start + more, direction_length: length }
    }

    /// Ray parameter t of the point at arc length τ.
    #[inline]
    pub fn ray_parameter(&self, tau: f64) -> f64 {
        (self.distance_to_base + tau) / self.direction_length
    }

    /// Object-space point at ray parameter `t`.
    #[inline]
    pub fn at_ray_parameter(&self, t: f64) -> DVec3 {
        self.base + self.direction * (t * self.direction_length - self.distance_to_base)
    }
}

/// Upper bound on the absolute world-space coordinates of points, if their absolute object-space
/// coordinates are at most `size`.
#[inline]
pub(super) fn world_coordinate_bound(to_world: &Transform, size: f64) -> f64 {
    let m = to_world.forward().matrix3;
    let widest = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
    widest * size + to_world.forward().translation.abs().max_element()
}
