//! Reads refractive indices of dielectrics, which Mitsuba scenes state as numbers or names.

use super::context::ImportContext;
use super::files::ReadResult;
use super::tree::{MitsubaObject, MitsubaValue};

/// Refractive indices at 589 nm by Mitsuba's name of the substance, in alphabetical order.
const REFRACTIVE_INDICES_BY_NAME: [(&str, f64); 23] = [
    ("acetone", 1.36),
    ("acrylic glass", 1.49),
    ("air", 1.000_277),
    ("amber", 1.55),
    ("benzene", 1.501),
    ("bk7", 1.5046),
    ("bromine", 1.661),
    ("carbon dioxide", 1.000_45),
    ("carbon tetrachloride", 1.461),
    ("diamond", 2.419),
    ("ethanol", 1.361),
    ("fused quartz", 1.458),
    ("glycerol", 1.4729),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("pet", 1.575),
    ("polypropylene", 1.49),
    ("pyrex", 1.47),
    ("silicone oil", 1.520_45),
    ("sodium chloride", 1.544),
    ("vacuum", 1.0),
    ("water", 1.333),
    ("water ice", 1.31),
];

/// Greatest refractive index of a gas, such as air. If the surroundings of a dielectric have a
/// higher index, they may be another dielectric in which the first one is nested.
const MAX_GAS_INDEX: f64 = 1.001;

/// Returns the refractive index of a dielectric, relative to its surroundings: inner index over
/// outer index.
///
/// The exception is a dielectric that may be nested: its outer index is the inner index of another
/// dielectric in the scene. Its result is the inner index alone, because Caustica expects absolute
/// indices of nested bodies.
pub(super) fn refractive_index(context: &ImportContext<'_>, bsdf: &MitsubaObject) -> ReadResult<f64> {
    let inner = index_parameter(bsdf, "int_ior", if bsdf.plugin.contains("plastic") { 1.49 } else { 1.5046 })?;
    let outer = index_parameter(bsdf, "ext_ior", 1.000_277)?;
    if outer <= MAX_GAS_INDEX {
        return Ok(inner / outer);
    }
    let surrounds = |object: &MitsubaObject| {
        !std::ptr::eq(object, bsdf)
            && object.plugin.contains("dielectric")
            && index_parameter(object, "int_ior", 1.5046).is_ok_and(|index| (index - outer).abs() < 1e-3)
    };
    let is_nested = context.tree.any_object(&surrounds);
    Ok(if is_nested { inner } else { inner / outer })
}

/// True if a relative refractive index is 1 up to rounding, so that the interface bends no light.
pub(super) fn is_index_matched(index: f64) -> bool {
    (index - 1.0).abs() < 1e-9
}

/// Returns the refractive index that the parameter `name` states as a number or a substance.
fn index_parameter(bsdf: &MitsubaObject, name: &str, default: f64) -> ReadResult<f64> {
    let index = match bsdf.value(name) {
        None => default,
        Some(MitsubaValue::Text(text)) => {
            let lowercase_name = text.trim().to_ascii_lowercase();
            let named = REFRACTIVE_INDICES_BY_NAME.iter().find(|(known, _)| *known == lowercase_name);
            let Some((_, index)) = named else {
                let message = format!("no dielectric is called `{text}`");
                return Err(bsdf.place.error(message, "write its refractive index as a `float`"));
            };
            *index
        }
        Some(_) => bsdf.number(name).unwrap_or(f64::NAN),
    };
    if (1e-2..=1e3).contains(&index) {
        return Ok(index);
    }
    Err(bsdf.place.error(format!("`{name}` is no refractive index"), "write a number from 0.01 to 1000"))
}
