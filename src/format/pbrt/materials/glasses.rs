//! Glasses that pbrt knows by name.

use crate::color::glass_by_name;
use crate::format::description::{RefractiveIndexDescription, Span, Spanned};
use crate::format::pbrt::parameters::Parameter;

/// Glasses of pbrt without a dispersion formula in Caustica: name, index at 587.56 nm, Abbe number.
const GLASSES_BY_ABBE_NUMBER: [(&str, f64, f64); 5] = [
    ("BAF10", 1.6700, 47.11),
    ("F5", 1.6034, 38.03),
    ("FK51A", 1.4866, 84.47),
    ("LASF9", 1.8503, 32.17),
    ("SF5", 1.6727, 32.25),
];

/// Returns the name of the glass whose spectrum is the value of `parameter`; `None` for any other
/// value.
pub(super) fn glass_name(parameter: &Parameter) -> Option<&str> {
    let text = parameter.texts.first().filter(|_| parameter.kind == "spectrum")?;
    text.strip_prefix("glass-")
}

/// Returns the index of refraction of a glass at 587.56 nm; `None` for an unknown glass.
pub(super) fn index_of_glass(name: &str) -> Option<f64> {
    let by_abbe_number = GLASSES_BY_ABBE_NUMBER.iter().find(|glass| glass.0 == name).map(|glass| glass.1);
    glass_by_name(name).map(|glass| f64::from(glass.refractive_index_at_d_line())).or(by_abbe_number)
}

/// Returns the dispersion of a glass; `None` for an unknown glass.
pub(super) fn glass_description(name: &str) -> Option<RefractiveIndexDescription> {
    if glass_by_name(name).is_some() {
        return Some(RefractiveIndexDescription::NamedGlass(Spanned::new(name.to_owned(), Span::default())));
    }
    let (_, index, abbe) = GLASSES_BY_ABBE_NUMBER.iter().find(|glass| glass.0 == name)?;
    Some(RefractiveIndexDescription::Abbe { index: *index, abbe: *abbe })
}
