//! Fields that several kinds of materials have.

use crate::format::language::schema::{FieldKind, FieldRange, FieldSchema, field_schema};
use crate::scene::Material;

pub(super) const UNIT_RANGE: FieldRange = FieldRange::ClosedInterval(0.0, 1.0);
pub(super) const TRANSMITTANCE_RANGE: FieldRange = FieldRange::LeftOpenInterval(0.0, 1.0);

pub(super) const ROUGHNESS_FIELD: FieldSchema =
    field_schema("roughness", FieldKind::NumberOrTexture, "GGX α; smooth below 0.001")
        .with_range(UNIT_RANGE)
        .with_default_numbers(&[0.0]);
pub(super) const MULTIPLE_SCATTERING_FIELD: FieldSchema =
    field_schema("multipleScattering", FieldKind::Word(&["yes", "no"]), "`no`: light between microfacets is lost")
        .with_default_word("yes")
        .omit_default();
pub(super) const PRIORITY_FIELD: FieldSchema =
    field_schema("priority", FieldKind::WholeNumber, "where bodies overlap, the highest priority counts")
        .with_range(FieldRange::ClosedInterval(0.0, 255.0))
        .with_default_numbers(&[0.0]);

/// Returns `material` unchanged if `multiple_scattering` is true. Otherwise returns a copy that
/// loses the light that several microfacets scatter in turn.
pub(super) fn with_multiple_scattering(material: Material, multiple_scattering: bool) -> Material {
    if multiple_scattering { material } else { material.with_single_microfacet_scattering() }
}
