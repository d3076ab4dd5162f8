//! The interface that every kind of light implements, and its sample records.

use super::light_bounds::LightBounds;
use super::{Light, MARGIN, PhotonAim};
use crate::color::Rgb;
use crate::math::{Ray, Sphere};
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

/// One kind of light.
///
/// The default methods describe a delta light at a finite position. [`Light`] documents the
/// methods.
pub(super) trait LightSource {
    /// Implements [`Light::sample_li`].
    fn sample_li(&self, p: Vec3, u: Vec2) -> Option<DirectSample>;

    /// Implements [`Light::pdf_li`].
    #[inline]
    fn pdf_li(&self, _p: Vec3, _wi: Vec3, _hit: Option<&SurfacePoint>) -> f32 {
        0.0
    }

    /// Implements [`Light::sample_le`].
    fn sample_le(&self, domain: Sphere, position: Vec2, direction: Vec2) -> Option<EmissionSample>;

    /// Implements [`Light::sample_le_towards`].
    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        domain: Sphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample>;

    /// Implements [`Light::emission_dimensions`].
    fn emission_dimensions(&self) -> EmissionDimensions {
        EmissionDimensions { position: false, direction: true }
    }

    /// Implements [`Light::power`].
    fn power(&self, domain: Sphere) -> Rgb;

    /// Bounds of positions and directions, without a margin; `None` for light from infinity.
    fn bounds(&self) -> Option<LightBounds>;

    /// Implements [`Light::is_delta`].
    #[inline]
    fn is_delta(&self) -> bool {
        true
    }

    /// Implements [`Light::is_infinite`].
    #[inline]
    fn is_infinite(&self) -> bool {
        false
    }

    /// Implements [`Light::position`].
    fn position(&self) -> Option<Vec3> {
        None
    }

    /// Implements [`Light::emission_point`].
    fn emission_point(&self) -> Option<Vec3> {
        self.position()
    }

    /// Implements [`Light::center`].
    fn center(&self) -> Option<Vec3> {
        self.position()
    }

    /// Implements [`Light::peak`].
    fn peak(&self) -> Option<Rgb>;

    /// Implements [`Light::may_reach`] for a sphere that is already grown by rounding errors.
    fn may_reach(&self, _sphere: Sphere) -> bool {
        true
    }

    /// Implements [`Light::avoids_plane`].
    fn avoids_plane(&self, p: Vec3, n: Vec3) -> bool {
        self.position().is_some_and(|position| {
            let margin = MARGIN * (position.abs().max_element() + p.abs().max_element());
            (position - p).dot(n).abs() > margin
        })
    }

    /// The light with its mean radiance; `None` if no texture varies its radiance.
    fn untextured(&self) -> Option<Light> {
        None
    }
}
