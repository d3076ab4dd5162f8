//! Resamples the environment map of an imported scene to the equirectangular map of Caustica.

use crate::color::Rgb;
use crate::image::Image;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

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
