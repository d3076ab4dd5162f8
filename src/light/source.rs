//! The interface [`LightSource`] of every kind of light, and the types that its methods return.

use super::light_bounds::LightBounds;
use super::{Light, LightSurface, PhotonAim};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Ray};
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};

/// The end of a shadow ray from a surface or medium towards a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadowTarget {
    /// A point of the light. On an area light, the point is offset from the surface, so that this
    /// surface does not occlude the ray.
    Point(Vec3),
    /// The light is at infinity, so the ray has no end.
    Infinity,
}

/// A sampled direction from which direct light arrives at a point. The light may still be occluded.
#[derive(Clone, Copy, Debug)]
pub struct DirectLightSample {
    /// Unit direction from the lit point towards the light.
    pub wi: Vec3,
    /// End of the shadow ray that starts at the lit point.
    pub target: ShadowTarget,
    /// Arriving radiance divided by `pdf`, without the cosine at the lit surface \[W/m²]. For a
    /// delta light, it is the irradiance on a surface that faces the light.
    pub weight: Rgb,
    /// Pdf of `wi` \[1/sr], equal to [`Light::pdf_li`]; `None` for delta lights.
    pub pdf: Option<f32>,
}

/// A sampled ray that leaves a light, with the flux that the ray carries.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// The emitted ray, with a unit direction.
    pub ray: Ray,
    /// Flux \[W] that the ray carries: emitted radiance · cosine, intensity or irradiance, divided
    /// by the pdf of the sampled position and direction. A photon path starts with this flux.
    ///
    /// The expected value of `weight` is the flux that the light emits along all rays that can be
    /// sampled. Samples without a ray count as 0.
    pub weight: Rgb,
}

/// The random points of [`Light::sample_le`] that determine the emitted rays of a light:
/// `position`, `direction` or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmissionDimensions {
    /// True if the emitted ray depends on the random point `position`.
    pub uses_position: bool,
    /// True if the emitted ray depends on the random point `direction`.
    pub uses_direction: bool,
}

/// Position, direction or surface from which light comes.
pub(super) enum LightGeometry<'a> {
    /// A delta light at one position in world space.
    Point(Vec3),
    /// A delta light at infinity, whose rays travel in this unit direction.
    Parallel(Vec3),
    /// An emitting surface at a finite distance.
    Surface(&'a LightSurface),
    /// Light from infinity that arrives from all directions, as from an environment.
    AllDirections,
}

/// Interface that each kind of light implements. [`Light`] calls these methods. Some other methods
/// of `Light`, such as `Light::position`, evaluate `geometry`.
///
/// `sample_li` and `sample_le` must describe the same emitted radiance: camera paths sample direct
/// light by `sample_li`, and photon paths start by `sample_le`.
///
/// Three methods have defaults. A delta light must implement `nominal_strength`. A light that
/// cannot reach all of space should implement `may_illuminate`, so that fewer photons miss the
/// caustic casters. A light with a texture must implement `untextured_light`.
///
/// Lights at one position implement [`PositionalLight`](super::point::PositionalLight) instead.
/// There, the cone of emitted directions is unbounded by default. A light that emits into a
/// narrower cone should override this default, which reduces the variance of light sampling.
pub(super) trait LightSource {
    /// Position, direction or surface from which the light comes.
    fn geometry(&self) -> LightGeometry<'_>;

    /// Samples a direction from which light arrives at `p`, by `u` in \[0, 1)²; `None` if no light
    /// can arrive. Occlusion is ignored ([`Light::sample_li`]).
    fn sample_li(&self, p: Vec3, u: Vec2) -> Option<DirectLightSample>;

    /// Pdf \[1/sr] with which `sample_li` at `p` samples unit direction `wi`, which hits the
    /// light's surface at `hit`; 0 for delta lights ([`Light::pdf_li`]).
    fn pdf_li(&self, p: Vec3, wi: Vec3, hit: Option<&SurfacePoint>) -> f32;

    /// Samples a ray that leaves the light, by two random points in \[0, 1)²; `None` if it carries
    /// no light. `domain` is the scene's bounding sphere ([`Light::sample_le`]).
    fn sample_le(&self, domain: BoundingSphere, position: Vec2, direction: Vec2) -> Option<EmissionSample>;

    /// Samples a ray that leaves the light and enters one of the spheres of `aim`; `None` if it
    /// carries no light ([`Light::sample_le_towards`]).
    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        domain: BoundingSphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample>;

    /// Emitted flux \[W]; for a light at infinity, the flux through a disc with the radius of
    /// `domain`, integrated over directions ([`Light::power`]).
    fn power(&self, domain: BoundingSphere) -> Rgb;

    /// Bounds of the light's positions and emitted directions; `None` for lights at infinity.
    fn bounds(&self) -> Option<LightBounds>;

    /// Strength of a delta light, as a scene file states it: intensity \[W/sr] or irradiance
    /// \[W/m²]. The default `None` is right for all other lights.
    fn nominal_strength(&self) -> Option<Rgb> {
        None
    }

    /// True if the light may shine into `sphere`, ignoring occlusion. The caller has already
    /// expanded `sphere` by rounding errors.
    ///
    /// The default `true` is correct for every light. It is inefficient if the light cannot reach
    /// all of space: photons are then aimed at bounding spheres of casters that the light cannot
    /// reach.
    fn may_illuminate(&self, _sphere: BoundingSphere) -> bool {
        true
    }

    /// Returns a copy of the light that emits its mean radiance, without texture. The default
    /// `None` is right if no texture varies the radiance.
    fn untextured_light(&self) -> Option<Light> {
        None
    }
}
