//! The fields of a parallelogram, which rectangles and rectangle lights have.

use super::error::SceneError;
use super::language::fields::BlockFields;
use super::language::writer::SceneWriter;
use glam::DVec3;
use std::fmt;

/// Returns the corner and both edge vectors of a parallelogram; an error if its area is 0.
pub(super) fn parse_parallelogram(f: &BlockFields<'_>) -> Result<(DVec3, DVec3, DVec3), SceneError> {
    let (corner, edge0, edge1): (_, DVec3, DVec3) =
        (f.value_or_default("corner")?, f.value_or_default("edge0")?, f.value_or_default("edge1")?);
    // Rounding alone gives parallel edges a sine of about 1e-16.
    let sine = edge0.normalize().cross(edge1.normalize()).length();
    f.require_field("edge1")?.ensure_valid(sine > 1e-12, "must not be parallel to `edge0`: the area would be 0")?;
    Ok((corner, edge0, edge1))
}

/// Writes the fields of a parallelogram: its corner and both edges.
pub(super) fn write_parallelogram(
    out: &mut SceneWriter<'_, '_>,
    corner: DVec3,
    edge0: DVec3,
    edge1: DVec3,
) -> fmt::Result {
    out.write_vec3("corner", corner)?;
    out.write_vec3("edge0", edge0)?;
    out.write_vec3("edge1", edge1)
}
