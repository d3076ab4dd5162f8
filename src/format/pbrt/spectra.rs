//! Converts colors and spectra of pbrt: RGB, XYZ, blackbodies, sampled and named spectra.

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::parameters::{Parameter, parse_number};
use crate::bsdf::metal_refractive_index;
use crate::color::{Spectrum, illuminant_rgb, xyz_to_rgb};
use glam::DVec3;

/// Quantity that a color parameter describes. It selects the conversion of a spectrum to RGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorMeaning {
    /// Reflectance or transmittance, inside \[0, 1].
    Reflectance,
    /// Radiance or intensity of a light. pbrt-v4 normalizes spectra of lights to luminance 1.
    Emission {
        /// True for a scene of pbrt-v3, which does not normalize spectra.
        is_v3: bool,
    },
    /// Any other quantity, without an upper limit, such as an absorption coefficient.
    Unbounded,
}

/// A quantity that depends on wavelength: a spectrum, or values for red, green and blue.
pub(super) enum SpectralValue {
    /// Spectrum: values by wavelength.
    Spectrum(Spectrum),
    /// Values for linear red, green and blue.
    Rgb(DVec3),
}

impl SpectralValue {
    /// Returns the values for red, green and blue.
    ///
    /// For a spectrum, each value is a mean over wavelength, weighted by the channel's response.
    pub fn mean_rgb(&self) -> DVec3 {
        match self {
            Self::Spectrum(spectrum) => spectrum.channel_means(),
            Self::Rgb(rgb) => *rgb,
        }
    }
}

/// Converts a color parameter to linear RGB. `meaning` is the quantity that the parameter
/// describes.
///
/// Reflectances are clamped to \[0, 1]. Fails if another quantity is negative.
pub(super) fn linear_rgb(
    parameter: &Parameter,
    meaning: ColorMeaning,
    place: &PbrtSourceLocation,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<DVec3> {
    let value = match (&*parameter.kind, &*parameter.numbers) {
        ("blackbody", [kelvin, rest @ ..]) => {
            if !(*kelvin >= 100.0 && *kelvin <= 1e6) {
                return Err(place.error("the temperature is not between 100 and 1,000,000 K", "correct `blackbody`"));
            }
            let spectrum = Spectrum::normalized_blackbody(*kelvin);
            match (meaning, rest.first()) {
                (ColorMeaning::Emission { .. }, Some(scale)) => spectrum.radiance_rgb() * *scale,
                (ColorMeaning::Emission { .. }, None) => spectrum.normalized_radiance_rgb(),
                (ColorMeaning::Reflectance | ColorMeaning::Unbounded, _) => spectrum.reflectance_rgb(),
            }
        }
        _ => match spectral_value(parameter, place, files)? {
            SpectralValue::Rgb(rgb) => rgb,
            SpectralValue::Spectrum(spectrum) => match meaning {
                ColorMeaning::Reflectance => spectrum.reflectance_rgb(),
                ColorMeaning::Emission { is_v3: true } => spectrum.radiance_rgb(),
                ColorMeaning::Emission { is_v3: false } => spectrum.normalized_radiance_rgb(),
                ColorMeaning::Unbounded => spectrum.channel_means(),
            },
        },
    };
    let value = if meaning == ColorMeaning::Reflectance { value.clamp(DVec3::ZERO, DVec3::ONE) } else { value };
    if value.min_element() < 0.0 {
        return Err(place.error(format!("`{}` is negative", parameter.name), "use values of at least 0"));
    }
    Ok(value)
}

/// Returns the value of a color parameter: a spectrum if the file gives values by wavelength, else
/// linear RGB.
pub(super) fn spectral_value(
    parameter: &Parameter,
    place: &PbrtSourceLocation,
    files: &PbrtSceneFiles<'_>,
) -> ReadResult<SpectralValue> {
    let Parameter { kind, name, numbers, texts } = parameter;
    let channels = |rgb| Ok(SpectralValue::Rgb(rgb));
    match (&**kind, &**numbers, texts.first()) {
        ("rgb" | "color", [r, g, b], _) => channels(DVec3::new(*r, *g, *b)),
        ("xyz", [x, y, z], _) => channels(xyz_to_rgb(DVec3::new(*x, *y, *z)).max(DVec3::ZERO)),
        ("float", [value], _) => channels(DVec3::splat(*value)),
        ("spectrum", [value], None) => channels(DVec3::splat(*value)),
        ("spectrum", _, Some(text)) => named_spectrum(text, place, files),
        ("spectrum", pairs @ [_, _, ..], None) => sampled_spectrum(pairs, place).map(SpectralValue::Spectrum),
        _ => Err(place
            .error(format!("`{kind} {name}` has {} numbers", numbers.len()), "write colors as `\"rgb L\" [ 1 1 1 ]`")),
    }
}

/// Returns the spectrum through `pairs`, a list that alternates between wavelength \[nm] and value.
fn sampled_spectrum(pairs: &[f64], place: &PbrtSourceLocation) -> ReadResult<Spectrum> {
    let samples = pairs.as_chunks::<2>().0.to_vec();
    let spectrum = if pairs.len().is_multiple_of(2) { Spectrum::from_samples(samples) } else { None };
    spectrum.ok_or_else(|| {
        place.error("the samples of a spectrum are no pairs of increasing wavelength and value", "sort the pairs")
    })
}

/// Returns pbrt's built-in spectrum `name`, or else the spectrum in the file `name`.
///
/// pbrt's metals and standard illuminants give RGB values. Fails for its other built-in spectra.
fn named_spectrum(name: &str, place: &PbrtSourceLocation, files: &PbrtSceneFiles<'_>) -> ReadResult<SpectralValue> {
    if let Some(metal) = name.strip_prefix("metal-") {
        let (metal, is_eta) = match (metal.strip_suffix("-eta"), metal.strip_suffix("-k")) {
            (Some(metal), _) => (metal, true),
            (None, Some(metal)) => (metal, false),
            (None, None) => (metal, true),
        };
        return metal_eta_or_k(metal, is_eta)
            .map(SpectralValue::Rgb)
            .ok_or_else(|| place.error(format!("no metal is called `{metal}`"), "give `eta` and `k` as spectra"));
    }
    if let Some(rgb) = name.strip_prefix("stdillum-").and_then(illuminant_rgb) {
        return Ok(SpectralValue::Rgb(rgb));
    }
    if name.starts_with("stdillum-") || name.starts_with("illum-") || name.starts_with("glass-") {
        return Err(place.error(format!("the spectrum `{name}` has no color here"), "give its samples, or an `rgb`"));
    }
    let path = files.resolve_path(place, name)?;
    let bytes = files.read_file(&path)?;
    let text = String::from_utf8_lossy(&bytes);
    let mut numbers = Vec::new();
    let file: std::rc::Rc<str> = path.display().to_string().into();
    for (line, content) in text.lines().enumerate() {
        let place = PbrtSourceLocation { file: file.clone(), line: line as u32 + 1 };
        for word in content.split('#').next().unwrap_or_default().split_whitespace() {
            numbers.push(parse_number(word, &place)?);
        }
    }
    sampled_spectrum(&numbers, &PbrtSourceLocation { file, line: 1 }).map(SpectralValue::Spectrum)
}

/// Returns η (if `is_eta` is true) or k of a metal's complex refractive index η + ik, for red,
/// green and blue. `None` if the metal is unknown.
///
/// MgO and TiO2 are known too, because pbrt lists these oxides among its metals.
fn metal_eta_or_k(name: &str, is_eta: bool) -> Option<DVec3> {
    let oxide = match name {
        "MgO" => Some(1.737),
        "TiO2" => Some(2.61),
        _ => None,
    };
    if let Some(index) = oxide {
        return Some(DVec3::splat(if is_eta { index } else { 0.0 }));
    }
    metal_refractive_index(name).map(|(eta, k)| if is_eta { eta } else { k }.as_dvec3())
}
