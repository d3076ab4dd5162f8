//! The field `emission`, which all shapes have.

use crate::format::language::schema::{FieldKind, FieldSchema, field_schema};

/// Fields that all shapes have.
pub(super) static EMISSION_FIELDS: &[FieldSchema] =
    &[field_schema("emission", FieldKind::Color, "radiance instead of the material's; not for a `Plane`")
        .with_default_description("the material's")
        .with_unit("W/(m² sr)")];
