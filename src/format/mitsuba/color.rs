//! Parses colors and spectra of a Mitsuba scene file, and converts them to RGB.

use crate::color::Spectrum;
use crate::image::srgb_decode;
use glam::DVec3;

/// A color or spectrum, as the file writes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ColorValue {
    /// Linear RGB of Rec. 709.
    Rgb(DVec3),
    /// Equal value at all wavelengths.
    Uniform(f64),
    /// Spectrum: values by wavelength.
    Sampled(Spectrum),
    /// Blackbody radiation: temperature in kelvin, and a factor for the radiance.
    Blackbody(f64, f64),
    /// Radiation with the spectrum of illuminant D65. The stored factor is its luminance.
    IlluminantD65(f64),
}

/// Quantity that a color describes. It selects the conversion of a spectrum to RGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorMeaning {
    /// Reflectance, transmittance or albedo.
    Reflectance,
    /// Radiance, intensity or irradiance.
    Emission,
    /// Any other quantity, such as a refractive index or an absorption coefficient.
    Unbounded,
}

impl ColorValue {
    /// Parses the value of a `spectrum` element: one number for a uniform spectrum, three numbers
    /// for RGB, or pairs of wavelength \[nm] and value, such as `400:0.3, 500:0.8`.
    ///
    /// `None` if the text has another form, or if the wavelengths decrease.
    pub fn parse_spectrum(text: &str) -> Option<Self> {
        if !text.contains(':') {
            return Some(match *parse_numbers(text)? {
                [value] => Self::Uniform(value),
                [r, g, b] => Self::Rgb(DVec3::new(r, g, b)),
                _ => return None,
            });
        }
        let pair = |word: &str| {
            let (wavelength, value) = word.split_once(':')?;
            Some([wavelength.trim().parse().ok()?, value.trim().parse().ok()?])
        };
        let words = text.split([',', ' ', '\t', '\n', '\r', ';']).filter(|word| !word.is_empty());
        Spectrum::from_samples(words.map(pair).collect::<Option<Vec<[f64; 2]>>>()?).map(Self::Sampled)
    }

    /// Parses the text of a spectrum file, which has a wavelength \[nm] and a value on each line.
    /// Comments begin with `#`.
    ///
    /// `None` if the text has another form, or if the wavelengths decrease.
    pub fn parse_spectrum_file(text: &str) -> Option<Self> {
        let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
        let pair = |line: &str| match *parse_numbers(line)? {
            [wavelength, value] => Some([wavelength, value]),
            _ => None,
        };
        let samples = lines.filter(|line| !line.is_empty()).map(pair).collect::<Option<Vec<[f64; 2]>>>()?;
        Spectrum::from_samples(samples).map(Self::Sampled)
    }

    /// Parses a color: three numbers, one number for gray, or `#rrggbb`.
    ///
    /// `#rrggbb` is always sRGB-encoded. Numbers are sRGB-encoded if `is_encoded` is true, else
    /// linear. `None` if the text has another form.
    pub fn parse_rgb(text: &str, is_encoded: bool) -> Option<Self> {
        let text = text.trim();
        if let Some(digits) = text.strip_prefix('#') {
            if digits.len() != 6 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
                return None;
            }
            let level = |k: usize| u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).map(f64::from).ok();
            let levels = DVec3::new(level(0)?, level(1)?, level(2)?);
            return Some(Self::Rgb((levels / 255.0).map(srgb_decode)));
        }
        let rgb = match *parse_numbers(text)? {
            [gray] => DVec3::splat(gray),
            [r, g, b] => DVec3::new(r, g, b),
            _ => return None,
        };
        Some(Self::Rgb(if is_encoded { rgb.map(|x| srgb_decode(x.max(0.0))) } else { rgb }))
    }

    /// Returns the value of a uniform spectrum, or of an RGB color with equal channels; else
    /// `None`.
    pub fn uniform_value(&self) -> Option<f64> {
        match self {
            Self::Uniform(value) => Some(*value),
            Self::Rgb(rgb) if rgb.x == rgb.y && rgb.y == rgb.z => Some(rgb.x),
            Self::Rgb(_) | Self::Sampled(_) | Self::Blackbody(..) | Self::IlluminantD65(_) => None,
        }
    }

    /// Returns the color as linear RGB.
    ///
    /// `meaning` is the quantity that the color describes. It selects how a sampled spectrum
    /// becomes RGB.
    pub fn to_rgb(&self, meaning: ColorMeaning) -> DVec3 {
        let spectrum = match self {
            Self::Rgb(rgb) => return *rgb,
            Self::Uniform(value) | Self::IlluminantD65(value) => return DVec3::splat(*value),
            Self::Sampled(spectrum) => spectrum.clone(),
            Self::Blackbody(kelvin, scale) => {
                return Spectrum::blackbody(*kelvin).radiance_rgb() * *scale;
            }
        };
        match meaning {
            ColorMeaning::Reflectance => spectrum.reflectance_rgb(),
            ColorMeaning::Emission => spectrum.radiance_rgb(),
            ColorMeaning::Unbounded => spectrum.channel_means(),
        }
    }

    /// Returns a uniform or sampled color as a spectrum; `None` for RGB, blackbodies and D65.
    pub fn to_spectrum(&self) -> Option<Spectrum> {
        match self {
            Self::Sampled(spectrum) => Some(spectrum.clone()),
            Self::Uniform(value) => Some(Spectrum::constant(*value)),
            Self::Rgb(_) | Self::Blackbody(..) | Self::IlluminantD65(_) => None,
        }
    }
}

/// Parses finite numbers, separated by commas or white space; `None` if a word is not a number.
pub(super) fn parse_numbers(text: &str) -> Option<Vec<f64>> {
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    words.map(|word| word.parse().ok().filter(|number: &f64| number.is_finite())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_parsed_in_each_notation() {
        assert_eq!(ColorValue::parse_rgb("0.5", false), Some(ColorValue::Rgb(DVec3::splat(0.5))));
        assert_eq!(ColorValue::parse_rgb("1, .5 0", false), Some(ColorValue::Rgb(DVec3::new(1.0, 0.5, 0.0))));
        let Some(ColorValue::Rgb(hex)) = ColorValue::parse_rgb("#ff8000", false) else { panic!() };
        assert!((hex - DVec3::new(1.0, 0.215_860_5, 0.0)).abs().max_element() < 1e-6, "{hex}");
        assert!(ColorValue::parse_rgb("#ff80", false).is_none() && ColorValue::parse_rgb("1 2", false).is_none());
        let sampled = ColorValue::parse_spectrum("400:0.5, 700:0.5").unwrap();
        assert!((sampled.to_rgb(ColorMeaning::Reflectance) - 0.5).abs().max_element() < 1e-9);
        assert!(ColorValue::parse_spectrum("400:x").is_none() && ColorValue::parse_spectrum("700:1, 400:1").is_none());
    }
}
