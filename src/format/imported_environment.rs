//! Converts the environment map of an imported scene to the equirectangular map of Caustica.

use crate::color::Rgb;
use crate::image::Image;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// Greatest deviation of an environment map's transform from a rotation about y, relative to the
/// lengths of the transform's axes.
///
/// A map with a smaller deviation is only rotated. Any other map is resampled.
const UPRIGHT_TOLERANCE: f64 = 1e-6;

/// Number of samples along each side of a pixel of the resampled map, for antialiasing. Each sample
/// is a value of the original map.
const SAMPLES_PER_PIXEL_SIDE: u32 = 4;

/// Returns an equirectangular map of `width` by `height` pixels, with +y at the top and −z at the
/// left edge.
///
/// `radiance` returns the radiance in a direction of the light's own space, of any length above 0;
/// `to_world` maps this space to world space. For antialiasing, each pixel is the mean of
/// `samples_per_side`² directions. Returns `None` if `to_world` is singular, or if the map would be
/// too large.
pub(super) fn equirectangular_image(
    width: u32,
    height: u32,
    samples_per_side: u32,
    to_world: DMat3,
    radiance: &dyn Fn(DVec3) -> Rgb,
) -> Option<Image> {
    let inverse = to_world.inverse();
    if !inverse.is_finite() {
        return None;
    }
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for row in 0..height {
        for column in 0..width {
            let mut sum = DVec3::ZERO;
            for sample in 0..samples_per_side * samples_per_side {
                let within = |i: u32| (f64::from(i) + 0.5) / f64::from(samples_per_side);
                let phi = (f64::from(column) + within(sample % samples_per_side)) / f64::from(width) * TAU;
                let theta = (f64::from(row) + within(sample / samples_per_side)) / f64::from(height) * PI;
                let (sin, cos) = (libm::sin(theta), libm::cos(theta));
                let world = DVec3::new(libm::sin(phi) * sin, cos, -libm::cos(phi) * sin);
                sum += radiance(inverse * world).as_dvec3();
            }
            pixels.push((sum / f64::from(samples_per_side * samples_per_side)).as_vec3());
        }
    }
    Image::from_pixels(width, height, pixels).ok()
}

/// Returns an environment map of Caustica that shows `image` under the linear transform `to_world`,
/// and the right-handed rotation of this map about the y axis \[degrees]. `None` if the transform
/// is singular.
///
/// `image` is equirectangular, with +y at the top. It shows −z at the left edge, and +x a quarter
/// of the width further right. The map is resampled if the transform is not a rotation about y.
pub(super) fn place_environment_map(image: Image, to_world: DMat3) -> Option<(Image, f64)> {
    let axes = [to_world.x_axis, to_world.y_axis, to_world.z_axis];
    if axes.iter().any(|axis| axis.try_normalize().is_none()) || to_world.determinant() == 0.0 {
        return None;
    }
    let [x, y, z] = axes;
    let is_upright = (y.normalize() - DVec3::Y).length() < UPRIGHT_TOLERANCE
        && x.y.abs() < UPRIGHT_TOLERANCE * x.length()
        && to_world.determinant() > 0.0
        && (x.length() - z.length()).abs() < UPRIGHT_TOLERANCE * x.length()
        && x.dot(z).abs() < UPRIGHT_TOLERANCE * x.length_squared();
    if !is_upright {
        return Some((resampled_environment(&image, to_world)?, 180.0));
    }
    // Caustica's maps show −z at the center, not at the left edge: half a turn about y.
    let angle = libm::atan2(z.x, z.z).to_degrees() + 180.0;
    Some((image, if angle >= 360.0 { angle - 360.0 } else { angle }))
}

/// Returns an environment map of the same size that shows `image` under the linear transform
/// `to_world`; `None` if the transform is singular.
fn resampled_environment(image: &Image, to_world: DMat3) -> Option<Image> {
    let radiance = |direction: DVec3| radiance_in_direction(image, direction.normalize_or(DVec3::Y));
    equirectangular_image(image.width(), image.height(), SAMPLES_PER_PIXEL_SIDE, to_world, &radiance)
}

/// Returns the radiance of the map `image` in a unit direction of the map's own frame, with
/// bilinear interpolation.
fn radiance_in_direction(image: &Image, direction: DVec3) -> Rgb {
    let (width, height) = (i64::from(image.width()), i64::from(image.height()));
    let x = (libm::atan2(direction.x, -direction.z) / TAU).rem_euclid(1.0) * width as f64 - 0.5;
    let y = libm::acos(direction.y.clamp(-1.0, 1.0)) / PI * height as f64 - 0.5;
    let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let pixel_at =
        |x: i64, y: i64| image.get(x.rem_euclid(width) as u32, y.clamp(0, height - 1) as u32).unwrap_or_default();
    let row = |y: i64| pixel_at(x.floor() as i64, y) * (1.0 - fx) + pixel_at(x.floor() as i64 + 1, y) * fx;
    row(y.floor() as i64) * (1.0 - fy) + row(y.floor() as i64 + 1) * fy
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares a resampled map with the original map in several directions.
    #[test]
    fn a_tilted_map_shows_the_rotated_sky() {
        let (width, height) = (64, 32);
        let color = |d: DVec3| (0.5 + 0.5 * d).as_vec3();
        let mut pixels = Vec::new();
        for row in 0..height {
            for column in 0..width {
                let (phi, theta) = (TAU * (f64::from(column) + 0.5) / 64.0, PI * (f64::from(row) + 0.5) / 32.0);
                let sin = libm::sin(theta);
                pixels.push(color(DVec3::new(libm::sin(phi) * sin, libm::cos(theta), -libm::cos(phi) * sin)));
            }
        }
        let image = Image::from_pixels(width, height, pixels).unwrap();
        let tilt = DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y);
        let tilted = resampled_environment(&image, tilt).unwrap();
        // Leave out the direction Z, which is at the pole of the map, half a pixel from the nearest
        // pixels.
        for direction in [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::new(0.6, -0.64, 0.48)] {
            let (found, expected) = (radiance_in_direction(&tilted, tilt * direction), color(direction));
            // Two interpolations between pixels of 0.1 rad, and averaging, cause a small error.
            assert!((found - expected).abs().max_element() < 0.01, "{direction}: {found} instead of {expected}");
        }
    }
}
