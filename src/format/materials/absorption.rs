//! Absorption inside a `Dielectric`: description, reading and writing.

use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::MAX_MEDIUM_COEFFICIENT;
use crate::format::language::writer::SceneWriter;
use glam::DVec3;
use std::fmt;

/// Absorption inside a dielectric body: none, a coefficient, or a transmittance over a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DielectricAbsorption {
    /// A body that absorbs nothing.
    None,
    /// Absorption coefficient σa in 1/length.
    Coefficient(DVec3),
    /// Transmittance over a given distance.
    Tint {
        /// Transmittance over `distance`, inside (0, 1].
        color: DVec3,
        /// Distance over which `color` is the transmittance, in scene units, above 0.
        distance: f64,
    },
}

impl DielectricAbsorption {
    /// Returns the absorption coefficient \[1/length] of the body, by Beer's law; 0 for `None`.
    #[must_use]
    pub fn absorption_coefficient(self) -> DVec3 {
        match self {
            Self::None => DVec3::ZERO,
            Self::Coefficient(sigma) => sigma,
            Self::Tint { color, distance } => -color.map(libm::log) / distance,
        }
    }
}

/// Returns the absorption inside a dielectric, from the field `absorption` or `tint`; none if both
/// are absent.
pub(super) fn parse_dielectric_absorption(f: &BlockFields<'_>) -> Result<DielectricAbsorption, SceneError> {
    f.forbid_both_fields("absorption", "tint")?;
    let Some(color) = f.optional_value("tint") else {
        f.forbid_fields(&["tintDistance"], "has no effect without `tint`")?;
        return Ok(f
            .optional_value("absorption")
            .map_or(DielectricAbsorption::None, DielectricAbsorption::Coefficient));
    };
    let attenuation = DielectricAbsorption::Tint { color, distance: f.value_or_default("tintDistance")? };
    if let Some(field) = f.get("tintDistance") {
        let is_valid = attenuation.absorption_coefficient().max_element() <= MAX_MEDIUM_COEFFICIENT;
        field.ensure_valid(is_valid, "must be longer: over it, `tint` is an absorption above 1e12")?;
    }
    Ok(attenuation)
}

/// Writes the fields that state the absorption; none for a body that absorbs nothing.
pub(super) fn write_dielectric_absorption(
    out: &mut SceneWriter<'_, '_>,
    attenuation: DielectricAbsorption,
) -> fmt::Result {
    match attenuation {
        DielectricAbsorption::None => Ok(()),
        DielectricAbsorption::Coefficient(absorption) => out.write_vec3("absorption", absorption),
        DielectricAbsorption::Tint { color, distance } => {
            out.write_vec3("tint", color)?;
            out.write_number("tintDistance", distance)
        }
    }
}
