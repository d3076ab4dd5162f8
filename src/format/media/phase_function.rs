//! Phase function of a medium in the scene language: isotropic, Rayleigh or Henyey–Greenstein.

use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldRange, FieldSchema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::span::Spanned;
use crate::medium::PhaseFunction;
use std::fmt;

/// Phase function of a medium, which gives the distribution of directions after scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseFunctionDescription {
    /// Equal scattering in all directions.
    Isotropic,
    /// Rayleigh scattering: particles much smaller than the wavelength.
    Rayleigh,
    /// Henyey–Greenstein phase function. The number is its mean cosine g, inside (−1, 1); above 0,
    /// forward scattering prevails.
    HenyeyGreenstein(f64),
}

/// Field for the name of the phase function.
pub(super) const PHASE: FieldSchema =
    field_schema("phase", FieldKind::Word(&["isotropic", "rayleigh", "henyey-greenstein"]), "phase function")
        .make_optional("`isotropic`; with `anisotropy`, `henyey-greenstein`");

/// Field for the mean cosine of the Henyey–Greenstein phase function.
pub(super) const ANISOTROPY: FieldSchema =
    field_schema("anisotropy", FieldKind::Number, "mean cosine g; above 0 scatters forward")
        .with_range(FieldRange::DescribedOnly("−1 < g < 1"));

/// Parses the phase function of a medium block.
pub(super) fn parse_phase_function(f: &BlockFields<'_>) -> Result<PhaseFunctionDescription, SceneError> {
    let word: Option<Spanned<String>> = f.optional_value("phase");
    match (word.as_ref().map(|word| word.as_str()), f.get("anisotropy")) {
        (None | Some("isotropic"), None) => Ok(PhaseFunctionDescription::Isotropic),
        (Some("rayleigh"), None) => Ok(PhaseFunctionDescription::Rayleigh),
        (None | Some("henyey-greenstein"), Some(field)) => {
            let g: f64 = field.value();
            field.ensure_valid(g.abs() <= 1.0 - 1e-7, "must lie inside -1 … 1, by 1e-7 at least")?;
            Ok(PhaseFunctionDescription::HenyeyGreenstein(g))
        }
        (Some(_), Some(field)) => {
            field.ensure_valid(false, "belongs to `phase henyey-greenstein`: leave one of both out")?;
            Ok(PhaseFunctionDescription::Isotropic)
        }
        (Some(_), None) => Ok(PhaseFunctionDescription::HenyeyGreenstein(f.value_or_default("anisotropy")?)),
    }
}

/// Writes the phase function; nothing for the default.
pub(super) fn write_phase_function(out: &mut SceneWriter<'_, '_>, phase: PhaseFunctionDescription) -> fmt::Result {
    match phase {
        PhaseFunctionDescription::Isotropic => Ok(()),
        PhaseFunctionDescription::Rayleigh => out.write_field("phase", "rayleigh"),
        PhaseFunctionDescription::HenyeyGreenstein(g) => out.write_number("anisotropy", g),
    }
}

/// Converts the description to the renderer's phase function.
pub(super) fn resolve_phase_function(phase: PhaseFunctionDescription) -> PhaseFunction {
    match phase {
        PhaseFunctionDescription::Isotropic => PhaseFunction::Isotropic,
        PhaseFunctionDescription::Rayleigh => PhaseFunction::Rayleigh,
        PhaseFunctionDescription::HenyeyGreenstein(g) => PhaseFunction::HenyeyGreenstein(g as f32),
    }
}
