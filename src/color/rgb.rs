//! Linear RGB colors of Rec. 709.

use glam::{DVec3, Vec3};

/// A color or radiometric quantity in linear RGB, with the primaries and white point of Rec. 709.
pub type Rgb = Vec3;

/// Luminance of a linear RGB color by the weights of Rec. 709; 1 for white.
#[inline]
#[must_use]
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Mean of the three channels, as a brightness for light sampling and Russian roulette.
#[inline]
#[must_use]
pub fn channel_mean(c: Rgb) -> f32 {
    (c.x + c.y + c.z) * (1.0 / 3.0)
}

/// Returns the linear RGB color of CIE XYZ tristimulus values; D65 is white.
#[must_use]
pub fn xyz_to_rgb(xyz: DVec3) -> DVec3 {
    // This matrix is the inverse of the RGB-to-XYZ matrix of the Rec. 709 primaries with white D65.
    DVec3::new(
        3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
        -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
        0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z,
    )
}
