//! Spheres in world space.

use super::bounded_shape::BoundedShape;
use super::hit::{f64_ray_parameter, nearer_hit, ray_to_f64};
use super::surface_point::{ShapeSample, SolidAngleSample, SolidAngleSampleResult, SurfacePoint};
use crate::accel::ShapeHit;
use crate::math::{BoundingSphere, Frame, Ray, Transform, distance2_direction_distance, quadratic_roots_half_b, warp};
use glam::{DVec3, Vec2, Vec3};

/// A sphere in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre in world space.
    pub center: DVec3,
    /// Radius \[length], above zero.
    pub radius: f64,
}

impl Sphere {
    /// Sphere around `center` with a radius above zero.
    #[must_use]
    pub fn new(center: DVec3, radius: f64) -> Self {
        Self { center, radius }
    }

    /// Ray parameters at which the line of `ray` meets the sphere, ascending; `None` if the line
    /// misses the sphere.
    ///
    /// The discriminant comes from the distance between line and centre, which avoids cancellation
    /// for distant spheres (Haines et al. 2019, Ray Tracing Gems, chapter 7).
    #[inline]
    fn intersection_roots(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (o, d) = ray_to_f64(ray);
        let l = o - self.center;
        let a = d.length_squared();
        let b = l.dot(d);
        let nearest = l - d * (b / a);
        let discriminant = a * (self.radius * self.radius - nearest.length_squared());
        let distance = l.length();
        quadratic_roots_half_b(a, b, (distance - self.radius) * (distance + self.radius), discriminant)
    }

    /// Surface point in the unit direction `n` from the centre.
    #[inline]
    fn surface_at(&self, n: DVec3) -> SurfacePoint {
        SurfacePoint::from_f64(self.center + n * self.radius, n, self.center.abs().max_element() + self.radius)
    }

    /// Cone of directions from `from` to the sphere: sin²θ and 1 − cosθ of its half angle θ.
    ///
    /// `None` if `from` is on or inside the sphere.
    #[inline]
    fn cone_around_sphere(&self, from: Vec3) -> Option<(f64, f64)> {
        let sin2 = self.radius * self.radius / (self.center - from.as_dvec3()).length_squared();
        // 1 − cos = sin²/(1 + cos) keeps its digits for far spheres.
        (sin2 < 1.0).then(|| (sin2, sin2 / (1.0 + (1.0 - sin2).sqrt())))
    }
}

impl BoundedShape for Sphere {
    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (near, far) = self.intersection_roots(ray)?;
        nearer_hit(ray, (near, 0.0), (far, 0.0))
    }

    #[inline]
    fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint {
        let (o, d) = ray_to_f64(ray);
        self.surface_at((o + d * f64_ray_parameter(t, uv) - self.center).normalize())
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        (self.center - self.radius, self.center + self.radius)
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { center: self.center + by, ..*self }
    }

    /// The sphere transformed by the world-space map `map`.
    ///
    /// `None` if the map scales unevenly: the result is then an [`Ellipsoid`](super::Ellipsoid).
    fn transformed(&self, map: &Transform) -> Option<Self> {
        map.uniform_scale().map(|scale| Self::new(map.transform_point(self.center), self.radius * scale))
    }

    fn area(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.radius * self.radius
    }

    fn sample(&self, u: Vec2) -> ShapeSample {
        ShapeSample {
            point: self.surface_at(warp::square_to_uniform_sphere(u).as_dvec3().normalize()),
            pdf: (1.0 / self.area()) as f32,
            shape_coords: Vec2::ZERO,
        }
    }

    fn bounding_sphere(&self) -> Option<BoundingSphere> {
        Some(BoundingSphere { center: self.center.as_vec3(), radius: self.radius as f32 })
    }

    /// Samples the cone of directions around the sphere uniformly by solid angle.
    ///
    /// Source: Pharr, Jakob, Humphreys 2023, section 6.2.4.
    #[inline]
    fn sample_solid_angle(&self, from: Vec3, u: Vec2) -> SolidAngleSampleResult {
        let Some((sin2, one_minus_cos)) = self.cone_around_sphere(from) else {
            return SolidAngleSampleResult::Invisible;
        };
        let axis = self.center - from.as_dvec3();
        let axis = axis / axis.length_squared().sqrt();
        let cone = warp::square_to_uniform_cone(u, one_minus_cos as f32);
        let sin2_theta = f64::from(cone.x * cone.x + cone.y * cone.y);
        // cos_alpha and sin_alpha give the first hit in the sampled direction, as an angle at the
        // sphere's centre.
        let cos_alpha = sin2_theta / sin2.sqrt() + f64::from(cone.z) * (1.0 - sin2_theta / sin2).max(0.0).sqrt();
        let sin_alpha = (1.0 - cos_alpha * cos_alpha).max(0.0).sqrt();
        let frame = Frame::from_normal(axis.as_vec3());
        let around = (frame.s * cone.x + frame.t * cone.y).as_dvec3();
        let n = around.normalize_or_zero() * sin_alpha - axis * cos_alpha;
        let point = self.surface_at(n.normalize());
        let pdf = warp::uniform_cone_pdf(one_minus_cos as f32);
        distance2_direction_distance(from, point.p).map_or(SolidAngleSampleResult::Invisible, |(_, wi, _)| {
            SolidAngleSampleResult::Sampled(SolidAngleSample { point, wi, pdf })
        })
    }

    #[inline]
    fn solid_angle_pdf(&self, from: Vec3) -> Option<f32> {
        let cone = self.cone_around_sphere(from);
        Some(cone.map_or(0.0, |(_, one_minus_cos)| warp::uniform_cone_pdf(one_minus_cos as f32)))
    }
}

#[cfg(test)]
mod tests;
