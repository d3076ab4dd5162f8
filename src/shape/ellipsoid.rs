//! Ellipsoids: unit spheres under affine maps.

use super::bounded_shape::BoundedShape;
use super::hit::{f64_ray_parameter, nearer_hit};
use super::object_ray::{ray_to_object_space, world_coordinate_bound};
use super::sphere::Sphere;
use super::surface_point::{ShapeSample, SurfacePoint};
use crate::accel::ShapeHit;
use crate::math::{Ray, Transform, quadratic_roots_half_b, warp};
use glam::{DAffine3, DMat3, DVec3, Vec2};

/// Ellipsoid in world space: the unit sphere under an affine map.
///
/// Object-space ray directions are not normalised, so the ray parameter t of a point is the same in
/// object space and in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    to_world: Transform,
    area: f64,
}

impl Ellipsoid {
    /// Ellipsoid to which `to_world` maps the unit sphere around the object-space origin.
    #[must_use]
    pub fn new(to_world: Transform) -> Self {
        let mut ellipsoid = Self { to_world, area: 0.0 };
        ellipsoid.area = ellipsoid.integrate_area();
        ellipsoid
    }

    /// Ellipsoid to which the affine map `map` transforms `sphere`; `None` if the resulting
    /// object-to-world map is singular.
    #[must_use]
    pub fn from_sphere(sphere: &Sphere, map: &Transform) -> Option<Self> {
        let place = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(sphere.radius)), translation: sphere.center };
        Some(Self::new(Transform::new(*map.forward() * place).ok()?))
    }

    /// World-space surface point for the object-space point `object` of the unit sphere.
    #[inline]
    fn surface_at(&self, object: DVec3) -> SurfacePoint {
        let p = self.to_world.transform_point(object);
        SurfacePoint::from_f64(
            p,
            self.to_world.transform_normal(object).normalize(),
            world_coordinate_bound(&self.to_world, 1.0),
        )
    }

    /// World-space area \[length²], integrated numerically by the midpoint rule over height and
    /// azimuth.
    fn integrate_area(&self) -> f64 {
        const N: u32 = 256;
        let mut sum = 0.0;
        for i in 0..N {
            let z = (f64::from(i) + 0.5) * 2.0 / f64::from(N) - 1.0;
            let r = (1.0 - z * z).sqrt();
            for j in 0..N {
                let (sin, cos) = libm::sincos((f64::from(j) + 0.5) * std::f64::consts::TAU / f64::from(N));
                sum += self.to_world.world_element_area(DVec3::new(r * cos, r * sin, z));
            }
        }
        4.0 * std::f64::consts::PI * sum / f64::from(N * N)
    }
}

impl BoundedShape for Ellipsoid {
    fn transformed(&self, map: &Transform) -> Option<Self> {
        Some(Self::new(Transform::new(*map.forward() * *self.to_world.forward()).ok()?))
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let (l, d) = ray_to_object_space(ray, &self.to_world);
        let (a, b) = (d.length_squared(), l.dot(d));
        let nearest = l - d * (b / a);
        let distance = l.length();
        let c = (distance - 1.0) * (distance + 1.0);
        let (near, far) = quadratic_roots_half_b(a, b, c, a * (1.0 - nearest.length_squared()))?;
        nearer_hit(ray, (near, 0.0), (far, 0.0))
    }

    #[inline]
    fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint {
        let (l, d) = ray_to_object_space(ray, &self.to_world);
        self.surface_at((l + d * f64_ray_parameter(t, uv)).normalize())
    }

    fn bounds_f64(&self) -> (DVec3, DVec3) {
        // The half extent of the ellipsoid along a world axis is the length of the linear map's row
        // for this axis.
        let rows = self.to_world.forward().matrix3.transpose();
        let half = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let center = self.to_world.forward().translation;
        (center - half, center + half)
    }

    fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..*self }
    }

    fn area(&self) -> f64 {
        self.area
    }

    /// Maps a uniform sample of the unit sphere to the ellipsoid, so the pdf per area varies.
    fn sample(&self, u: Vec2) -> ShapeSample {
        let n = warp::square_to_uniform_sphere(u).as_dvec3().normalize();
        ShapeSample {
            point: self.surface_at(n),
            pdf: (1.0 / (4.0 * std::f64::consts::PI * self.to_world.world_element_area(n))) as f32,
            shape_coords: Vec2::ZERO,
        }
    }

    #[inline]
    fn pdf(&self, point: &SurfacePoint) -> f32 {
        // The map stretches area by |det M|·|M⁻ᵀ n|, where M is its linear part and n the unit
        // normal of the sphere. Here |M⁻ᵀ n| = 1/|Mᵀ ng|, as Mᵀ maps the unit world normal ng to a
        // multiple of n.
        let m = self.to_world.forward().matrix3;
        ((m.transpose() * point.ng.as_dvec3()).length()
            / (4.0 * std::f64::consts::PI * self.to_world.determinant().abs())) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    /// The area of an oblate spheroid agrees with 2πa²(1 + (1 − e²)/e · artanh e) within 10⁻⁴.
    #[test]
    fn area_matches_the_spheroid_formula() {
        let (a, c) = (1.5f64, 0.6);
        let e = (1.0 - c * c / (a * a)).sqrt();
        let truth = std::f64::consts::TAU * a * a * (1.0 + (1.0 - e * e) / e * libm::atanh(e));
        let t = Transform::new(DAffine3::from_scale(DVec3::new(a, c, a))).unwrap();
        assert!((Ellipsoid::new(t).area() / truth - 1.0).abs() < 1e-4);
    }
}
