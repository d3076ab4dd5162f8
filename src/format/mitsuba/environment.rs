//! Converts environment maps of Mitsuba.
//!
//! Mitsuba's maps are equirectangular, with +y at the top. They show −z at the left edge, and +x a
//! quarter of the width further right.

use super::context::ImportContext;
use super::files::ReadResult;
use super::textures::MitsubaTextures;
use super::tree::MitsubaObject;
use crate::color::Rgb;
use crate::format::description::{EnvironmentRadiance, Span, Spanned};
use crate::format::imported_environment::equirectangular_image;
use crate::image::Image;
use glam::{DMat3, DMat4, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Greatest deviation of an environment map's transform from a rotation about y, relative to the
/// lengths of the transform's axes.
///
/// A map with a smaller deviation is only rotated. Any other map is resampled.
const UPRIGHT_TOLERANCE: f64 = 1e-6;

/// Number of samples along each side of a pixel of the resampled map, for antialiasing. Each sample
/// is a value of the original map.
const SAMPLES_PER_PIXEL_SIDE: u32 = 4;

/// Returns the radiance of an `envmap` emitter, with its map embedded as a picture.
///
/// Resamples the map if its transform is not a rotation about y. Negative channels become 0, and
/// pixels that are not finite become black.
pub(super) fn read_environment(
    context: &ImportContext<'_>,
    textures: &mut MitsubaTextures,
    emitter: &MitsubaObject,
    to_world: DMat4,
) -> ReadResult<EnvironmentRadiance> {
    let (file, image) = textures.decode_picture_file(context, emitter, false)?;
    let scale = emitter.number("scale").unwrap_or(1.0);
    if !(0.0..=1e30).contains(&scale) {
        return Err(emitter.place.error("the scale of the environment map is negative", "correct `scale`"));
    }
    context.files.check_memory(&file, 24 * image.pixels().len() as u64)?;
    let mut image = (*image).clone();
    for pixel in image.pixels_mut() {
        *pixel = if pixel.is_finite() { pixel.max(Vec3::ZERO) } else { Vec3::ZERO };
    }
    let linear = DMat3::from_mat4(to_world);
    let singular = || emitter.place.error("the transform of the environment map is singular", "scale it less");
    let axes = [linear.x_axis, linear.y_axis, linear.z_axis];
    if axes.iter().any(|axis| axis.try_normalize().is_none()) || linear.determinant() == 0.0 {
        return Err(singular());
    }
    let y = linear.y_axis.normalize();
    let is_upright = (y - DVec3::Y).length() < UPRIGHT_TOLERANCE
        && linear.x_axis.y.abs() < UPRIGHT_TOLERANCE * linear.x_axis.length()
        && linear.determinant() > 0.0
        && (linear.x_axis.length() - linear.z_axis.length()).abs() < UPRIGHT_TOLERANCE * linear.x_axis.length()
        && linear.x_axis.dot(linear.z_axis).abs() < UPRIGHT_TOLERANCE * linear.x_axis.length_squared();
    let rotate = if is_upright {
        // Caustica's maps show −z at the center, not at the left edge: half a turn about y.
        let angle = libm::atan2(linear.z_axis.x, linear.z_axis.z).to_degrees() + 180.0;
        if angle >= 360.0 { angle - 360.0 } else { angle }
    } else {
        image = resampled_environment(&image, linear).ok_or_else(singular)?;
        180.0
    };
    let path = Spanned::new(textures.embed_picture(image), Span::default());
    Ok(EnvironmentRadiance::Picture { path, scale, rotate })
}

/// Returns an environment map of the same size that shows `image` under the linear transform
/// `to_world`; `None` if the transform is singular.
fn resampled_environment(image: &Image, to_world: DMat3) -> Option<Image> {
    let radiance = |direction: DVec3| radiance_in_direction(image, direction.normalize_or(DVec3::Y));
    equirectangular_image(image.width(), image.height(), SAMPLES_PER_PIXEL_SIDE, to_world, &radiance)
}

/// Returns the radiance of Mitsuba's map `image` in a unit direction of the map's own frame, with
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
