//! Linear RGB.

use glam::Vec3;

/// Linear RGB with the primaries and white of Rec. 709; radiometric quantities are per channel.
pub type Rgb = Vec3;

/// Relative luminance by Rec. 709.
#[inline]
#[must_use]
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Mean of the channels: the quantity that light choice and roulette compare, as no channel is dearer than another.
#[inline]
#[must_use]
pub fn mean(c: Rgb) -> f32 {
    (c.x + c.y + c.z) * (1.0 / 3.0)
}
