//! The interface that every kind of light implements, and its sample records.

use super::light_bounds::LightBounds;
use super::{Light, LightSurface, PhotonAim};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Ray};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// End of a shadow ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadowTarget {
    /// A point, already offset from the light's own surface.
    Point(Vec3),
    /// The ray has no end.
    Infinity,
}

/// Direct light that arrives at a point from one sampled direction, before visibility.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// End of the shadow ray.
    pub target: ShadowTarget,
    /// Radiance over `pdf`, without the cosine at the lit surface; for delta lights, irradiance at
    /// normal incidence.
    pub weight: Rgb,
    /// Pdf of `wi` \[1/sr], equal to [`Light::pdf_li`]; `None` for delta lights, which BSDF
    /// sampling cannot hit.
    pub pdf: Option<f32>,
}

/// A ray that leaves a light, with its flux.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// Ray with unit direction.
    pub ray: Ray,
    /// Flux over the pdf of the ray \[W]. Its mean is the light's power, or the aimed part of it.
    pub flux: Rgb,
}

/// Which sample points an emitted ray depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmissionDimensions {
    /// True if the sample point of positions matters.
    pub position: bool,
    /// True if the sample point of directions matters.
    pub direction: bool,
}

/// Where a light emits from.
pub(super) enum LightGeometry<'a> {
    /// One position: a delta light.
    Point(Vec3),
    /// Infinity, in one unit direction of travel: a delta light.
    Parallel(Vec3),
    /// A surface.
    Surface(&'a LightSurface),
    /// Infinity, in all directions.
    AllDirections,
}

/// One kind of light. [`Light`] documents the methods, and derives further ones from `geometry`.
///
/// Direct light must come from `sample_li`: photon methods store no light that arrives directly, so
/// light that only `sample_le` emits would be lost at its first hit. Both must describe the same
/// radiance, and `pdf_li` the pdf of `sample_li`.
pub(super) trait LightSource {
    /// Where the light emits from.
    fn geometry(&self) -> LightGeometry<'_>;

    /// Implements [`Light::sample_li`].
    fn sample_li(&self, p: Vec3, u: Vec2) -> Option<DirectSample>;

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

    /// Bounds of positions and directions, without a margin; `None` for light from infinity.
    fn bounds(&self) -> Option<LightBounds>;

    /// Implements [`Light::peak_strength`].
    fn peak_strength(&self) -> Option<Rgb>;

    /// Implements [`Light::may_illuminate`] for a sphere that is already grown by rounding errors.
    fn may_illuminate(&self, sphere: BoundingSphere) -> bool;

    /// The light with its mean radiance; `None` if no texture varies its radiance.
    fn untextured_light(&self) -> Option<Light> {
        None
    }
}
