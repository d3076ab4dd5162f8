//! Lights: how they are seen from a point, and how they emit photons.

mod aim;
mod area;
mod bounds;
mod emit;
mod environment;
mod light_bvh;
mod reach;
mod spot;

pub use aim::Targets;
pub use area::{Area, EmissionTexture, Emitter};
pub use emit::EmissionSample;
pub use environment::{Environment, EnvironmentError};
pub use light_bvh::LightBvhSampler;
pub use spot::Spot;

use crate::color::Rgb;
use crate::math::Sphere;
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// A source of light.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "lights lie in one array, and are asked where they lie")]
pub enum Light {
    /// Radiant intensity \[W/sr], alike in all directions.
    Point {
        /// Place.
        position: Vec3,
        /// Intensity \[W/sr].
        intensity: Rgb,
    },
    /// A point whose intensity is confined to a cone.
    Spot(Spot),
    /// Parallel light from infinity.
    Directional {
        /// Unit direction of travel.
        direction: Vec3,
        /// Irradiance on a surface that faces it \[W/m²].
        irradiance: Rgb,
    },
    /// A surface that radiates from its outer side.
    Area(Area),
    /// Radiance from infinity, from all around.
    Environment(Arc<Environment>),
}

/// Where a shadow ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadowTarget {
    /// At this point, already moved off the light's own surface.
    Point(Vec3),
    /// Nowhere.
    Infinity,
}

/// Light arriving at a point from one sampled direction, before visibility.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// Unit direction towards the light.
    pub wi: Vec3,
    /// Where the shadow ray ends.
    pub reach: ShadowTarget,
    /// Radiance over density per steradian; for points and parallel light, irradiance on a surface that faces it.
    pub irradiance: Rgb,
    /// Density of `wi` \[1/sr], which [`Light::density`] gives for any direction; `None` for points and parallel light, which no
    /// other technique can find.
    pub pdf: Option<f32>,
}

impl Light {
    /// What reaches `p` for `u` in \[0, 1)²; `None` where that is nothing for certain.
    #[inline]
    #[must_use]
    pub fn sample_direct(&self, p: Vec3, u: Vec2) -> Option<DirectSample> {
        match self {
            Self::Point { position, intensity } => from_point(p, *position, |_| *intensity),
            Self::Spot(spot) => from_point(p, spot.position, |w| spot.intensity(w)),
            Self::Directional { direction, irradiance } => Some(DirectSample {
                wi: -*direction,
                reach: ShadowTarget::Infinity,
                irradiance: *irradiance,
                pdf: None,
            }),
            Self::Area(area) => area.sample_direct(p, u),
            Self::Environment(environment) => environment.sample_direct(u),
        }
    }

    /// Density \[1/sr] with which [`Light::sample_direct`] at `p` draws unit `wi`; 0 where it never does. A light with a surface is met
    /// at `seen`, which is `None` for what escapes to infinity.
    #[inline]
    #[must_use]
    pub fn density(&self, p: Vec3, wi: Vec3, seen: Option<&SurfacePoint>) -> f32 {
        match self {
            Self::Point { .. } | Self::Spot(_) | Self::Directional { .. } => 0.0,
            Self::Area(area) => seen.map_or(0.0, |seen| area.density(p, wi, seen)),
            Self::Environment(environment) => environment.density(wi),
        }
    }

    /// Whether it is seen under a solid angle, so that shadows have soft edges.
    #[must_use]
    pub fn has_surface(&self) -> bool {
        matches!(self, Self::Area(_) | Self::Environment(_))
    }

    /// Whether it comes from infinity, so that nothing is behind it.
    #[must_use]
    pub fn is_infinite(&self) -> bool {
        matches!(self, Self::Directional { .. } | Self::Environment(_))
    }

    /// Emitted flux \[W]; for light from infinity, what crosses the disc that `domain` shows it.
    #[must_use]
    pub fn power(&self, domain: Sphere) -> Rgb {
        match self {
            Self::Point { intensity, .. } => *intensity * (4.0 * PI),
            Self::Spot(spot) => spot.power(),
            Self::Directional { irradiance, .. } => *irradiance * (PI * domain.radius * domain.radius),
            Self::Area(area) => area.power(),
            Self::Environment(environment) => environment.power(domain),
        }
    }
}

/// The sample of a point source; `intensity` gets the unit direction from the source.
#[inline]
fn from_point(p: Vec3, position: Vec3, intensity: impl Fn(Vec3) -> Rgb) -> Option<DirectSample> {
    let (d2, wi, _) = crate::math::direction(p, position)?;
    let irradiance = intensity(-wi) / d2;
    (irradiance != Rgb::ZERO).then_some(DirectSample {
        wi,
        reach: ShadowTarget::Point(position),
        irradiance,
        pdf: None,
    })
}

#[cfg(test)]
mod tests;
