//! Orientation of cameras and lights: the fields `direction` and `lookAt`.

use super::error::SceneError;
use super::language::fields::BlockFields;
use super::language::text::is_normalizable;
use super::language::writer::SceneWriter;
use glam::DVec3;
use std::fmt;

/// Orientation of a camera or light: a direction, or a point to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionOrTarget {
    /// Direction in which the camera or light faces, of any length above 0.
    Direction(DVec3),
    /// Point that the camera or light looks at.
    Target(DVec3),
}

impl DirectionOrTarget {
    /// Returns the view direction, not normalized: the given direction, or the vector from the
    /// point `from` to the target.
    pub(super) fn direction_from(self, from: DVec3) -> DVec3 {
        match self {
            Self::Direction(direction) => direction,
            Self::Target(point) => point - from,
        }
    }
}

/// Parses the field `direction` or `lookAt` of a camera or light at the position `center`.
///
/// Returns the parsed field, and the direction from `center` that the field gives (not normalized).
/// `center_name` is the keyword of the field that holds `center`, for error messages.
pub(super) fn parse_direction_or_target(
    f: &BlockFields<'_>,
    center_name: &str,
    center: DVec3,
) -> Result<(DirectionOrTarget, DVec3), SceneError> {
    let field = f.require_one_field_of(&["direction", "lookAt"])?;
    let value: DVec3 = field.value();
    if field.name() == "direction" {
        return Ok((DirectionOrTarget::Direction(value), value));
    }
    let direction = value - center;
    field.ensure_valid(is_normalizable(direction), &format!("must lie at some distance from `{center_name}`"))?;
    Ok((DirectionOrTarget::Target(value), direction))
}

/// Writes `aim` as the field `direction` or the field `lookAt`.
pub(super) fn write_direction_or_target(out: &mut SceneWriter<'_, '_>, aim: DirectionOrTarget) -> fmt::Result {
    match aim {
        DirectionOrTarget::Direction(direction) => out.write_vec3("direction", direction),
        DirectionOrTarget::Target(point) => out.write_vec3("lookAt", point),
    }
}
