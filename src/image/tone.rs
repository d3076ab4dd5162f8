//! Tone mapping: converts linear radiance to display levels.

use std::fmt;
use std::str::FromStr;

use glam::Vec3;

use super::error::WriteError;

/// Largest absolute exposure \[stops].
pub const MAX_EXPOSURE_STOPS: f32 = 64.0;

/// Tone curve: maps linear radiance, after exposure, to a display signal in \[0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Clamps to \[0, 1], then applies the sRGB transfer function (IEC 61966-2-1).
    #[default]
    Srgb,
    /// Fit of the ACES film curve, then [`ToneCurve::Srgb`] (Narkowicz 2016, "ACES Filmic Tone
    /// Mapping Curve").
    ///
    /// Highlights are compressed: white is reached at radiance 7.2 instead of 1.
    Filmic,
    /// Clamps to \[0, 1] and truncates to integer levels, without a transfer function: trunc(255 ·
    /// c) for 8 bits.
    ///
    /// This curve reproduces the pictures of the ray caster of MIT course 6.837, whose scene format
    /// Caustica reads.
    Legacy,
}

impl ToneCurve {
    /// All tone curves, in the order in which help texts list them.
    pub const ALL: [Self; 3] = [Self::Srgb, Self::Filmic, Self::Legacy];

    /// Name of the curve on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Filmic => "filmic",
            Self::Legacy => "course",
        }
    }
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Error: a text is not the name of a tone curve.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown tone curve `{0}`: choose srgb, filmic or course")]
pub struct UnknownToneCurve(pub String);

impl FromStr for ToneCurve {
    type Err = UnknownToneCurve;

    fn from_str(name: &str) -> Result<Self, UnknownToneCurve> {
        Self::ALL
            .into_iter()
            .find(|curve| curve.name().eq_ignore_ascii_case(name))
            .ok_or_else(|| UnknownToneCurve(name.to_owned()))
    }
}

/// A tone map: an exposure followed by a tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// Tone curve that is applied after the exposure.
    pub curve: ToneCurve,
    /// Exposure \[stops], within ±[`MAX_EXPOSURE_STOPS`].
    ///
    /// Radiance is multiplied by 2 to the power of the exposure.
    pub exposure_stops: f32,
}

/// Numbers of pixels that a picture file does not store exactly, because they were clamped or are
/// not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClippedPixelReport {
    /// Number of pixels with a NaN or infinite channel. A PNG file stores NaN as level 0.
    pub non_finite: usize,
    /// Number of finite pixels with a channel clamped to white in PNG, or to ±65504 in 16-bit
    /// OpenEXR.
    ///
    /// Always 0 for 32-bit OpenEXR.
    pub too_bright: usize,
    /// Number of finite pixels with a negative channel clamped to black; always 0 for OpenEXR.
    pub negative: usize,
}

impl ClippedPixelReport {
    /// Adds the counts of both reports.
    pub(super) fn merged_with(self, other: Self) -> Self {
        Self {
            non_finite: self.non_finite + other.non_finite,
            too_bright: self.too_bright + other.too_bright,
            negative: self.negative + other.negative,
        }
    }
}

/// Converts radiance to integer levels by a tone map.
#[derive(Clone, Copy)]
pub(super) struct Quantizer {
    curve: ToneCurve,
    scale: f32,
    white: u16,
}

impl Quantizer {
    /// Makes a quantizer for levels from 0 to `white`; fails if the exposure of `tone` is out of
    /// range.
    pub(super) fn new(tone: ToneMap, white: u16) -> Result<Self, WriteError> {
        if tone.exposure_stops.abs() <= MAX_EXPOSURE_STOPS {
            Ok(Self { curve: tone.curve, scale: libm::exp2f(tone.exposure_stops), white })
        } else {
            Err(WriteError::Exposure { stops: tone.exposure_stops, limit: MAX_EXPOSURE_STOPS })
        }
    }

    /// Returns the integer levels of a pixel's channels. Counts the pixel in `report` if a channel
    /// had to be clamped or is not finite.
    pub(super) fn quantize_pixel(&self, pixel: Vec3, report: &mut ClippedPixelReport) -> [u16; 3] {
        let exposed = pixel * self.scale;
        // A finite value that becomes infinite by the exposure counts as too bright, not as
        // non-finite.
        if !pixel.is_finite() {
            report.non_finite += 1;
        } else {
            report.too_bright += usize::from(exposed.to_array().iter().any(|&c| self.is_too_bright(c)));
            report.negative += usize::from(pixel.to_array().iter().any(|&c| c < 0.0));
        }
        exposed.to_array().map(|c| self.quantize_channel(c))
    }

    fn is_too_bright(&self, c: f32) -> bool {
        match self.curve {
            ToneCurve::Srgb | ToneCurve::Legacy => c > 1.0,
            ToneCurve::Filmic => filmic_curve(f64::from(c)) > 1.0,
        }
    }

    // Casts from float to integer saturate, and NaN becomes 0.
    fn quantize_channel(&self, c: f32) -> u16 {
        let nearest = |linear: f64| (f64::from(self.white) * srgb_encode(linear.clamp(0.0, 1.0)) + 0.5) as u16;
        match self.curve {
            ToneCurve::Srgb => nearest(f64::from(c)),
            ToneCurve::Filmic => nearest(filmic_curve(f64::from(c))),
            // The ray caster of MIT course 6.837 multiplies in f32. Other arithmetic could give
            // other levels.
            ToneCurve::Legacy => (f32::from(self.white) * c.clamp(0.0, 1.0)) as u16,
        }
    }
}

/// Narkowicz's fit of the ACES film curve at radiance `x`; it exceeds 1 above x = 7.24.
fn filmic_curve(x: f64) -> f64 {
    // The upper limit avoids NaN for an infinite x, and above 8 the curve exceeds 1 anyway. The
    // lower limit avoids a pole of the fit below 0.
    let x = x.clamp(0.0, 8.0);
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Returns the sRGB signal of a linear value in \[0, 1] (IEC 61966-2-1).
pub(super) fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// Returns the linear value of an sRGB signal in \[0, 1] (IEC 61966-2-1).
pub(crate) fn srgb_decode(signal: f64) -> f64 {
    if signal <= 0.040_45 { signal / 12.92 } else { libm::pow((signal + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests;
