//! Lights without a surface, and lights as the course's shading sees them.

use super::LegacyLight;
use crate::color::Rgb;
use crate::light::{DirectionalLight, Light, OrientedSource, PointLight, SpotLight};
use crate::math::{Sphere, Transform};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// How strong a point, spot or directional light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightStrength {
    /// The course's colour: what a white, matt surface that faces the light reflects, at the middle of the scene.
    Course(Rgb),
    /// Intensity \[W/sr], or irradiance \[W/m²] for parallel light.
    Physical(Rgb),
    /// Flux \[W]; for points and spots.
    Power(Rgb),
}

/// A light without a surface.
#[derive(Clone, Debug)]
pub enum SourceKind {
    /// Everywhere alike from a place.
    Point {
        /// Place.
        position: DVec3,
    },
    /// Into a cone.
    Spot {
        /// Place.
        position: DVec3,
        /// Middle of the beam, of any length above zero.
        axis: DVec3,
        /// Half angle of full strength \[radians].
        inner: f64,
        /// Half angle where it ends \[radians].
        outer: f64,
    },
    /// A point light with an orientation: a projector or a goniometric light.
    Oriented(OrientedSource),
    /// Parallel.
    Directional {
        /// Direction of travel, of any length above zero.
        direction: DVec3,
    },
}

impl SourceKind {
    /// Where it is, if it is not infinitely far.
    #[must_use]
    pub fn place(&self) -> Option<DVec3> {
        match *self {
            Self::Point { position } | Self::Spot { position, .. } => Some(position),
            Self::Oriented(ref source) => Some(source.position),
            Self::Directional { .. } => None,
        }
    }

    /// The image under an affine map.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Self {
        match *self {
            Self::Point { position } => Self::Point { position: map.point(position) },
            Self::Spot { position, axis, inner, outer } => {
                Self::Spot { position: map.point(position), axis: map.vector(axis), inner, outer }
            }
            Self::Oriented(ref source) => Self::Oriented(source.transformed(map)),
            Self::Directional { direction } => Self::Directional { direction: map.vector(direction) },
        }
    }
}

/// 1 − cos x with all its digits.
fn one_minus_cos(x: f64) -> f64 {
    let sin = libm::sin(0.5 * x);
    2.0 * sin * sin
}

/// The light and its course colour. A course colour c means irradiance π·c on a facing surface at the middle, so that a white
/// matt surface there reflects radiance c.
pub(super) fn resolve_source(kind: &SourceKind, strength: LightStrength, middle: DVec3) -> (Light, LegacyLight) {
    // A light at the very middle is taken to be one unit away.
    let distance2 = |p: &DVec3| {
        let d2 = (*p - middle).length_squared() as f32;
        if d2 > 0.0 { d2 } else { 1.0 }
    };
    let to_intensity = |position: &DVec3, watts_to_intensity: f32| match strength {
        LightStrength::Course(c) => (c * (PI * distance2(position)), c),
        LightStrength::Physical(i) => (i, i / (PI * distance2(position))),
        LightStrength::Power(w) => (w * watts_to_intensity, w * (watts_to_intensity / (PI * distance2(position)))),
    };
    match kind {
        SourceKind::Point { position } => {
            let (intensity, color) = to_intensity(position, 1.0 / (4.0 * PI));
            let place = (*position - middle).as_vec3();
            (Light::Point(PointLight { position: place, intensity }), LegacyLight::Point(place, color))
        }
        SourceKind::Spot { position, axis, inner, outer } => {
            let place = (*position - middle).as_vec3();
            let mut spot = SpotLight {
                position: place,
                axis: axis.normalize().as_vec3(),
                inner: one_minus_cos(*inner) as f32,
                outer: one_minus_cos(*outer) as f32,
                peak: Rgb::ONE,
            };
            let (peak, color) = to_intensity(position, 1.0 / spot.flux().x);
            spot.peak = peak;
            (Light::Spot(spot), LegacyLight::Point(place, color))
        }
        SourceKind::Oriented(source) => {
            let place = (source.position - middle).as_vec3();
            let (scale, color) = to_intensity(&source.position, source.scale_per_power());
            (source.light(place, scale), LegacyLight::Point(place, color))
        }
        SourceKind::Directional { direction } => {
            let (irradiance, color) = match strength {
                LightStrength::Course(c) => (c * PI, c),
                LightStrength::Physical(e) | LightStrength::Power(e) => (e, e / PI),
            };
            let direction = direction.normalize().as_vec3();
            (Light::Directional(DirectionalLight { direction, irradiance }), LegacyLight::Directional(direction, color))
        }
    }
}

/// An area light as a point at its middle, as strong at the scene's middle as if it faced it.
pub(super) fn course_area_light(light: &Light) -> LegacyLight {
    let center = light.center().unwrap_or(Vec3::ZERO);
    let nowhere = Sphere { center: Vec3::ZERO, radius: 0.0 };
    let d2 = center.length_squared();
    let color = light.power(nowhere) / (PI * PI * if d2 > 0.0 { d2 } else { 1.0 });
    LegacyLight::Point(center, color)
}
