//! Interface of all kinds of lights, and the records that its methods return.

use super::light_bounds::LightBounds;
use super::{Light, LightSurface, PhotonAim};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Ray};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// The end of a shadow ray towards a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadowTarget {
    /// A point of the light, offset from the light's own surface by the rounding error.
    Point(Vec3),
    /// The light is at infinity, so the ray has no end.
    Infinity,
}

/// A sampled direction from which direct light arrives at a point; occlusion is not tested yet.
#[derive(Clone, Copy, Debug)]
pub struct DirectLightSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// End of the shadow ray.
    pub target: ShadowTarget,
    /// Radiance over `pdf`, without the cosine at the lit surface. For delta lights: irradiance at
    /// normal incidence \[W/m²].
    pub weight: Rgb,
    /// Pdf of `wi` \[1/sr], equal to [`Light::pdf_li`]; `None` for delta lights.
    pub pdf: Option<f32>,
}

/// A sampled ray that leaves a light, with its flux.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// The ray, with a unit direction.
    pub ray: Ray,
    /// Flux of the ray over its pdf \[W]. The mean is the flux of all rays that can be sampled.
    pub flux: Rgb,
}

/// The sample points of [`Light::sample_le`] on which the emitted ray depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmissionDimensions {
    /// True if the ray depends on the argument `position`.
    pub uses_position: bool,
    /// True if the ray depends on the argument `direction`.
    pub uses_direction: bool,
}

/// The place or direction from which a light emits.
pub(super) enum LightGeometry<'a> {
    /// A delta light at one position in world space.
    Point(Vec3),
    /// A delta light at infinity, whose rays travel in this unit direction.
    Parallel(Vec3),
    /// An emitting surface.
    Surface(&'a LightSurface),
    /// Light at infinity that arrives from all directions.
    AllDirections,
}

/// A kind of light. [`Light`] documents the methods, and derives further ones from `geometry`.
///
/// `sample_li` and `sample_le` must describe the same emitted radiance. Camera paths compute direct
/// light by `sample_li`, and photon paths compute indirect light by `sample_le`.
pub(super) trait LightSource {
    /// The place or direction from which the light emits.
    fn geometry(&self) -> LightGeometry<'_>;

    /// Implements [`Light::sample_li`].
    fn sample_li(&self, p: Vec3, u: Vec2) -> Option<DirectLightSample>;

    /// Implements [`Light::pdf_li`].
    fn pdf_li(&self, p: Vec3, wi: Vec3, hit: Option<&SurfacePoint>) -> f32;

    /// Implements [`Light::sample_le`].
    fn sample_le(&self, domain: BoundingSphere, position: Vec2, direction: Vec2) -> Option<EmissionSample>;

    /// Implements [`Light::sample_le_towards`].
    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        domain: BoundingSphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample>;

    /// Implements [`Light::power`].
    fn power(&self, domain: BoundingSphere) -> Rgb;

    /// Bounds in space and direction, without a margin; `None` for light from infinity.
    fn bounds(&self) -> Option<LightBounds>;

    /// Implements [`Light::peak_strength`]; `None` unless this is a delta light.
    fn peak_strength(&self) -> Option<Rgb> {
        None
    }

    /// Implements [`Light::may_illuminate`] for a sphere that is already grown by rounding errors.
    fn may_illuminate(&self, _sphere: BoundingSphere) -> bool {
        true
    }

    /// Copy of the light that emits its mean radiance; `None` if no texture varies the radiance.
    fn untextured_light(&self) -> Option<Light> {
        None
    }
}
