//! Color maps that show scalar values as colors.

use super::tone::srgb_decode;
use glam::{DVec3, Vec3};

/// Nine evenly spaced colors of the color map magma (Smith and van der Walt 2015, CC0), in sRGB
/// bytes.
///
/// The perceived lightness rises uniformly, from black through purple and orange to pale yellow.
const MAGMA: [[u8; 3]; 9] = [
    [0x00, 0x00, 0x04],
    [0x1d, 0x11, 0x47],
    [0x51, 0x12, 0x7c],
    [0x82, 0x26, 0x81],
    [0xb6, 0x36, 0x79],
    [0xe6, 0x51, 0x64],
    [0xfb, 0x88, 0x61],
    [0xfe, 0xc2, 0x87],
    [0xfc, 0xfd, 0xbf],
];

/// Five evenly spaced colors of Brewer's map RdBu (colorbrewer2.org) from blue to red, in sRGB
/// bytes.
const BLUE_RED: [[u8; 3]; 5] =
    [[0x05, 0x71, 0xb0], [0x92, 0xc5, 0xde], [0xf7, 0xf7, 0xf7], [0xf4, 0xa5, 0x82], [0xca, 0x00, 0x20]];

/// Returns the color of `t` in the color map magma, as linear RGB: black at 0, pale yellow at 1.
///
/// `t` is clamped to \[0, 1].
#[must_use]
pub fn sequential_color(t: f64) -> Vec3 {
    interpolate_color_map(&MAGMA, t)
}

/// Returns the color of `t` in a blue-white-red color map, as linear RGB: blue at −1, near-white at
/// 0, red at 1.
///
/// `t` is clamped to \[−1, 1].
#[must_use]
pub fn diverging_color(t: f64) -> Vec3 {
    interpolate_color_map(&BLUE_RED, 0.5 + 0.5 * t)
}

/// Interpolates between evenly spaced sRGB colors `steps` at `t`, clamped to \[0, 1]; returns
/// linear RGB.
///
/// Interpolation is in sRGB signals, which are perceptually more uniform than linear RGB.
fn interpolate_color_map(steps: &[[u8; 3]], t: f64) -> Vec3 {
    let last = steps.len() - 1;
    let position = t.clamp(0.0, 1.0) * last as f64;
    let step = (position as usize).min(last - 1);
    let signal = |i: usize| DVec3::from(steps[i].map(f64::from)) / 255.0;
    let mixed = signal(step).lerp(signal(step + 1), position - step as f64);
    DVec3::from(mixed.to_array().map(srgb_decode)).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, OutputFormat, WriteOptions, encode, read_rgb8};

    /// Returns the bytes that an 8-bit PNG stores for linear `colors`.
    fn stored_png_bytes(colors: Vec<Vec3>) -> Vec<[u8; 3]> {
        let image = Image::from_pixels(colors.len() as u32, 1, colors).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, encode(OutputFormat::Png, &image, &WriteOptions::default()).unwrap().0).unwrap();
        read_rgb8(&path).unwrap().pixels().to_vec()
    }

    #[test]
    fn color_maps_clamp_and_match_published_bytes() {
        assert_eq!(stored_png_bytes((0..9).map(|i| sequential_color(f64::from(i) / 8.0)).collect()), MAGMA);
        assert_eq!(stored_png_bytes((0..5).map(|i| diverging_color(f64::from(i) / 2.0 - 1.0)).collect()), BLUE_RED);
        assert_eq!((sequential_color(-1.0), sequential_color(2.0)), (sequential_color(0.0), sequential_color(1.0)));
        assert_eq!((diverging_color(-9.0), diverging_color(9.0)), (diverging_color(-1.0), diverging_color(1.0)));
    }

    #[test]
    fn larger_values_have_lighter_colors() {
        let luminance = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        let lights: Vec<f32> = (0..=64).map(|i| luminance(sequential_color(f64::from(i) / 64.0))).collect();
        assert!(lights.is_sorted_by(|a, b| a < b), "{lights:?}");
    }
}
