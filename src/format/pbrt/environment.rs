//! Converts environment maps of pbrt to the equirectangular maps of Caustica.

use crate::color::Rgb;
use crate::format::imported_environment::equirectangular_image;
use crate::image::Image;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_2_PI, PI, TAU};

/// Number of samples along each side of a pixel of the converted map, for antialiasing. Each sample
/// is a value of pbrt's map.
const SAMPLES_PER_PIXEL_SIDE: u32 = 3;

/// Mapping of directions to pixels in an environment map of pbrt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MapLayout {
    /// Equal-area octahedral map of pbrt-v4 (Clarberg 2008).
    Octahedral,
    /// Map by latitude and longitude of pbrt-v3, with +z at the top.
    LatitudeLongitude,
}

/// Converts an environment map of pbrt to an equirectangular one with +y at the top and −z at the
/// left edge.
///
/// `to_world` maps the light's own space to world space. Returns `None` if `to_world` is singular,
/// or if the converted map would be too large.
pub(super) fn to_equirectangular(image: &Image, layout: MapLayout, to_world: DMat3) -> Option<Image> {
    let (width, height) = match layout {
        MapLayout::Octahedral => (image.width().checked_mul(2)?, image.height()),
        MapLayout::LatitudeLongitude => (image.width(), image.height()),
    };
    let radiance = |direction: DVec3| radiance_in_direction(image, layout, direction.normalize_or(DVec3::Z));
    equirectangular_image(width, height, SAMPLES_PER_PIXEL_SIDE, to_world, &radiance)
}

/// Returns the radiance of pbrt's map in a unit direction of the light's own space, interpolated
/// between pixels.
fn radiance_in_direction(image: &Image, layout: MapLayout, direction: DVec3) -> Rgb {
    let (width, height) = (i64::from(image.width()), i64::from(image.height()));
    let map_point = match layout {
        MapLayout::Octahedral => octahedral_coordinates(direction),
        MapLayout::LatitudeLongitude => DVec2::new(
            (libm::atan2(direction.y, direction.x) / TAU).rem_euclid(1.0),
            libm::acos(direction.z.clamp(-1.0, 1.0)) / PI,
        ),
    };
    let (x, y) = (map_point.x * width as f64 - 0.5, map_point.y * height as f64 - 0.5);
    let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let pixel_at = |x: i64, y: i64| {
        let x = match layout {
            MapLayout::Octahedral => x.clamp(0, width - 1),
            MapLayout::LatitudeLongitude => x.rem_euclid(width),
        };
        image.get(x as u32, y.clamp(0, height - 1) as u32).unwrap_or_default()
    };
    let row = |y: i64| pixel_at(x.floor() as i64, y) * (1.0 - fx) + pixel_at(x.floor() as i64 + 1, y) * fx;
    row(y.floor() as i64) * (1.0 - fy) + row(y.floor() as i64 + 1) * fy
}

/// Returns the point of the equal-area octahedral map in \[0, 1]² that shows a unit direction
/// (Clarberg 2008).
fn octahedral_coordinates(direction: DVec3) -> DVec2 {
    let DVec3 { x, y, z } = direction.abs();
    let radius = (1.0 - z).max(0.0).sqrt();
    let phi = if x == 0.0 && y == 0.0 { 0.0 } else { libm::atan2(y, x) * FRAC_2_PI };
    let v = phi * radius;
    let (u, v) = if direction.z < 0.0 { (1.0 - v, 1.0 - (radius - v)) } else { (radius - v, v) };
    0.5 * DVec2::new(u.copysign(direction.x), v.copysign(direction.y)) + 0.5
}

#[cfg(test)]
mod tests;
