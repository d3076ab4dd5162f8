//! Metals of imported scenes: names by chemical symbol, and reflectance at normal incidence.

use super::description::{MetalDescription, Span, Spanned, TexturedValue};
use crate::bsdf::metal_refractive_index;
use glam::DVec3;

/// Names of metals in Mitsuba and Tungsten, each with the metal's name in Caustica's scene
/// language.
const METAL_NAMES: [(&str, &str); 14] = [
    ("Ag", "silver"),
    ("Al", "aluminium"),
    ("Au", "gold"),
    ("Cr", "chromium"),
    ("Cu", "copper"),
    ("Cu_palik", "copper"),
    ("CuZn", "brass"),
    ("Fe", "iron"),
    ("Ir", "iridium"),
    ("Mo", "molybdenum"),
    ("Ni", "nickel"),
    ("Ti", "titanium"),
    ("V", "vanadium"),
    ("W", "tungsten"),
];

/// Returns the metal with a chemical symbol, such as `Cu`; `None` if it is not known.
pub(super) fn metal_by_symbol(symbol: &str) -> Option<MetalDescription> {
    let (_, name) = METAL_NAMES.iter().find(|(known, _)| *known == symbol)?;
    Some(named_metal(name))
}

/// Returns the metal with a name of the scene language, such as `copper`.
pub(super) fn named_metal(name: &str) -> MetalDescription {
    MetalDescription::Named(Spanned::new(name.to_owned(), Span::default()))
}

/// Returns the reflectance of a metal at normal incidence. Returns 1 if the reflectance is a
/// texture, or if the name of the metal is unknown.
pub(super) fn normal_reflectance(metal: &MetalDescription) -> DVec3 {
    let (eta, k) = match metal {
        MetalDescription::Reflectance(TexturedValue::Constant(reflectance)) => return *reflectance,
        MetalDescription::Reflectance(TexturedValue::Texture(_)) => return DVec3::ONE,
        MetalDescription::Index { eta, k } => (*eta, *k),
        MetalDescription::Named(name) => match metal_refractive_index(name) {
            Some((eta, k)) => (eta.as_dvec3(), k.as_dvec3()),
            None => return DVec3::ONE,
        },
    };
    ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
}
