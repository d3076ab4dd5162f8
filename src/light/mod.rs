//! Light sources, which are sampled for direct light and for photon emission.
//!
//! Each kind of light has a file of its own. Its type implements the trait `LightSource`, or
//! `PositionalLight` if the light leaves from one point. The enum [`Light`] holds a light of any
//! kind.
//!
//! A new kind needs four files: one here with its variant of [`Light`] in this file, and one in
//! `format/lights/` with its line in `format/lights/mod.rs`. A light with an orientation is also a
//! variant of `IntensityPattern` in `oriented.rs`; the builder and the animation then need no
//! change.
//!
//! A light of a scene file is a `LightDescription` first. The scene builder keeps lights at one
//! position or direction as [`UnscaledDeltaLight`], so that they can move. For a given time, it
//! makes a [`Light`] from each of them.

mod area;
mod directional;
mod environment;
mod equirectangular_map;
mod goniometric;
mod light_bounds;
mod light_bvh;
mod oriented;
mod photon_aim;
mod point;
mod projector;
mod source;
mod spot;
#[cfg(test)]
mod tests;

pub use area::{AreaLight, EmissionTexture, LightSurface};
pub use directional::DirectionalLight;
pub use environment::EnvironmentLight;
pub use equirectangular_map::{EmissionPictureError, EquirectangularMap};
pub use goniometric::{GoniometricLight, map_from_intensity_profile};
pub use light_bvh::LightBvhSampler;
pub use oriented::{IntensityPattern, OrientedPointLight};
pub use photon_aim::PhotonAim;
pub use point::PointLight;
pub use projector::{ProjectedPicture, ProjectorLight};
pub use source::{DirectLightSample, EmissionDimensions, EmissionSample, ShadowTarget};
pub use spot::SpotLight;

use crate::color::Rgb;
use crate::math::{BoundingSphere, Transform};
use crate::shape::SurfacePoint;
use glam::{DVec3, Vec2, Vec3};
use light_bounds::LightBounds;
use source::{LightGeometry, LightSource};
use std::f32::consts::PI;
use std::sync::Arc;

/// A light source of the built scene, in world space.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "lights lie in one array and are sampled where they lie")]
pub enum Light {
    /// A point light with equal intensity in all directions.
    Point(PointLight),
    /// A point light that emits into a cone.
    Spot(SpotLight),
    /// A point light that projects a picture.
    Projector(ProjectorLight),
    /// A point light whose intensity is a map over all directions.
    Goniometric(GoniometricLight),
    /// Parallel rays from infinity, such as sunlight.
    Directional(DirectionalLight),
    /// A surface that emits on its outer side.
    Area(AreaLight),
    /// Light from infinity that arrives from all directions.
    Environment(Arc<EnvironmentLight>),
}

/// Matches on `$self`, a [`Light`], and evaluates the expression `$e` for all variants.
///
/// In the expression, `$light` is the concrete light inside the variant, such as a [`PointLight`].
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
    /// Samples a direction from which light arrives at `p`, by `u` in \[0, 1)².
    ///
    /// The sample ignores occlusion, so the caller must trace a shadow ray. Returns `None` if no
    /// light can arrive from the sampled point of the light.
    #[inline]
    #[must_use]
    pub fn sample_li(&self, p: Vec3, u: Vec2) -> Option<DirectLightSample> {
        dispatch!(self, light => light.sample_li(p, u))
    }

    /// Pdf \[1/sr] with which [`Light::sample_li`] at `p` samples unit direction `wi`.
    ///
    /// `hit` is the point where the ray from `p` along `wi` hits the light's surface; `None` if the
    /// ray escapes to infinity. Delta lights return 0.
    #[inline]
    #[must_use]
    pub fn pdf_li(&self, p: Vec3, wi: Vec3, hit: Option<&SurfacePoint>) -> f32 {
        dispatch!(self, light => light.pdf_li(p, wi, hit))
    }

    /// Samples a ray that leaves the light, by the random points `position` and `direction` in \[0,
    /// 1)². Lights at one point ignore `position`, directional lights ignore `direction`.
    ///
    /// `domain` is the bounding sphere of the scene. Rays of lights at infinity start on a disc
    /// that touches this sphere. Returns `None` if the ray carries no light.
    #[must_use]
    pub fn sample_le(&self, domain: BoundingSphere, position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        dispatch!(self, light => light.sample_le(domain, position, direction))
    }

    /// Samples a ray that leaves the light and enters one of the spheres of `aim`; `None` if the
    /// ray carries no light.
    ///
    /// `domain` is the bounding sphere of the scene. `position` and `direction` are random points
    /// in \[0, 1)², as for [`Light::sample_le`].
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

    /// Tells which of the random points `position` and `direction` of [`Light::sample_le`]
    /// determine the rays of this light.
    #[must_use]
    pub fn emission_dimensions(&self) -> EmissionDimensions {
        match self.geometry() {
            LightGeometry::Point(_) => EmissionDimensions { uses_position: false, uses_direction: true },
            LightGeometry::Parallel(_) => EmissionDimensions { uses_position: true, uses_direction: false },
            LightGeometry::Surface(_) | LightGeometry::AllDirections => {
                EmissionDimensions { uses_position: true, uses_direction: true }
            }
        }
    }

    /// Emitted flux \[W].
    ///
    /// For a light at infinity, it is the flux through a disc with the radius of `domain`,
    /// integrated over the directions of the light. `domain` is the bounding sphere of the scene.
    #[must_use]
    pub fn power(&self, domain: BoundingSphere) -> Rgb {
        dispatch!(self, light => light.power(domain))
    }

    /// True for a delta light, such as a point or directional light: it reaches each point of the
    /// scene from one direction only.
    #[inline]
    #[must_use]
    pub fn is_delta(&self) -> bool {
        match self.geometry() {
            LightGeometry::Point(_) | LightGeometry::Parallel(_) => true,
            LightGeometry::Surface(_) | LightGeometry::AllDirections => false,
        }
    }

    /// True for directional lights and environment lights, whose light comes from infinity.
    #[inline]
    #[must_use]
    pub fn is_infinite(&self) -> bool {
        match self.geometry() {
            LightGeometry::Parallel(_) | LightGeometry::AllDirections => true,
            LightGeometry::Point(_) | LightGeometry::Surface(_) => false,
        }
    }

    /// World-space position of a point, spot, projector or goniometric light; `None` for all other
    /// lights.
    #[must_use]
    pub fn position(&self) -> Option<Vec3> {
        match self.geometry() {
            LightGeometry::Point(position) => Some(position),
            LightGeometry::Parallel(_) | LightGeometry::Surface(_) | LightGeometry::AllDirections => None,
        }
    }

    /// World-space point that stands for the position of the whole light; `None` for lights at
    /// infinity.
    ///
    /// For an area light, it is a point near the surface, on its outer side. The point is used
    /// where one position must do, such as for equiangular sampling in a medium.
    #[must_use]
    pub fn representative_point(&self) -> Option<Vec3> {
        match self.geometry() {
            LightGeometry::Point(position) => Some(position),
            LightGeometry::Surface(surface) => Some(surface.representative_point()),
            LightGeometry::Parallel(_) | LightGeometry::AllDirections => None,
        }
    }

    /// Center of the light in world space; `None` for lights at infinity.
    ///
    /// If the light consists of mesh triangles, the result is an arbitrary point of these
    /// triangles. The algorithm `raycast` replaces an area light by a point light at this point.
    #[must_use]
    pub fn center_or_surface_point(&self) -> Option<Vec3> {
        match self.geometry() {
            LightGeometry::Point(position) => Some(position),
            LightGeometry::Surface(surface) => Some(surface.center_or_surface_point()),
            LightGeometry::Parallel(_) | LightGeometry::AllDirections => None,
        }
    }

    /// Strength of a delta light, as a scene file states it; `None` for area and environment
    /// lights.
    ///
    /// For a directional light, it is the irradiance at normal incidence \[W/m²]. For a point or
    /// spot light, it is the largest intensity \[W/sr]. For a projector or goniometric light, it is
    /// the intensity where the picture or map has the value 1 \[W/sr].
    #[must_use]
    pub fn nominal_strength(&self) -> Option<Rgb> {
        dispatch!(self, light => light.nominal_strength())
    }

    /// True if the light may shine into `sphere`, ignoring occlusion; false only if it certainly
    /// does not.
    ///
    /// If `sphere` is `None`, which stands for all of space, the result is true. `domain` is the
    /// bounding sphere of the scene.
    #[must_use]
    pub fn may_illuminate(&self, sphere: Option<BoundingSphere>, domain: BoundingSphere) -> bool {
        let Some(sphere) = sphere else { return true };
        let farthest = sphere.center.abs().max_element() + domain.radius + domain.center.abs().max_element();
        let margin = RELATIVE_POSITION_ERROR * farthest;
        dispatch!(self, light => light.may_illuminate(BoundingSphere { radius: sphere.radius + margin, ..sphere }))
    }

    /// True if no ray of the light lies within the plane through `p` with unit normal `n`, up to
    /// rounding. Always false for area and environment lights.
    ///
    /// A ray within the plane grazes each flat object in this plane. Rounding then decides whether
    /// the object occludes the ray.
    #[must_use]
    pub fn emits_no_ray_within_plane(&self, p: Vec3, n: Vec3) -> bool {
        match self.geometry() {
            LightGeometry::Point(position) => {
                let margin = RELATIVE_POSITION_ERROR * (position.abs().max_element() + p.abs().max_element());
                (position - p).dot(n).abs() > margin
            }
            LightGeometry::Parallel(direction) => direction.dot(n).abs() > RELATIVE_POSITION_ERROR,
            LightGeometry::Surface(_) | LightGeometry::AllDirections => false,
        }
    }

    /// Reference to the area light in this enum value; `None` for another kind of light.
    #[inline]
    #[must_use]
    pub fn as_area_light(&self) -> Option<&AreaLight> {
        match self {
            Self::Area(area) => Some(area),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Projector(_)
            | Self::Goniometric(_)
            | Self::Directional(_)
            | Self::Environment(_) => None,
        }
    }

    /// Mutable reference to the area light in this enum value; `None` for another kind of light.
    pub(crate) fn as_area_light_mut(&mut self) -> Option<&mut AreaLight> {
        match self {
            Self::Area(area) => Some(area),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Projector(_)
            | Self::Goniometric(_)
            | Self::Directional(_)
            | Self::Environment(_) => None,
        }
    }

    /// Reference to the environment light in this enum value; `None` for another kind of light.
    #[inline]
    #[must_use]
    pub fn as_environment_light(&self) -> Option<&EnvironmentLight> {
        match self {
            Self::Environment(environment) => Some(environment),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Projector(_)
            | Self::Goniometric(_)
            | Self::Directional(_)
            | Self::Area(_) => None,
        }
    }

    /// True if a texture varies the radiance of the light's surface.
    #[must_use]
    pub fn has_emission_texture(&self) -> bool {
        self.as_area_light().is_some_and(|area| area.texture.is_some())
    }

    /// Returns the light without its emission texture: its radiance is the texture's mean. A light
    /// without emission texture is returned unchanged.
    #[must_use]
    pub fn with_mean_emission(&self) -> Self {
        dispatch!(self, light => light.untextured_light()).unwrap_or_else(|| self.clone())
    }

    /// Position, direction or surface from which the light comes.
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        dispatch!(self, light => light.geometry())
    }

    /// Bounds of the light's positions and emitted directions; `None` for lights at infinity.
    ///
    /// The box of positions is expanded by `margin` \[length].
    fn bounds(&self, margin: f32) -> Option<LightBounds> {
        dispatch!(self, light => light.bounds()).map(|bounds| bounds.expanded(margin))
    }
}

/// A delta light as a scene file describes it, but without its strength. Positions and directions
/// are in f64, in the coordinates of the scene description.
#[derive(Clone, Debug)]
pub enum UnscaledDeltaLight {
    /// A point light, which emits equally in all directions.
    Point {
        /// Position of the point light.
        position: DVec3,
    },
    /// A spotlight, which emits into a cone.
    Spot {
        /// Position of the spotlight.
        position: DVec3,
        /// Axis of the spotlight's cone, of any length above zero.
        axis: DVec3,
        /// Angle from the axis up to which the spotlight has full intensity \[radians].
        inner: f64,
        /// Angle from the axis beyond which the spotlight's intensity is zero \[radians].
        outer: f64,
    },
    /// A point light with an orientation: a projector or a goniometric light.
    Oriented(OrientedPointLight),
    /// Parallel light from infinity.
    Directional {
        /// Direction in which the light travels, of any length above zero.
        direction: DVec3,
    },
}

/// Position of a delta light, or direction in which its parallel light travels, in the coordinates
/// of the scene description.
#[derive(Clone, Copy, Debug)]
pub enum LightPositionOrDirection {
    /// Position of the light.
    Position(DVec3),
    /// Direction in which parallel light travels, of any length above zero.
    Direction(DVec3),
}

impl UnscaledDeltaLight {
    /// Position of the light, or direction of travel of a directional light.
    #[must_use]
    pub fn position_or_direction(&self) -> LightPositionOrDirection {
        match self {
            Self::Point { position } | Self::Spot { position, .. } => LightPositionOrDirection::Position(*position),
            Self::Oriented(source) => LightPositionOrDirection::Position(source.position),
            Self::Directional { direction } => LightPositionOrDirection::Direction(*direction),
        }
    }

    /// Position of the light; `None` for a directional light.
    #[must_use]
    pub fn position(&self) -> Option<DVec3> {
        match self.position_or_direction() {
            LightPositionOrDirection::Position(position) => Some(position),
            LightPositionOrDirection::Direction(_) => None,
        }
    }

    /// True if the emission depends on the orientation of the light, so that a rotation changes it:
    /// all delta lights except [`Self::Point`].
    #[must_use]
    pub fn changes_by_rotation(&self) -> bool {
        match self {
            Self::Point { .. } => false,
            Self::Spot { .. } | Self::Oriented(_) | Self::Directional { .. } => true,
        }
    }

    /// Returns a copy of this light, transformed by `map`.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Self {
        match *self {
            Self::Point { position } => Self::Point { position: map.transform_point(position) },
            Self::Spot { position, axis, inner, outer } => {
                Self::Spot { position: map.transform_point(position), axis: map.transform_vector(axis), inner, outer }
            }
            Self::Oriented(ref source) => Self::Oriented(source.transformed(map)),
            Self::Directional { direction } => Self::Directional { direction: map.transform_vector(direction) },
        }
    }

    /// Returns the intensity \[W/sr] per watt of flux, as a factor \[1/sr]. The product of this
    /// factor and the flux \[W] can be passed to [`Self::to_light`] as `strength`.
    ///
    /// The factor of a directional light is 1: a number that a scene file gives as its power is
    /// taken as irradiance \[W/m²], because a directional light has no total flux.
    #[must_use]
    pub fn intensity_per_watt(&self) -> f32 {
        match self {
            Self::Point { .. } => 1.0 / (4.0 * PI),
            Self::Spot { axis, inner, outer, .. } => {
                1.0 / SpotLight::new(Vec3::ZERO, *axis, *inner, *outer, Rgb::ONE).flux().x
            }
            Self::Oriented(source) => source.intensity_scale_per_watt(),
            Self::Directional { .. } => 1.0,
        }
    }

    /// Creates the light with the given strength, in coordinates relative to `origin`.
    ///
    /// `strength` is the irradiance \[W/m²] of a directional light, and the largest intensity
    /// \[W/sr] of a point light or spotlight. For a projector or goniometric light, it is the
    /// intensity where the picture or map has the value 1.
    #[must_use]
    pub fn to_light(&self, origin: DVec3, strength: Rgb) -> Light {
        let relative = |position: &DVec3| (*position - origin).as_vec3();
        match self {
            Self::Point { position } => Light::Point(PointLight { position: relative(position), intensity: strength }),
            Self::Spot { position, axis, inner, outer } => {
                Light::Spot(SpotLight::new(relative(position), *axis, *inner, *outer, strength))
            }
            Self::Oriented(source) => source.to_light(relative(&source.position), strength),
            Self::Directional { direction } => Light::Directional(DirectionalLight {
                direction: direction.normalize().as_vec3(),
                irradiance: strength,
            }),
        }
    }
}

/// Upper bound of the relative rounding error of f32 positions. The margin for comparisons of
/// positions at the distance d from the origin is the bound times d \[length]. The margin for
/// angles is the bound itself \[radians].
const RELATIVE_POSITION_ERROR: f32 = 1e-5;
