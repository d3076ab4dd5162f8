//! Light sources: direct light at a point, and emission of photons.
//!
//! Each kind of light has a file of its own, which implements `LightSource`. [`Light`] is the enum
//! over the kinds.

mod area;
mod directional;
mod environment;
mod goniometric;
mod light_bounds;
mod light_bvh;
mod oriented;
mod photon_aim;
mod point;
mod projector;
mod source;
mod spherical_map;
mod spot;
#[cfg(test)]
mod tests;

pub use area::{AreaLight, EmissionTexture, LightSurface};
pub use directional::DirectionalLight;
pub use environment::EnvironmentLight;
pub use goniometric::{GoniometricLight, map_from_intensity_profile};
pub use light_bvh::LightBvhSampler;
pub use oriented::{IntensityPattern, OrientedPointLight};
pub use photon_aim::PhotonAim;
pub use point::PointLight;
pub use projector::{ProjectedPicture, ProjectorLight};
pub use source::{DirectSample, EmissionDimensions, EmissionSample, ShadowTarget};
pub use spherical_map::{EmissionPictureError, EquirectangularMap};
pub use spot::SpotLight;

use crate::color::Rgb;
use crate::math::BoundingSphere;
use crate::shape::SurfacePoint;
use glam::{Vec2, Vec3};
use light_bounds::LightBounds;
use source::{LightGeometry, LightSource};
use std::sync::Arc;

/// A light source of any kind.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "lights lie in one array and are sampled where they lie")]
pub enum Light {
    /// A point with equal intensity in all directions.
    Point(PointLight),
    /// A point with its intensity confined to a cone.
    Spot(SpotLight),
    /// A pinhole that projects a picture.
    Projector(ProjectorLight),
    /// A point with an intensity given by a map over all directions.
    Goniometric(GoniometricLight),
    /// Parallel light from infinity.
    Directional(DirectionalLight),
    /// A surface that emits from its outer side.
    Area(AreaLight),
    /// Radiance from infinity in all directions.
    Environment(Arc<EnvironmentLight>),
}

/// Evaluates an expression for the light of whatever kind.
macro_rules! dispatch {
    ($self:expr, $light:ident => $e:expr) => {
        match $self {
            Light::Point($light) => $e,
            Light::Spot($light) => $e,
            Light::Projector($light) => $e,
            Light::Goniometric($light) => $e,
            Light::Directional($light) => $e,
            Light::Area($light) => $e,
            Light::Environment($light) => $e,
        }
    };
}

impl Light {
    /// Samples direct light at `p` by `u` in \[0, 1)², before visibility; `None` if none can
    /// arrive.
    #[inline]
    #[must_use]
    pub fn sample_li(&self, p: Vec3, u: Vec2) -> Option<DirectSample> {
        dispatch!(self, light => light.sample_li(p, u))
    }

    /// Pdf \[1/sr] with which [`Light::sample_li`] at `p` samples unit `wi`; 0 for delta lights.
    ///
    /// `hit` is the point of the light's surface in that direction; `None` for a ray that escapes.
    #[inline]
    #[must_use]
    pub fn pdf_li(&self, p: Vec3, wi: Vec3, hit: Option<&SurfacePoint>) -> f32 {
        dispatch!(self, light => light.pdf_li(p, wi, hit))
    }

    /// Samples an emitted ray by `position` and `direction` in \[0, 1)²; `None` if it carries
    /// nothing.
    ///
    /// Light from infinity starts on a disc across the bounding sphere `domain` of the scene.
    #[must_use]
    pub fn sample_le(&self, domain: BoundingSphere, position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        dispatch!(self, light => light.sample_le(domain, position, direction))
    }

    /// Samples an emitted ray towards the spheres of `aim`; no sampled ray misses all of them.
    #[must_use]
    pub fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        domain: BoundingSphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        dispatch!(self, light => light.sample_le_towards(aim, domain, position, direction))
    }

    /// Which of the two sample points of [`Light::sample_le`] the emitted ray depends on.
    #[must_use]
    pub fn emission_dimensions(&self) -> EmissionDimensions {
        match self.geometry() {
            LightGeometry::Point(_) => EmissionDimensions { position: false, direction: true },
            LightGeometry::Parallel(_) => EmissionDimensions { position: true, direction: false },
            LightGeometry::Surface(_) | LightGeometry::AllDirections => {
                EmissionDimensions { position: true, direction: true }
            }
        }
    }

    /// Emitted flux \[W]; for light from infinity, the flux through a disc with the radius of
    /// `domain`.
    #[must_use]
    pub fn power(&self, domain: BoundingSphere) -> Rgb {
        dispatch!(self, light => light.power(domain))
    }

    /// True if the light is sampled by a delta distribution: it has no extent, and shadows have
    /// hard edges.
    #[inline]
    #[must_use]
    pub fn is_delta(&self) -> bool {
        match self.geometry() {
            LightGeometry::Point(_) | LightGeometry::Parallel(_) => true,
            LightGeometry::Surface(_) | LightGeometry::AllDirections => false,
        }
    }

    /// True if the light comes from infinity.
    #[inline]
    #[must_use]
    pub fn is_infinite(&self) -> bool {
        match self.geometry() {
            LightGeometry::Parallel(_) | LightGeometry::AllDirections => true,
            LightGeometry::Point(_) | LightGeometry::Surface(_) => false,
        }
    }

    /// Position of a light without extent; `None` for all other lights.
    #[must_use]
    pub fn position(&self) -> Option<Vec3> {
        match self.geometry() {
            LightGeometry::Point(position) => Some(position),
            LightGeometry::Parallel(_) | LightGeometry::Surface(_) | LightGeometry::AllDirections => None,
        }
    }

    /// A point from which light leaves, offset from the light's own surface; `None` for light from
    /// infinity.
    #[must_use]
    pub fn emission_point(&self) -> Option<Vec3> {
        match self.geometry() {
            LightGeometry::Point(position) => Some(position),
            LightGeometry::Surface(surface) => Some(surface.emission_point()),
            LightGeometry::Parallel(_) | LightGeometry::AllDirections => None,
        }
    }

    /// Center of the light's bounds, for the shading of ray casting; `None` for light from
    /// infinity.
    #[must_use]
    pub fn center(&self) -> Option<Vec3> {
        match self.geometry() {
            LightGeometry::Point(position) => Some(position),
            LightGeometry::Surface(surface) => Some(surface.center()),
            LightGeometry::Parallel(_) | LightGeometry::AllDirections => None,
        }
    }

    /// Peak intensity \[W/sr] or irradiance \[W/m²] of a delta light; `None` for all other lights.
    #[must_use]
    pub fn peak_strength(&self) -> Option<Rgb> {
        dispatch!(self, light => light.peak_strength())
    }

    /// False only if no unoccluded ray from the light can enter `sphere`; `None` stands for all
    /// space.
    #[must_use]
    pub fn may_illuminate(&self, sphere: Option<BoundingSphere>, domain: BoundingSphere) -> bool {
        let Some(sphere) = sphere else { return true };
        let margin =
            POSITION_ERROR * (sphere.center.abs().max_element() + domain.radius + domain.center.abs().max_element());
        dispatch!(self, light => light.may_illuminate(BoundingSphere { radius: sphere.radius + margin, ..sphere }))
    }

    /// True only if no light travels within the plane through `p` with unit normal `n`.
    ///
    /// Rounding decides whether objects in such a plane occlude such light.
    #[must_use]
    pub fn emits_nothing_in_plane(&self, p: Vec3, n: Vec3) -> bool {
        match self.geometry() {
            LightGeometry::Point(position) => {
                let margin = POSITION_ERROR * (position.abs().max_element() + p.abs().max_element());
                (position - p).dot(n).abs() > margin
            }
            LightGeometry::Parallel(direction) => direction.dot(n).abs() > POSITION_ERROR,
            LightGeometry::Surface(_) | LightGeometry::AllDirections => false,
        }
    }

    /// The light with its mean radiance instead of a texture.
    #[must_use]
    pub fn with_mean_emission(&self) -> Self {
        dispatch!(self, light => light.untextured_light()).unwrap_or_else(|| self.clone())
    }

    /// Where the light emits from.
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        dispatch!(self, light => light.geometry())
    }

    /// Bounds of positions and directions, the box grown by `margin`; `None` for light from
    /// infinity.
    fn bounds(&self, margin: f32) -> Option<LightBounds> {
        dispatch!(self, light => light.bounds()).map(|bounds| bounds.expanded(margin))
    }
}

/// Relative error of f32 positions, with respect to their distance from the origin and from each
/// other.
const POSITION_ERROR: f32 = 1e-5;
