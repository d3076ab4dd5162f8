//! Lights of a [`SceneDescription`](super::SceneDescription), as the scene file states them.

use glam::DVec3;

use super::{DirectionOrTarget, Spanned, TransformStep};

/// A light as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDescription {
    /// A point light with equal intensity in all directions.
    Point {
        /// Position of the point light.
        position: DVec3,
        /// Radiant intensity, flux, or color of the shading model of MIT course 6.837.
        strength: PointLightStrength,
    },
    /// A directional light: parallel light from infinity.
    Directional {
        /// Direction in which the light travels, of any length.
        direction: DVec3,
        /// Irradiance, or color of the shading model of MIT course 6.837.
        strength: DirectionalLightStrength,
    },
    /// A spotlight: a point light limited to a cone.
    Spot {
        /// Position of the cone's apex.
        position: DVec3,
        /// Direction of the cone's axis.
        aim: DirectionOrTarget,
        /// Full opening angle of the cone in degrees, inside (0, 360].
        angle: f64,
        /// Angular width of the soft rim inside the cone in degrees, at most half of `angle`.
        penumbra: f64,
        /// Strength of the light. An intensity or color is the value along the cone's axis.
        strength: PointLightStrength,
    },
    /// A sphere that emits outward.
    Sphere {
        /// Center of the sphere.
        center: DVec3,
        /// Radius of the sphere, above 0.
        radius: f64,
        /// Strength of the light: radiance or flux.
        strength: AreaLightStrength,
    },
    /// A disc that emits on the side of its normal.
    Disc {
        /// Center of the disc.
        center: DVec3,
        /// Normal of the emitting side, of any length.
        normal: DVec3,
        /// Radius of the disc, above 0.
        radius: f64,
        /// Strength of the light: radiance or flux.
        strength: AreaLightStrength,
    },
    /// A parallelogram that emits on the side of `edge0 × edge1`.
    Rectangle {
        /// The corner where both edges start.
        corner: DVec3,
        /// Edge vector from the corner to one neighbor.
        edge0: DVec3,
        /// Edge vector from the corner to the other neighbor.
        edge1: DVec3,
        /// Strength of the light: radiance or flux.
        strength: AreaLightStrength,
    },
    /// A point light with an orientation: a projector or a goniometric light.
    Oriented {
        /// Position of the light.
        position: DVec3,
        /// Axis of the light. A projector and an intensity profile are aligned with it; an
        /// intensity map has its center there.
        aim: DirectionOrTarget,
        /// Up direction of the light's pattern; `None` for +y, or for −z if the axis is parallel to
        /// y.
        up: Option<DVec3>,
        /// Intensity in each direction, relative to `strength`.
        pattern: LightPattern,
        /// Intensity where the pattern is 1, or flux. [`PointLightStrength::Color`] is not allowed.
        strength: PointLightStrength,
    },
    /// A light that moves while the shutter is open.
    Moving {
        /// Steps of the motion. Rotations and scales are about the light's own position.
        ///
        /// The first listed step is applied last.
        steps: Vec<TransformStep>,
        /// The light as it is when the shutter opens.
        light: Box<Spanned<LightDescription>>,
    },
    /// An environment light: radiance that arrives from infinity in all directions. A scene has at
    /// most one.
    Environment(EnvironmentRadiance),
}

impl LightDescription {
    /// Returns the path of the file that the light reads: a picture or an intensity profile; `None`
    /// if it reads no file.
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

    /// True if the light is infinitely far away: a directional or environment light.
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

/// Radiance of an environment light: constant, or given by a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentRadiance {
    /// Constant radiance in W/(m² sr).
    Constant(DVec3),
    /// An equirectangular picture of all directions.
    Picture {
        /// Path of the picture as the text writes it: not empty, without line breaks.
        path: Spanned<String>,
        /// Factor from picture values to radiance in W/(m² sr), at least 0.
        scale: f64,
        /// Right-handed rotation of the picture about the y axis in degrees.
        rotate: f64,
    },
}

/// Relative intensity of an oriented point light in each direction, read from a file.
///
/// Paths are as written in the scene file: not empty, without line breaks.
#[derive(Clone, Debug, PartialEq)]
pub enum LightPattern {
    /// A picture that the light casts like a slide projector.
    Picture {
        /// Path of the picture.
        path: Spanned<String>,
        /// Full vertical angle of view \[degrees], inside (0, 180).
        angle: f64,
    },
    /// Path of an equirectangular picture of the intensity in all directions.
    Map(Spanned<String>),
    /// Path of a text file that lists the intensity by the angle from the light's axis.
    Profile(Spanned<String>),
}

/// Strength of a point light or spotlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointLightStrength {
    /// Color in the shading model of MIT course 6.837, where light does not fall off with
    /// distance.
    Color(DVec3),
    /// Radiant intensity in W/sr.
    Intensity(DVec3),
    /// Radiant flux in W.
    Power(DVec3),
}

/// Strength of a directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionalLightStrength {
    /// Color in the shading model of MIT course 6.837.
    Color(DVec3),
    /// Irradiance in W/m² of a surface perpendicular to the light.
    Irradiance(DVec3),
}

/// Strength of an area light: its radiance or its flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaLightStrength {
    /// Radiance in W/(m² sr), equal in all directions on the emitting side.
    Radiance(DVec3),
    /// Radiant flux in W.
    Power(DVec3),
}
