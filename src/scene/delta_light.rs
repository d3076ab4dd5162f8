//! Delta lights of a scene description, and their counterparts in the shading model of MIT course
//! 6.837.

use crate::color::Rgb;
use crate::light::{DirectionalLight, Light, OrientedPointLight, PointLight, SpotLight};
use crate::math::{BoundingSphere, Transform};
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Light in the shading model of MIT course 6.837. Its colour does not fall off with distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LegacyLight {
    /// Point light: its position and colour.
    Point(Vec3, Rgb),
    /// Directional light: the unit direction in which the light travels, and its colour.
    Directional(Vec3, Rgb),
}

/// Strength of a delta light, in one of three units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightStrength {
    /// Colour in the shading model of MIT course 6.837: the radiance that a white diffuse surface
    /// at the origin reflects when it faces the light.
    LegacyColor(Rgb),
    /// Intensity \[W/sr], or irradiance \[W/m²] of a directional light.
    Physical(Rgb),
    /// Flux \[W] of a light with a position; irradiance \[W/m²] of a directional light.
    Power(Rgb),
}

/// Kind and placement of a delta light, which emits from one point or from one direction.
/// Coordinates are world coordinates.
#[derive(Clone, Debug)]
pub enum DeltaLightKind {
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

impl DeltaLightKind {
    /// Position of the light; `None` for a directional light.
    #[must_use]
    pub fn position(&self) -> Option<DVec3> {
        match *self {
            Self::Point { position } | Self::Spot { position, .. } => Some(position),
            Self::Oriented(ref source) => Some(source.position),
            Self::Directional { .. } => None,
        }
    }

    /// True if a rotation of the light about its position changes the light that it emits.
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
}

/// 1 − cos x, for x in radians, computed without cancellation.
fn one_minus_cos(x: f64) -> f64 {
    let sin = libm::sin(0.5 * x);
    2.0 * sin * sin
}

/// Returns the light in coordinates relative to `origin`, and its counterpart in the shading model
/// of MIT course 6.837.
///
/// The strength [`LightStrength::LegacyColor`] with colour c becomes irradiance π·c, on a surface
/// at `origin` that faces the light. A white diffuse surface there reflects radiance c.
pub(super) fn place_delta_light(kind: &DeltaLightKind, strength: LightStrength, origin: DVec3) -> (Light, LegacyLight) {
    // A light at the origin is treated as one unit away.
    let distance2 = |p: &DVec3| {
        let d2 = (*p - origin).length_squared() as f32;
        if d2 > 0.0 { d2 } else { 1.0 }
    };
    let to_intensity = |position: &DVec3, watts_to_intensity: f32| match strength {
        LightStrength::LegacyColor(c) => (c * (PI * distance2(position)), c),
        LightStrength::Physical(i) => (i, i / (PI * distance2(position))),
        LightStrength::Power(w) => (w * watts_to_intensity, w * (watts_to_intensity / (PI * distance2(position)))),
    };
    match kind {
        DeltaLightKind::Point { position } => {
            let (intensity, color) = to_intensity(position, 1.0 / (4.0 * PI));
            let center = (*position - origin).as_vec3();
            (Light::Point(PointLight { position: center, intensity }), LegacyLight::Point(center, color))
        }
        DeltaLightKind::Spot { position, axis, inner, outer } => {
            let center = (*position - origin).as_vec3();
            let mut spot = SpotLight {
                position: center,
                axis: axis.normalize().as_vec3(),
                inner_one_minus_cos: one_minus_cos(*inner) as f32,
                outer_one_minus_cos: one_minus_cos(*outer) as f32,
                peak: Rgb::ONE,
            };
            let (peak, color) = to_intensity(position, 1.0 / spot.flux().x);
            spot.peak = peak;
            (Light::Spot(spot), LegacyLight::Point(center, color))
        }
        DeltaLightKind::Oriented(source) => {
            let center = (source.position - origin).as_vec3();
            let (scale, color) = to_intensity(&source.position, source.intensity_scale_per_watt());
            (source.to_light(center, scale), LegacyLight::Point(center, color))
        }
        DeltaLightKind::Directional { direction } => {
            let (irradiance, color) = match strength {
                LightStrength::LegacyColor(c) => (c * PI, c),
                LightStrength::Physical(e) | LightStrength::Power(e) => (e, e / PI),
            };
            let direction = direction.normalize().as_vec3();
            (Light::Directional(DirectionalLight { direction, irradiance }), LegacyLight::Directional(direction, color))
        }
    }
}

/// Counterpart of an area light in the shading model of MIT course 6.837: a point light at the area
/// light's center.
///
/// Its colour is the radiance that a white diffuse surface at the origin reflects, if the area
/// light and the surface face each other.
pub(super) fn legacy_area_light(light: &Light) -> LegacyLight {
    let center = light.center().unwrap_or(Vec3::ZERO);
    let nowhere = BoundingSphere { center: Vec3::ZERO, radius: 0.0 };
    let d2 = center.length_squared();
    let color = light.power(nowhere) / (PI * PI * if d2 > 0.0 { d2 } else { 1.0 });
    LegacyLight::Point(center, color)
}
