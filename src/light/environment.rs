//! Environment lights: light from infinity by an equirectangular map.

use super::directional::sample_ray_across_sphere;
use super::light_bounds::LightBounds;
use super::source::{DirectLightSample, EmissionSample, LightGeometry, LightSource, ShadowTarget};
use super::{EmissionPictureError, EquirectangularMap, PhotonAim};
use crate::color::Rgb;
use crate::image::Image;
use crate::math::{BoundingSphere, Ray};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Environment light: light from infinity whose radiance in each direction is the value of an
/// equirectangular map.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    map: EquirectangularMap,
    /// Sine and cosine, in this order, of the angle by which the map is rotated about +y,
    /// anticlockwise as seen from +y.
    rotation_sin_cos: [f32; 2],
}

impl EnvironmentLight {
    /// Creates a light whose radiance \[W/(m² sr)] is the value of `map` times `scale`.
    ///
    /// The map is rotated by `angle` \[radians] about +y, anticlockwise as seen from +y.
    ///
    /// # Errors
    /// [`EmissionPictureError::InvalidPixel`] if a scaled pixel is negative or not finite.
    pub fn new(map: Image, angle: f64, scale: Rgb) -> Result<Self, EmissionPictureError> {
        let rotation = [libm::sin(angle) as f32, libm::cos(angle) as f32];
        Ok(Self { map: EquirectangularMap::new(map, scale)?, rotation_sin_cos: rotation })
    }

    /// Creates a light with the same radiance \[W/(m² sr)] in all directions.
    ///
    /// # Errors
    /// [`EmissionPictureError::InvalidPixel`] if the radiance is negative or not finite.
    pub fn with_constant_radiance(radiance: Rgb) -> Result<Self, EmissionPictureError> {
        Self::new(Image::from_pixels(1, 1, vec![radiance])?, 0.0, Rgb::ONE)
    }

    /// Transforms a direction from world space to the frame of the map.
    #[inline]
    fn world_to_map(&self, d: Vec3) -> Vec3 {
        let [sin, cos] = self.rotation_sin_cos;
        Vec3::new(cos * d.x - sin * d.z, d.y, sin * d.x + cos * d.z)
    }

    /// Radiance that arrives from unit `direction` \[W/(m² sr)].
    #[inline]
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        self.map.value_in_direction(self.world_to_map(direction))
    }

    /// Pdf \[1/sr] with which [`EnvironmentLight::sample`] samples unit `direction`.
    #[inline]
    #[must_use]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        self.map.pdf(self.world_to_map(direction))
    }

    /// Samples a unit direction from which light arrives, by `u` in \[0, 1)². Returns the direction
    /// and its pdf \[1/sr].
    ///
    /// The pdf is constant in each pixel, and proportional to the mean radiance over the pixel.
    /// Returns `None` if the map is black, or if rounding gives a direction of pdf 0.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let d = self.map.sample(u)?;
        let [sin, cos] = self.rotation_sin_cos;
        let direction = Vec3::new(cos * d.x + sin * d.z, d.y, cos * d.z - sin * d.x);
        // Rounding may move the direction to another pixel, so its pdf is looked up again.
        let pdf = self.pdf(direction);
        (pdf > 0.0).then_some((direction, pdf))
    }

    /// Inverse of [`EnvironmentLight::sample`]: returns the point u in \[0, 1)² that `sample` maps
    /// to unit `direction`, up to rounding; `None` if the map is black.
    ///
    /// A guide that samples u non-uniformly needs this point to compute the pdf of `direction`.
    #[inline]
    #[must_use]
    pub fn inverse_sample(&self, direction: Vec3) -> Option<Vec2> {
        self.map.inverse_sample(self.world_to_map(direction))
    }
}

impl LightSource for EnvironmentLight {
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        LightGeometry::AllDirections
    }

    #[inline]
    fn sample_li(&self, _p: Vec3, u: Vec2) -> Option<DirectLightSample> {
        let (wi, pdf) = self.sample(u)?;
        Some(DirectLightSample { wi, target: ShadowTarget::Infinity, weight: self.radiance(wi) / pdf, pdf: Some(pdf) })
    }

    #[inline]
    fn pdf_li(&self, _p: Vec3, wi: Vec3, _hit: Option<&SurfacePoint>) -> f32 {
        self.pdf(wi)
    }

    fn sample_le(&self, domain: BoundingSphere, position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        let (from, pdf) = self.sample(direction)?;
        let (ray, area) = sample_ray_across_sphere(domain, -from, position)?;
        Some(EmissionSample { ray, weight: self.radiance(from) * (area / pdf) })
    }

    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        domain: BoundingSphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        let (from, pdf) = self.sample(direction)?;
        let upstream = domain.radius + from.dot(domain.center);
        let (start, pdf_start) = aim.sample_parallel_ray_start(-from, upstream, position)?;
        Some(EmissionSample { ray: Ray::new(start, -from), weight: self.radiance(from) / (pdf * pdf_start) })
    }

    /// Flux \[W] that enters the sphere `domain` of radius r: π r² ∫ L dω, with the integral over
    /// all directions.
    fn power(&self, domain: BoundingSphere) -> Rgb {
        self.map.integral() * (PI * domain.radius * domain.radius)
    }

    fn bounds(&self) -> Option<LightBounds> {
        None
    }
}
