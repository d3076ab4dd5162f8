//! Absorption and scattering coefficients of a medium, in two parametrizations.

use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldRange, FieldSchema, MAX_MEDIUM_COEFFICIENT, field_schema};
use crate::format::language::writer::SceneWriter;
use glam::DVec3;
use std::fmt;

/// Absorption and scattering coefficients of a medium, in one of two parametrizations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MediumCoefficients {
    /// Absorption and scattering coefficients.
    AbsorptionScattering {
        /// Absorption coefficient σa in 1/length at density 1, at least 0.
        absorption: DVec3,
        /// Scattering coefficient σs in 1/length at density 1, at least 0.
        scattering: DVec3,
    },
    /// Extinction coefficient and single-scattering albedo.
    ExtinctionAlbedo {
        /// Extinction coefficient σt = σa + σs in 1/length at density 1, at least 0.
        extinction: DVec3,
        /// Single-scattering albedo σs/σt, inside \[0, 1].
        albedo: DVec3,
    },
}

/// Range of the components of coefficients and emission.
pub(super) const COEFFICIENT_RANGE: FieldRange = FieldRange::ClosedInterval(0.0, MAX_MEDIUM_COEFFICIENT);

/// Field for the absorption coefficient.
pub(super) const ABSORPTION: FieldSchema =
    coefficient_field("absorption", "absorption coefficient σa").with_default_numbers(&[0.0, 0.0, 0.0]);

/// Field for the scattering coefficient.
pub(super) const SCATTERING: FieldSchema =
    coefficient_field("scattering", "scattering coefficient σs").with_default_numbers(&[0.0, 0.0, 0.0]);

/// Field for the extinction coefficient.
pub(super) const EXTINCTION: FieldSchema =
    coefficient_field("extinction", "σa + σs, together with `albedo` instead of both");

/// Field for the single-scattering albedo.
pub(super) const ALBEDO: FieldSchema =
    field_schema("albedo", FieldKind::Color, "σs/(σa + σs), together with `extinction`")
        .with_range(FieldRange::ClosedInterval(0.0, 1.0));

/// Field for a coefficient in 1/length with the [`COEFFICIENT_RANGE`], named `name` in the scene
/// language.
const fn coefficient_field(name: &'static str, help: &'static str) -> FieldSchema {
    field_schema(name, FieldKind::Color, help).with_range(COEFFICIENT_RANGE).with_unit("1/length")
}

impl MediumCoefficients {
    /// Returns the absorption and scattering coefficients in 1/length at density 1.
    pub(super) fn absorption_and_scattering(self) -> (DVec3, DVec3) {
        match self {
            Self::AbsorptionScattering { absorption, scattering } => (absorption, scattering),
            Self::ExtinctionAlbedo { extinction, albedo } => (extinction * (1.0 - albedo), extinction * albedo),
        }
    }
}

/// Parses the coefficients of a medium block.
pub(super) fn parse_medium_coefficients(f: &BlockFields<'_>) -> Result<MediumCoefficients, SceneError> {
    for whole in ["extinction", "albedo"] {
        for part in ["absorption", "scattering"] {
            f.forbid_both_fields(part, whole)?;
        }
    }
    let Some(extinction) = f.optional_value("extinction") else {
        f.forbid_fields(&["albedo"], "has no effect without `extinction`")?;
        return Ok(MediumCoefficients::AbsorptionScattering {
            absorption: f.value_or_default("absorption")?,
            scattering: f.value_or_default("scattering")?,
        });
    };
    Ok(MediumCoefficients::ExtinctionAlbedo { extinction, albedo: f.value_or_default("albedo")? })
}

/// Writes the coefficients in their own parametrization.
pub(super) fn write_medium_coefficients(
    out: &mut SceneWriter<'_, '_>,
    coefficients: MediumCoefficients,
) -> fmt::Result {
    match coefficients {
        MediumCoefficients::AbsorptionScattering { absorption, scattering } => {
            out.write_vec3("absorption", absorption)?;
            out.write_vec3("scattering", scattering)
        }
        MediumCoefficients::ExtinctionAlbedo { extinction, albedo } => {
            out.write_vec3("extinction", extinction)?;
            out.write_vec3("albedo", albedo)
        }
    }
}
