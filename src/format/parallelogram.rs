//! The fields of a parallelogram, which rectangles and rectangle lights have.

use super::error::SceneError;
use crate::format::language::field_table::FieldWithCheck;
use crate::format::language::fields::{BlockFields, ParsedField};
use crate::format::language::schema::{FieldKind, FieldSchema, field_schema};
use glam::DVec3;

/// Field for the corner of a parallelogram where both edge vectors start.
pub(super) const CORNER: FieldSchema =
    field_schema("corner", FieldKind::Point, "corner where both edges start").make_required();

/// Field for the first edge vector of a parallelogram.
pub(super) const EDGE0: FieldSchema =
    field_schema("edge0", FieldKind::Direction, "vector to the first neighbouring corner").make_required();

/// Field for the second edge vector of a parallelogram, which must not be parallel to the first.
pub(super) const EDGE1: FieldWithCheck = FieldWithCheck::new(
    field_schema("edge1", FieldKind::Direction, "vector to the other neighbouring corner").make_required(),
    check_area,
);

/// Fails if both edges of the parallelogram are parallel up to rounding, so that its area is 0.
fn check_area(f: &BlockFields<'_>, edge1: &ParsedField<'_, '_>) -> Result<(), SceneError> {
    let edge0: DVec3 = f.value_or_default("edge0")?;
    // Rounding alone gives parallel edges a sine of about 1e-16.
    let sine = edge0.normalize().cross(edge1.value::<DVec3>().normalize()).length();
    edge1.ensure_valid(sine > 1e-12, "must not be parallel to `edge0`: the area would be 0")
}
