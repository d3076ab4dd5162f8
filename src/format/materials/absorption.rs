//! Absorption inside a `Dielectric`: description, reading and writing.

use crate::format::error::SceneError;
use crate::format::language::field_table::FieldGroup;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldList, FieldRange, MAX_MEDIUM_COEFFICIENT, field_schema};
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

/// Fields that state the absorption inside a dielectric.
pub(super) const ABSORPTION: FieldGroup<DielectricAbsorption> = FieldGroup {
    list: FieldList::own(&[
        field_schema("absorption", FieldKind::Color, "absorption coefficient of the inside")
            .with_range(FieldRange::ClosedInterval(0.0, MAX_MEDIUM_COEFFICIENT))
            .make_optional("0 0 0")
            .with_unit("1/length"),
        field_schema("tint", FieldKind::Color, "instead of `absorption`: transmittance over `tintDistance`")
            .with_range(FieldRange::LeftOpenInterval(0.0, 1.0)),
        field_schema("tintDistance", FieldKind::Number, "distance of `tint`; the absorption is at most 1e12")
            .with_range(FieldRange::Positive)
            .with_default_numbers(&[1.0])
            .with_unit("length"),
    ]),
    parse: parse_absorption,
    write: write_absorption,
    texture_name: |_| None,
};

/// Returns the absorption inside a dielectric, from the field `absorption` or `tint`. If both are
/// absent, returns [`DielectricAbsorption::None`].
fn parse_absorption(f: &BlockFields<'_>) -> Result<DielectricAbsorption, SceneError> {
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

/// Writes the fields that state the absorption. Writes no field for a body that absorbs nothing.
fn write_absorption(absorption: &DielectricAbsorption, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
    match *absorption {
        DielectricAbsorption::None => Ok(()),
        DielectricAbsorption::Coefficient(absorption) => out.write_vec3("absorption", absorption),
        DielectricAbsorption::Tint { color, distance } => {
            out.write_vec3("tint", color)?;
            out.write_number("tintDistance", distance)
        }
    }
}
