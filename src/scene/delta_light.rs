//! Strengths of delta lights, and the lights of algorithm `raycast`, which shades as MIT course
//! 6.837 does.

use crate::color::Rgb;
use crate::light::{Light, LightPositionOrDirection, UnscaledDeltaLight};
use crate::math::BoundingSphere;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;

/// Light of algorithm `raycast`, in the shading model of MIT course 6.837: its colour does not fall
/// off with distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mit6837Light {
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
    Mit6837Color(Rgb),
    /// Intensity \[W/sr] of a light with a position; irradiance \[W/m²] of a directional light.
    Physical(Rgb),
    /// Flux \[W] of a light with a position; irradiance \[W/m²] of a directional light.
    Power(Rgb),
}

/// Returns the light in coordinates relative to `origin`, and the light that stands for it in
/// algorithm `raycast`.
///
/// The strength [`LightStrength::Mit6837Color`] with colour c becomes irradiance π·c, on a surface
/// at `origin` that faces the light. A white diffuse surface there reflects radiance c.
pub(super) fn place_delta_light(
    kind: &UnscaledDeltaLight,
    strength: LightStrength,
    origin: DVec3,
) -> (Light, Mit6837Light) {
    match kind.position_or_direction() {
        LightPositionOrDirection::Position(position) => {
            // A light at the origin is treated as if it were one unit away.
            let distance2 = (position - origin).length_squared() as f32;
            let distance2 = if distance2 > 0.0 { distance2 } else { 1.0 };
            let (intensity, color) = match strength {
                LightStrength::Mit6837Color(c) => (c * (PI * distance2), c),
                LightStrength::Physical(i) => (i, i / (PI * distance2)),
                LightStrength::Power(w) => {
                    let intensity_per_watt = kind.intensity_per_watt();
                    (w * intensity_per_watt, w * (intensity_per_watt / (PI * distance2)))
                }
            };
            (kind.to_light(origin, intensity), Mit6837Light::Point((position - origin).as_vec3(), color))
        }
        LightPositionOrDirection::Direction(direction) => {
            let (irradiance, color) = match strength {
                LightStrength::Mit6837Color(c) => (c * PI, c),
                LightStrength::Physical(e) | LightStrength::Power(e) => (e, e / PI),
            };
            let direction = direction.normalize().as_vec3();
            (kind.to_light(origin, irradiance), Mit6837Light::Directional(direction, color))
        }
    }
}

/// The light that stands for an area light in algorithm `raycast`: a point light at the center of
/// the area light.
///
/// Its colour is the radiance that a white diffuse surface at the origin reflects. The surface and
/// the area light are assumed to face each other.
pub(super) fn mit_6837_area_light(light: &Light) -> Mit6837Light {
    let center = light.center_or_surface_point().unwrap_or(Vec3::ZERO);
    let nowhere = BoundingSphere { center: Vec3::ZERO, radius: 0.0 };
    let d2 = center.length_squared();
    let color = light.power(nowhere) / (PI * PI * if d2 > 0.0 { d2 } else { 1.0 });
    Mit6837Light::Point(center, color)
}
