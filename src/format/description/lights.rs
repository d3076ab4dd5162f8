//! What a scene file says of its lights.

use glam::DVec3;

use super::{Aim, Map, Spanned};

/// A source of light.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Shines alike in all directions.
    Point {
        /// Its place.
        position: DVec3,
        /// How strong it is.
        strength: PointStrength,
    },
    /// Parallel light from infinitely far.
    Directional {
        /// The way the light travels, of any length.
        direction: DVec3,
        /// How strong it is.
        strength: DirectionalStrength,
    },
    /// A point light that shines into a cone.
    Spot {
        /// The cone's apex.
        position: DVec3,
        /// The cone's axis.
        aim: Aim,
        /// Full opening of the cone in degrees, inside (0, 360].
        angle: f64,
        /// Width of the soft rim inside the cone in degrees, at most half of `angle`.
        penumbra: f64,
        /// How strong it is; along the axis, where that varies with direction.
        strength: PointStrength,
    },
    /// A sphere that shines outward.
    Sphere {
        /// Its middle.
        center: DVec3,
        /// Its radius.
        radius: f64,
        /// How strong it is.
        strength: AreaStrength,
    },
    /// A disc that shines along its normal's side.
    Disc {
        /// Its middle.
        center: DVec3,
        /// The side that shines, of any length.
        normal: DVec3,
        /// Its radius.
        radius: f64,
        /// How strong it is.
        strength: AreaStrength,
    },
    /// A parallelogram that shines on the side of `edge0 × edge1`.
    Rectangle {
        /// The corner where both edges start.
        corner: DVec3,
        /// From the corner to its first neighbour.
        edge0: DVec3,
        /// From the corner to its other neighbour.
        edge1: DVec3,
        /// How strong it is.
        strength: AreaStrength,
    },
    /// A point light with an orientation: a projector or a goniometric light.
    Oriented {
        /// Position.
        position: DVec3,
        /// Axis of projection, or center of the map.
        aim: Aim,
        /// Upper side of the pattern; `None` for +y, or for −z if the aim is parallel to y.
        up: Option<DVec3>,
        /// Intensity by direction.
        pattern: LightPattern,
        /// Intensity at pattern value 1, or flux. Never a color.
        strength: PointStrength,
    },
    /// A light that moves while the shutter is open.
    Moving {
        /// As of [`Object::Moving`](super::Object::Moving), but as if the light's place were the origin.
        maps: Vec<Map>,
        /// What moves.
        light: Box<Spanned<Light>>,
    },
    /// Light from all around, infinitely far. There is at most one.
    Environment(EnvironmentRadiance),
}

/// What comes from all around.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentRadiance {
    /// The same radiance in W/(m² sr) from everywhere.
    Constant(DVec3),
    /// A picture of all directions.
    Picture {
        /// As written: not empty, no line breaks.
        path: Spanned<String>,
        /// What the picture's values are multiplied by to be radiances, at least 0.
        scale: f64,
        /// How far it is turned about the y axis, right-handed, in degrees.
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

/// How strong a point light or spotlight is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointStrength {
    /// The course's colour, which does not fall off with distance.
    Color(DVec3),
    /// Radiant intensity in W/sr.
    Intensity(DVec3),
    /// Total flux in W.
    Power(DVec3),
}

/// How strong a directional light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionalStrength {
    /// The course's colour.
    Color(DVec3),
    /// Irradiance in W/m² on a surface that faces the light.
    Irradiance(DVec3),
}

/// How strong a light with a surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaStrength {
    /// Radiance in W/(m² sr), alike in all directions of the shining side.
    Radiance(DVec3),
    /// Total flux in W.
    Power(DVec3),
}
