//! Linear RGB colors.

use glam::Vec3;

/// A color or radiometric quantity in linear RGB, with the primaries and white point of Rec. 709.
pub type Rgb = Vec3;

/// Luminance of a linear RGB color by the weights of Rec. 709; 1 for white.
#[inline]
#[must_use]
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Mean of the three channels, the scalar by which light sampling and Russian roulette compare
/// colors.
#[inline]
#[must_use]
pub fn channel_mean(c: Rgb) -> f32 {
    (c.x + c.y + c.z) * (1.0 / 3.0)
}
