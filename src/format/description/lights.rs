//! Lights of a description.

use glam::DVec3;

use super::{DirectionOrTarget, Spanned, TransformStep};

/// A source of light.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDescription {
    /// A point light, equal in all directions.
    Point {
        /// Position.
        position: DVec3,
        /// Strength.
        strength: PointLightStrength,
    },
    /// Parallel light from infinitely far.
    Directional {
        /// Direction in which the light travels, of any length.
        direction: DVec3,
        /// Strength.
        strength: DirectionalLightStrength,
    },
    /// A point light limited to a cone.
    Spot {
        /// The cone's apex.
        position: DVec3,
        /// The cone's axis.
        aim: DirectionOrTarget,
        /// Full opening of the cone in degrees, inside (0, 360].
        angle: f64,
        /// Width of the soft rim inside the cone in degrees, at most half of `angle`.
        penumbra: f64,
        /// Strength; along the axis, if it varies with direction.
        strength: PointLightStrength,
    },
    /// A sphere that emits outward.
    Sphere {
        /// Center.
        center: DVec3,
        /// Radius.
        radius: f64,
        /// Strength.
        strength: AreaLightStrength,
    },
    /// A disc that emits on the side of its normal.
    Disc {
        /// Center.
        center: DVec3,
        /// Normal of the emitting side, of any length.
        normal: DVec3,
        /// Radius.
        radius: f64,
        /// Strength.
        strength: AreaLightStrength,
    },
    /// A parallelogram that emits on the side of `edge0 × edge1`.
    Rectangle {
        /// The corner where both edges start.
        corner: DVec3,
        /// From the corner to its first neighbour.
        edge0: DVec3,
        /// From the corner to its other neighbour.
        edge1: DVec3,
        /// Strength.
        strength: AreaLightStrength,
    },
    /// A point light with an orientation: a projector or a goniometric light.
    Oriented {
        /// Position.
        position: DVec3,
        /// Axis of projection, or center of the map.
        aim: DirectionOrTarget,
        /// Upper side of the pattern; `None` for +y, or for −z if the aim is parallel to y.
        up: Option<DVec3>,
        /// Intensity by direction.
        pattern: LightPattern,
        /// Intensity at pattern value 1, or flux. Never a color.
        strength: PointLightStrength,
    },
    /// A light that moves while the shutter is open.
    Moving {
        /// Motion, like that of [`ObjectDescription::Moving`](super::ObjectDescription::Moving),
        /// but about the light's own position.
        maps: Vec<TransformStep>,
        /// The light.
        light: Box<Spanned<LightDescription>>,
    },
    /// Light from infinity in all directions. A scene has at most one.
    Environment(EnvironmentRadiance),
}

impl LightDescription {
    /// Returns the path of the file that the light names.
    #[must_use]
    pub fn file_path_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Moving { light, .. } => light.value.file_path_mut(),
            Self::Environment(EnvironmentRadiance::Picture { path, .. }) => Some(&mut path.value),
            Self::Oriented { pattern, .. } => match pattern {
                LightPattern::Picture { path, .. } | LightPattern::Map(path) | LightPattern::Profile(path) => {
                    Some(&mut path.value)
                }
            },
            Self::Point { .. }
            | Self::Directional { .. }
            | Self::Spot { .. }
            | Self::Sphere { .. }
            | Self::Disc { .. }
            | Self::Rectangle { .. }
            | Self::Environment(EnvironmentRadiance::Constant(_)) => None,
        }
    }

    /// True if the light comes from infinity.
    #[must_use]
    pub fn is_infinite(&self) -> bool {
        match self {
            Self::Moving { light, .. } => light.value.is_infinite(),
            Self::Directional { .. } | Self::Environment(_) => true,
            Self::Point { .. }
            | Self::Spot { .. }
            | Self::Oriented { .. }
            | Self::Sphere { .. }
            | Self::Disc { .. }
            | Self::Rectangle { .. } => false,
        }
    }
}

/// Radiance of an environment light.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentRadiance {
    /// Constant radiance in W/(m² sr).
    Constant(DVec3),
    /// A picture of all directions.
    Picture {
        /// Path as written: not empty, no line breaks.
        path: Spanned<String>,
        /// Factor from picture values to radiance, at least 0.
        scale: f64,
        /// Rotation about the y axis, right-handed, in degrees.
        rotate: f64,
    },
}

/// Intensity pattern of an oriented point light. Paths are not empty and have no line breaks.
#[derive(Clone, Debug, PartialEq)]
pub enum LightPattern {
    /// A projected picture.
    Picture {
        /// Path of the picture.
        path: Spanned<String>,
        /// Full vertical angle of view \[degrees], inside (0, 180).
        angle: f64,
    },
    /// An equirectangular picture of the intensity in all directions.
    Map(Spanned<String>),
    /// A table of intensity by angle from the aim.
    Profile(Spanned<String>),
}

/// Strength of a point light or spotlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointLightStrength {
    /// Color of MIT 6.837, which does not fall off with distance.
    Color(DVec3),
    /// Radiant intensity in W/sr.
    Intensity(DVec3),
    /// Radiant flux in W.
    Power(DVec3),
}

/// Strength of a directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionalLightStrength {
    /// Color of MIT 6.837.
    Color(DVec3),
    /// Irradiance in W/m² on a surface that faces the light.
    Irradiance(DVec3),
}

/// Strength of an area light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaLightStrength {
    /// Radiance in W/(m² sr), equal in all directions of the emitting side.
    Radiance(DVec3),
    /// Radiant flux in W.
    Power(DVec3),
}
