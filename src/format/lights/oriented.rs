//! Position and orientation of projectors and goniometric lights.

use crate::format::aim::{DirectionOrTarget, parse_direction_or_target, write_direction_or_target};
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldSchema, field_schema};
use crate::format::language::writer::SceneWriter;
use glam::DVec3;
use std::fmt;

/// Position and orientation of a projector or goniometric light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPose {
    /// Position of the light.
    pub position: DVec3,
    /// Axis of the light. A projector casts the center of its picture along the axis. The center of
    /// an intensity map lies in the direction of the axis. An intensity profile counts its angles
    /// from the axis.
    pub aim: DirectionOrTarget,
    /// Direction toward the top of the light's picture or map; need not have unit length. `None`
    /// means +y, or −z if the axis is nearly parallel to y.
    pub up: Option<DVec3>,
}

/// Fields of a [`LightPose`].
pub(super) const POSE_FIELDS: &[FieldSchema] = &[
    field_schema("position", FieldKind::Point, "position").make_required(),
    field_schema("direction", FieldKind::Direction, "axis of the light; give this or `lookAt`"),
    field_schema("lookAt", FieldKind::Point, "point on the axis of the light"),
    field_schema("up", FieldKind::Direction, "upper side of the picture")
        .make_optional("0 1 0, or 0 0 -1 for a vertical axis"),
];

impl LightPose {
    /// Parses position and orientation. The field `up` must not be nearly parallel to the axis.
    pub(super) fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let position = f.value_or_default("position")?;
        let (aim, direction) = parse_direction_or_target(f, "position", position)?;
        let up: Option<DVec3> = f.optional_value("up");
        if let (Some(field), Some(up)) = (f.get("up"), up) {
            // For a smaller sine of the angle between `up` and the axis, rounding decides which way
            // is up.
            let sine = up.normalize().cross(direction.normalize()).length();
            field.ensure_valid(sine >= 1e-9, "must not be parallel to the axis of the light")?;
        }
        Ok(Self { position, aim, up })
    }

    /// Writes position and orientation.
    pub(super) fn write(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_vec3("position", self.position)?;
        write_direction_or_target(out, self.aim)?;
        self.up.map_or(Ok(()), |up| out.write_vec3("up", up))
    }

    /// Returns the direction of the light's axis, and the up direction. Neither is normalized.
    pub(super) fn direction_and_up(&self) -> (DVec3, DVec3) {
        let direction = self.aim.direction_from(self.position);
        let vertical = direction.cross(DVec3::Y).length() < 1e-6 * direction.length();
        (direction, self.up.unwrap_or(if vertical { DVec3::NEG_Z } else { DVec3::Y }))
    }
}
