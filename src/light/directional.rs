//! Directional lights: parallel light from infinity.

use super::PhotonAim;
use super::light_bounds::LightBounds;
use super::source::{DirectLightSample, EmissionSample, LightGeometry, LightSource, ShadowTarget};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Frame, Ray, warp};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// A light at infinity with parallel rays, such as the sun if its angular size is neglected.
#[derive(Clone, Copy, Debug)]
pub struct DirectionalLight {
    /// Unit direction in which the light travels.
    pub direction: Vec3,
    /// Irradiance on a surface that faces the light \[W/m²].
    pub irradiance: Rgb,
}

impl LightSource for DirectionalLight {
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        LightGeometry::Parallel(self.direction)
    }

    #[inline]
    fn sample_li(&self, _p: Vec3, _u: Vec2) -> Option<DirectLightSample> {
        let (wi, target) = (-self.direction, ShadowTarget::Infinity);
        Some(DirectLightSample { wi, target, weight: self.irradiance, pdf: None })
    }

    #[inline]
    fn pdf_li(&self, _p: Vec3, _wi: Vec3, _hit: Option<&SurfacePoint>) -> f32 {
        0.0
    }

    fn sample_le(&self, domain: BoundingSphere, position: Vec2, _direction: Vec2) -> Option<EmissionSample> {
        let (ray, area) = sample_ray_across_sphere(domain, self.direction, position)?;
        Some(EmissionSample { ray, weight: self.irradiance * area })
    }

    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        domain: BoundingSphere,
        position: Vec2,
        _direction: Vec2,
    ) -> Option<EmissionSample> {
        let upstream = domain.radius - self.direction.dot(domain.center);
        let (start, pdf) = aim.sample_parallel_ray_start(self.direction, upstream, position)?;
        Some(EmissionSample { ray: Ray::new(start, self.direction), weight: self.irradiance / pdf })
    }

    fn power(&self, domain: BoundingSphere) -> Rgb {
        self.irradiance * (PI * domain.radius * domain.radius)
    }

    fn bounds(&self) -> Option<LightBounds> {
        None
    }

    fn nominal_strength(&self) -> Option<Rgb> {
        Some(self.irradiance)
    }
}

/// Samples a ray along unit `direction` that enters the sphere `domain`, by `u` in \[0, 1)². The
/// origin of the ray is uniformly distributed over a disc. Returns the ray and the area of this
/// disc \[length²].
///
/// The disc has the radius of the sphere, is perpendicular to `direction` and touches the sphere.
/// Returns `None` if the area of the disc is zero.
pub(super) fn sample_ray_across_sphere(domain: BoundingSphere, direction: Vec3, u: Vec2) -> Option<(Ray, f32)> {
    let frame = Frame::from_normal(direction);
    let d = warp::square_to_uniform_disc(u) * domain.radius;
    let p = domain.center + frame.s * d.x + frame.t * d.y;
    let start = p - direction * (domain.radius + direction.dot(p - domain.center));
    let area = PI * domain.radius * domain.radius;
    (area > 0.0).then(|| (Ray::new(start, direction), area))
}
