//! Projectors and goniometric lights in the frame of the scene description.

use super::{EquirectangularMap, GoniometricLight, Light, ProjectedPicture, ProjectorLight};
use crate::color::{self, Rgb};
use crate::math::{BoundingSphere, Transform};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Picture or map that defines the relative intensity of a point light in each direction, in the
/// light's own frame.
#[derive(Clone, Debug)]
pub enum IntensityPattern {
    /// The picture of a projector, which emits into a pyramid.
    ProjectedPicture(Arc<ProjectedPicture>),
    /// An equirectangular map over all directions, for a goniometric light.
    Map(Arc<EquirectangularMap>),
}

/// A projector or goniometric light without its strength, in the coordinates of the scene
/// description.
#[derive(Clone, Debug)]
pub struct OrientedPointLight {
    /// Position of the light in the frame of the scene description.
    pub position: DVec3,
    /// Direction in which the center of the pattern is projected, in the frame of the scene
    /// description. Its length is any number above zero.
    pub direction: DVec3,
    /// Direction towards the top of the pattern, not parallel to `direction`.
    pub up: DVec3,
    /// Relative intensity in each direction. [`Self::to_light`] multiplies it by a scale \[W/sr].
    pub pattern: IntensityPattern,
}

impl OrientedPointLight {
    /// Returns a copy of the light with position and directions transformed by `map`.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Self {
        let (position, direction, up) =
            (map.transform_point(self.position), map.transform_vector(self.direction), map.transform_vector(self.up));
        Self { position, direction, up, pattern: self.pattern.clone() }
    }

    /// Creates the light at `position` in world space. A pattern value of 1 gives the intensity
    /// `scale` \[W/sr].
    #[must_use]
    pub fn to_light(&self, position: Vec3, scale: Rgb) -> Light {
        let (direction, up) = (self.direction, self.up);
        match &self.pattern {
            IntensityPattern::ProjectedPicture(picture) => {
                Light::Projector(ProjectorLight::new(position, direction, up, picture.clone(), scale))
            }
            IntensityPattern::Map(map) => {
                Light::Goniometric(GoniometricLight::new(position, direction, up, map.clone(), scale))
            }
        }
    }

    /// Returns the factor \[1/sr] that converts the flux of the light \[W] to its intensity at
    /// pattern value 1 \[W/sr].
    ///
    /// The factor is 1/I, where I is the integral of the pattern over all directions \[sr],
    /// averaged over the color channels.
    #[must_use]
    pub fn intensity_scale_per_watt(&self) -> f32 {
        let nowhere = BoundingSphere { center: Vec3::ZERO, radius: 0.0 };
        1.0 / color::channel_mean(self.to_light(Vec3::ZERO, Rgb::ONE).power(nowhere)).max(f32::MIN_POSITIVE)
    }
}
