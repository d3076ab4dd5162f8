//! Description of point lights with an orientation, in the coordinates of a scene description.

use super::{EquirectangularMap, GoniometricLight, Light, ProjectedPicture, ProjectorLight};
use crate::color::{self, Rgb};
use crate::math::{BoundingSphere, Transform};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Intensity of a light by direction, in the frame of the light.
#[derive(Clone, Debug)]
pub enum IntensityPattern {
    /// The picture of a projector.
    ProjectedPicture(Arc<ProjectedPicture>),
    /// An equirectangular map.
    Map(Arc<EquirectangularMap>),
}

/// A point light with an orientation and an intensity pattern.
#[derive(Clone, Debug)]
pub struct OrientedPointLight {
    /// Position.
    pub position: DVec3,
    /// Axis of projection, or center of the map; of any length above zero.
    pub direction: DVec3,
    /// Upper side of the pattern, not parallel to `direction`.
    pub up: DVec3,
    /// Intensity by direction.
    pub pattern: IntensityPattern,
}

impl OrientedPointLight {
    /// The image under an affine map.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Self {
        let (position, direction, up) =
            (map.transform_point(self.position), map.transform_vector(self.direction), map.transform_vector(self.up));
        Self { position, direction, up, pattern: self.pattern.clone() }
    }

    /// The light at `position` in world space; pattern value 1 means intensity `scale` \[W/sr].
    #[must_use]
    pub fn light(&self, position: Vec3, scale: Rgb) -> Light {
        let (direction, up) = (self.direction, self.up);
        match &self.pattern {
            IntensityPattern::ProjectedPicture(slide) => {
                Light::Projector(ProjectorLight::new(position, direction, up, slide.clone(), scale))
            }
            IntensityPattern::Map(map) => {
                Light::Goniometric(GoniometricLight::new(position, direction, up, map.clone(), scale))
            }
        }
    }

    /// Scale of the intensity per flux \[1/sr]: the inverse integral of the pattern, mean over the
    /// channels.
    #[must_use]
    pub fn intensity_scale_per_watt(&self) -> f32 {
        let nowhere = BoundingSphere { center: Vec3::ZERO, radius: 0.0 };
        1.0 / color::channel_mean(self.light(Vec3::ZERO, Rgb::ONE).power(nowhere)).max(f32::MIN_POSITIVE)
    }
}
