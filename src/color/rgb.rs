//! Linear RGB.

use glam::Vec3;

/// Linear RGB with the primaries and white point of Rec. 709. Radiometric quantities are per
/// channel.
pub type Rgb = Vec3;

/// Relative luminance of Rec. 709.
#[inline]
#[must_use]
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Mean of the channels. Light sampling and Russian roulette compare it, since all channels count
/// equally.
#[inline]
#[must_use]
pub fn channel_mean(c: Rgb) -> f32 {
    (c.x + c.y + c.z) * (1.0 / 3.0)
}
