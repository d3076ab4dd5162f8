//! Box that a grid or a cloud fills, with its transform to world space.

use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldSchema, field_schema};
use crate::format::language::transforms::write_transform_field;
use crate::format::language::writer::SceneWriter;
use crate::format::transform_step::TransformStep;
use glam::{DAffine3, DVec3};
use std::fmt;

/// A box under an affine transform.
#[derive(Clone, Debug, PartialEq)]
pub struct TransformedBoxDescription {
    /// Corner with the lowest coordinates, before the transform.
    pub min: DVec3,
    /// Opposite corner, above `min` in every coordinate.
    pub max: DVec3,
    /// Steps of the transform to world space; see [`TransformStep::composed_matrix`].
    pub steps: Vec<TransformStep>,
}

/// Fields of the box.
pub(super) const EXTENT_FIELDS: &[FieldSchema] = &[
    field_schema("min", FieldKind::Point, "least corner of the box; required, but for a `Medium` without `grid`"),
    field_schema("max", FieldKind::Point, "greatest corner, above `min` in each component"),
    field_schema("Transform", FieldKind::TransformSteps, "maps from the space of the box to the world")
        .make_optional("none"),
];

/// Returns the box of a grid or cloud, with the transform from box space to world space.
pub(super) fn parse_medium_box(f: &BlockFields<'_>) -> Result<TransformedBoxDescription, SceneError> {
    let (min, max): (DVec3, DVec3) = (f.value_or_default("min")?, f.value_or_default("max")?);
    let sides = max - min;
    let is_valid = sides.min_element() > 0.0 && sides.is_finite();
    f.require_field("max")?.ensure_valid(is_valid, "must be above `min` in each component")?;
    Ok(TransformedBoxDescription { min, max, steps: f.optional_value("Transform").unwrap_or_default() })
}

/// Writes the fields of the box.
pub(super) fn write_medium_box(out: &mut SceneWriter<'_, '_>, extent: &TransformedBoxDescription) -> fmt::Result {
    out.write_vec3("min", extent.min)?;
    out.write_vec3("max", extent.max)?;
    write_transform_field(out, &extent.steps)
}

/// Returns the map from the unit cube \[0, 1]³ to the transformed box `extent` in world space.
pub(super) fn unit_cube_to_world(extent: &TransformedBoxDescription) -> DAffine3 {
    let fit = DAffine3::from_scale(extent.max - extent.min);
    TransformStep::composed_matrix(&extent.steps) * DAffine3 { translation: extent.min, ..fit }
}

/// Returns the number of grid cells along each axis of a box, with `resolution` along its longest
/// side.
///
/// Cells are nearly cubic before the box is transformed. Each axis has at least 2 cells.
pub(super) fn grid_size(extent: &TransformedBoxDescription, resolution: u32) -> [u32; 3] {
    let sides = extent.max - extent.min;
    let count = |side: f64| (f64::from(resolution) * (side / sides.max_element())).ceil().max(2.0) as u32;
    DVec3::to_array(&sides).map(count)
}
