//! From linear radiance to the levels of a display.

use std::fmt;
use std::str::FromStr;

use glam::Vec3;

use super::error::WriteError;

/// The largest exposure in stops, either way.
pub const MAX_EXPOSURE_STOPS: f32 = 64.0;

/// How exposed linear radiance becomes a level in [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Clamped, then the transfer function of sRGB (IEC 61966-2-1), rounded to the nearest level.
    #[default]
    Srgb,
    /// Narkowicz's fit of the ACES film curve ("ACES Filmic Tone Mapping Curve", 2016), then as [`Curve::Srgb`]:
    /// highlights roll off and reach white at 7.2 times the radiance that [`Curve::Srgb`] clips.
    Filmic,
    /// The course's: trunc(255 · clamp(c)), no transfer function. Its pictures state no colour space, as the course's own.
    Course,
}

impl Curve {
    /// Every curve, in the order that messages list them.
    pub const ALL: [Self; 3] = [Self::Srgb, Self::Filmic, Self::Course];

    /// The name that [`FromStr`] accepts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Filmic => "filmic",
            Self::Course => "course",
        }
    }
}

impl fmt::Display for Curve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A tone curve's name that is not known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown tone curve `{0}`: choose srgb, filmic or course")]
pub struct UnknownCurve(pub String);

impl FromStr for Curve {
    type Err = UnknownCurve;

    fn from_str(name: &str) -> Result<Self, UnknownCurve> {
        Self::ALL
            .into_iter()
            .find(|curve| curve.name().eq_ignore_ascii_case(name))
            .ok_or_else(|| UnknownCurve(name.to_owned()))
    }
}

/// Exposure, then a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// The curve.
    pub curve: Curve,
    /// Radiance is multiplied by 2 to this power before the curve; within ±[`MAX_EXPOSURE_STOPS`].
    pub exposure_stops: f32,
}

/// What a format with limited levels could not hold, in pixels. Each pixel counts at most once in each field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteReport {
    /// Pixels with a channel that is NaN or infinite: a defect of the renderer or the scene. In PNG a NaN channel becomes 0.
    pub non_finite: usize,
    /// Finite pixels with a channel beyond the curve's white, clamped to it; in OpenEXR of 16 bits, beyond 65504 either way. Always 0 for
    /// OpenEXR of 32 bits.
    pub too_bright: usize,
    /// Finite pixels with a channel below zero, clamped to black. Always 0 for OpenEXR.
    pub negative: usize,
}

impl WriteReport {
    pub(super) fn merge(self, other: Self) -> Self {
        Self {
            non_finite: self.non_finite + other.non_finite,
            too_bright: self.too_bright + other.too_bright,
            negative: self.negative + other.negative,
        }
    }
}

/// A tone map made ready: the exposure checked and turned into a factor.
#[derive(Clone, Copy)]
pub(super) struct Quantizer {
    curve: Curve,
    scale: f32,
    white: u16,
}

impl Quantizer {
    /// Levels run from 0 to `white`.
    pub(super) fn new(tone: ToneMap, white: u16) -> Result<Self, WriteError> {
        if tone.exposure_stops.abs() <= MAX_EXPOSURE_STOPS {
            Ok(Self { curve: tone.curve, scale: libm::exp2f(tone.exposure_stops), white })
        } else {
            Err(WriteError::Exposure { stops: tone.exposure_stops })
        }
    }

    /// The three levels of a pixel; what they could not hold is counted.
    pub(super) fn levels(&self, pixel: Vec3, report: &mut WriteReport) -> [u16; 3] {
        let exposed = pixel * self.scale;
        // Judged before exposure, which may overflow a finite value: that is brightness, not a defect.
        if !pixel.is_finite() {
            report.non_finite += 1;
        } else {
            report.too_bright += usize::from(exposed.to_array().iter().any(|&c| self.is_too_bright(c)));
            report.negative += usize::from(pixel.to_array().iter().any(|&c| c < 0.0));
        }
        exposed.to_array().map(|c| self.level(c))
    }

    fn is_too_bright(&self, c: f32) -> bool {
        match self.curve {
            Curve::Srgb | Curve::Course => c > 1.0,
            Curve::Filmic => film(f64::from(c)) > 1.0,
        }
    }

    // The casts from float saturate and send NaN to 0.
    fn level(&self, c: f32) -> u16 {
        let nearest = |linear: f64| (f64::from(self.white) * srgb_encode(linear.clamp(0.0, 1.0)) + 0.5) as u16;
        match self.curve {
            Curve::Srgb => nearest(f64::from(c)),
            Curve::Filmic => nearest(film(f64::from(c))),
            // In f32, as the course's own ray caster multiplies.
            Curve::Course => (f32::from(self.white) * c.clamp(0.0, 1.0)) as u16,
        }
    }
}

/// Narkowicz's rational fit, x(2.51x + .03) / (x(2.43x + .59) + .14); it exceeds 1 beyond x = 7.24.
fn film(x: f64) -> f64 {
    // Beyond 8 the curve is past white anyway, and an infinite x would give NaN; below 0 the fit has a pole.
    let x = x.clamp(0.0, 8.0);
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Linear light in [0, 1] to the sRGB signal (IEC 61966-2-1).
pub(super) fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// The sRGB signal in [0, 1] to linear light (IEC 61966-2-1).
pub(super) fn srgb_decode(signal: f64) -> f64 {
    if signal <= 0.040_45 { signal / 12.92 } else { libm::pow((signal + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(curve: Curve, stops: f32, c: f32) -> u16 {
        let quantizer = Quantizer::new(ToneMap { curve, exposure_stops: stops }, 255).unwrap();
        quantizer.levels(Vec3::splat(c), &mut WriteReport::default())[1]
    }

    #[test]
    fn srgb_levels_are_the_nearest() {
        // 1.055 · .5^(1/2.4) − .055 = .735357, times 255 is 187.516: truncation would give 187.
        assert_eq!(level(Curve::Srgb, 0.0, 0.5), 188);
        // The straight part: .002 · 12.92 · 255 = 6.589.
        assert_eq!(level(Curve::Srgb, 0.0, 0.002), 7);
        assert_eq!([-1.0, 0.0, 1.0, 9.0].map(|c| level(Curve::Srgb, 0.0, c)), [0, 0, 255, 255]);
    }

    #[test]
    fn every_srgb_byte_survives_decoding_and_encoding() {
        for byte in 0..=255_u16 {
            assert_eq!(level(Curve::Srgb, 0.0, srgb_decode(f64::from(byte) / 255.0) as f32), byte);
        }
    }

    #[test]
    fn exposure_is_in_stops() {
        assert_eq!(level(Curve::Srgb, 2.0, 0.125), level(Curve::Srgb, 0.0, 0.5));
        assert_eq!(level(Curve::Course, -1.0, 1.0), 127);
        for stops in [f32::NAN, f32::INFINITY, -64.5] {
            assert!(Quantizer::new(ToneMap { curve: Curve::Srgb, exposure_stops: stops }, 255).is_err());
        }
    }

    #[test]
    fn course_truncates_without_gamma() {
        // 255 · .5 = 127.5 and 255 · .999 = 254.7 both lose their fraction.
        assert_eq!([0.5, 0.999, 1.0, -3.0, 7.0].map(|c| level(Curve::Course, 0.0, c)), [127, 254, 255, 0, 255]);
    }

    #[test]
    fn filmic_follows_the_published_fit() {
        // x = 1: 2.54 / 3.16 = .803797.
        assert!((film(1.0) - 2.54 / 3.16).abs() < 1e-15);
        // White is the larger root of .08x² − .56x − .14.
        let white = (0.56 + f64::sqrt(0.56 * 0.56 + 4.0 * 0.08 * 0.14)) / 0.16;
        assert!((film(white) - 1.0).abs() < 1e-12);
        // sRGB of .803797 is .908046, times 255 is 231.55.
        assert_eq!(level(Curve::Filmic, 0.0, 1.0), 232);
        assert_eq!([f32::INFINITY, f32::MAX, -2.0, 0.0].map(|c| level(Curve::Filmic, 9.0, c)), [255, 255, 0, 0]);
    }

    #[test]
    fn what_levels_cannot_hold_is_counted_once_a_pixel() {
        let quantizer = Quantizer::new(ToneMap { curve: Curve::Srgb, exposure_stops: 60.0 }, 255).unwrap();
        let mut report = WriteReport::default();
        quantizer.levels(Vec3::new(f32::NAN, f32::INFINITY, -1.0), &mut report);
        assert_eq!(report, WriteReport { non_finite: 1, too_bright: 0, negative: 0 });
        // 10³⁰ · 2⁶⁰ overflows f32, yet the pixel is finite: bright, not defective.
        quantizer.levels(Vec3::new(1e30, 1e30, -1.0), &mut report);
        assert_eq!(report, WriteReport { non_finite: 1, too_bright: 1, negative: 1 });
    }

    #[test]
    fn white_itself_is_not_too_bright() {
        for (curve, white) in [(Curve::Srgb, 1.0), (Curve::Course, 1.0), (Curve::Filmic, 7.24)] {
            let quantizer = Quantizer::new(ToneMap { curve, exposure_stops: 0.0 }, 255).unwrap();
            let count = |c: f32| {
                let mut report = WriteReport::default();
                quantizer.levels(Vec3::new(0.0, c, 0.0), &mut report);
                report.too_bright
            };
            assert_eq!((count(white), count(white * 1.001)), (0, 1), "{curve}");
        }
    }

    #[test]
    fn curves_are_found_by_name() {
        for curve in Curve::ALL {
            assert_eq!(curve.name().parse::<Curve>(), Ok(curve));
        }
        let message = "gamma".parse::<Curve>().unwrap_err().to_string();
        assert!(message.contains("`gamma`") && Curve::ALL.iter().all(|c| message.contains(c.name())), "{message}");
    }
}
