//! The field `emission`, which all shapes have.

use crate::format::language::schema::{FieldKind, FieldSchema, field_schema};

/// The field `emission`, which the blocks of all shapes have.
pub(super) const EMISSION_FIELDS: &[FieldSchema] =
    &[field_schema("emission", FieldKind::Color, "radiance instead of the material's; not for a `Plane`")
        .make_optional("the material's")
        .with_unit("W/(m² sr)")];
