//! Infinite planes, which have no bounding box.

use super::hit::{ray_to_f64, round_t_if_in_range};
use super::surface_point::SurfacePoint;
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform};
use glam::{DVec3, Vec2, Vec3};

/// Cosine between ray and normal below which the ray counts as parallel to the plane.
///
/// The value exceeds the rounding error of the cosine: up to 2π·2⁻⁵³ from each of two rotations,
/// and 3·2⁻⁵³ from the dot product.
const PARALLEL_COSINE: f64 = 8.0 * f64::EPSILON;

/// Infinite plane `normal · x = offset`; the normal is a unit vector and points to the outer side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// Plane through `point` perpendicular to `normal`, which may have any length above zero.
    #[must_use]
    pub fn new(point: DVec3, normal: DVec3) -> Self {
        let normal = normal.normalize();
        Self { normal, offset: normal.dot(point) }
    }

    /// The plane translated by `by` in world space.
    #[must_use]
    pub fn translated(self, by: DVec3) -> Self {
        Self { offset: self.offset + self.normal.dot(by), ..self }
    }

    /// The plane transformed by the world-space map `map`. The outer side stays the outer side,
    /// even if `map` mirrors.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Self {
        Self::new(map.transform_point(self.normal * self.offset), map.transform_normal(self.normal))
    }

    /// Point of the plane nearest to the world-space origin, and the unit normal.
    #[must_use]
    pub fn point_and_normal(&self) -> (Vec3, Vec3) {
        ((self.normal * self.offset).as_vec3(), self.normal.as_vec3())
    }

    /// Hit of `ray`, with `shape_coords` of zero; `None` if the ray is parallel to the plane, or if
    /// its ray parameter t at the plane is outside (0, `ray.t_max`).
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (o, d) = ray_to_f64(ray);
        let across = self.normal.dot(d);
        if across * across <= PARALLEL_COSINE * PARALLEL_COSINE * d.length_squared() {
            return None;
        }
        round_t_if_in_range(ray, (self.offset - self.normal.dot(o)) / across)
            .map(|t| ShapeHit { t, shape_coords: Vec2::ZERO })
    }

    /// Surface point of the plane at the ray parameter `t` of a hit of `ray`.
    #[inline]
    #[must_use]
    pub fn surface_point(&self, ray: &Ray, t: f32) -> SurfacePoint {
        let (o, d) = ray_to_f64(ray);
        let p = o + d * f64::from(t);
        let on = p - self.normal * (self.normal.dot(p) - self.offset);
        SurfacePoint::from_f64(on, self.normal, on.abs().max_element())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_hits_stay_on_the_plane() {
        let plane = Plane::new(DVec3::new(0.0, -2.0, 0.0), DVec3::new(0.0, 3.0, 0.0));
        let ray = Ray::new(Vec3::ZERO, Vec3::new(1.0, -1e-4, 0.0));
        let ShapeHit { t, .. } = plane.intersect(&ray).unwrap();
        assert_eq!(plane.surface_point(&ray, t).p.y, -2.0);
    }

    #[test]
    fn parallel_rays_miss() {
        for height in [0.0, -2.0] {
            let plane = Plane::new(DVec3::new(0.0, height, 0.0), DVec3::Y);
            assert!(plane.intersect(&Ray::new(Vec3::ZERO, Vec3::X)).is_none(), "0/0 is no crossing");
        }
    }
}
