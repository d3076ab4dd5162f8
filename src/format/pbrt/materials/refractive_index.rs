//! Refractive indices of pbrt's dielectrics, with the glasses that pbrt knows by name.

use super::parameter_reader::ParameterReader;
use crate::color::glass_by_name;
use crate::format::description::{RefractiveIndexDescription, Span, Spanned};
use crate::format::pbrt::files::ReadResult;
use crate::format::pbrt::parameters::{Parameter, Parameters};
use crate::format::pbrt::spectra::spectral_value;

/// Refractive index of pbrt's materials if the file states none, and of `plastic`.
pub(super) const DEFAULT_REFRACTIVE_INDEX: f64 = 1.5;

/// Glasses of pbrt without a dispersion formula in Caustica: name, index at 587.56 nm, Abbe number.
const GLASSES_BY_ABBE_NUMBER: [(&str, f64, f64); 5] = [
    ("BAF10", 1.6700, 47.11),
    ("F5", 1.6034, 38.03),
    ("FK51A", 1.4866, 84.47),
    ("LASF9", 1.8503, 32.17),
    ("SF5", 1.6727, 32.25),
];

/// Returns the refractive index of a pbrt dielectric: constant, or with the dispersion of a
/// glass that pbrt knows by name.
pub(super) fn refractive_index_description(
    r: &mut ParameterReader<'_>,
    p: &Parameters,
) -> ReadResult<RefractiveIndexDescription> {
    if let Some(glass) = p.find("eta").and_then(glass_name).and_then(glass_description) {
        return Ok(glass);
    }
    refractive_index(r, p, &["eta", "index"]).map(RefractiveIndexDescription::Constant)
}

/// Returns the refractive index from the first of the parameters `names` that exists; 1.5 if
/// none does.
///
/// A named glass gives its index at 587.56 nm. Any other spectrum gives its mean, weighted by
/// the response of the green channel. A texture gives 1.5, and a message tells the user.
pub(super) fn refractive_index(r: &mut ParameterReader<'_>, p: &Parameters, names: &[&str]) -> ReadResult<f64> {
    let place = &p.place;
    let index = match p.find_any(names) {
        None => DEFAULT_REFRACTIVE_INDEX,
        Some(parameter) if parameter.kind == "texture" => {
            r.add_note("textures of the index of refraction are 1.5", place);
            DEFAULT_REFRACTIVE_INDEX
        }
        Some(parameter) if let Some(index) = glass_name(parameter).and_then(index_of_glass) => {
            r.add_note("panes and coats of glass have one index for all wavelengths", place);
            index
        }
        Some(parameter) => spectral_value(parameter, place, r.files)?.mean_rgb().y,
    };
    if !(0.01..=100.0).contains(&index) {
        return Err(place.error("the index of refraction is not between 0.01 and 100", "correct `eta`"));
    }
    Ok(index)
}

/// Returns the Fresnel reflectance at normal incidence of a dielectric with a given index.
pub(super) fn normal_reflectance(index: f64) -> f64 {
    let root = (index - 1.0) / (index + 1.0);
    root * root
}

/// Returns the name of the glass whose spectrum is the value of `parameter`; `None` for any other
/// value.
fn glass_name(parameter: &Parameter) -> Option<&str> {
    let text = parameter.texts.first().filter(|_| parameter.kind == "spectrum")?;
    text.strip_prefix("glass-")
}

/// Returns the index of refraction of a glass at 587.56 nm; `None` for an unknown glass.
fn index_of_glass(name: &str) -> Option<f64> {
    let by_abbe_number = GLASSES_BY_ABBE_NUMBER.iter().find(|glass| glass.0 == name).map(|glass| glass.1);
    glass_by_name(name).map(|glass| f64::from(glass.refractive_index_at_d_line())).or(by_abbe_number)
}

/// Returns the dispersion of a glass; `None` for an unknown glass.
fn glass_description(name: &str) -> Option<RefractiveIndexDescription> {
    if glass_by_name(name).is_some() {
        return Some(RefractiveIndexDescription::NamedGlass(Spanned::new(name.to_owned(), Span::default())));
    }
    let (_, index, abbe) = GLASSES_BY_ABBE_NUMBER.iter().find(|glass| glass.0 == name)?;
    Some(RefractiveIndexDescription::Abbe { index: *index, abbe: *abbe })
}
