//! The block `SpotLight`.

use super::LightBlock;
use super::delta::{POINT_STRENGTH_FIELDS, PointLightStrength, add_delta_light};
use crate::format::aim::{DirectionOrTarget, parse_direction_or_target, write_direction_or_target};
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::span::Span;
use crate::math::Motion;
use crate::scene::UnscaledDeltaLight;
use glam::DVec3;
use std::fmt;

/// A spotlight: a point light limited to a cone.
#[derive(Clone, Debug, PartialEq)]
pub struct SpotLightDescription {
    /// Position of the cone's apex.
    pub position: DVec3,
    /// Direction of the cone's axis.
    pub aim: DirectionOrTarget,
    /// Full opening angle of the cone in degrees, inside (0, 360].
    pub full_cone_angle_degrees: f64,
    /// Angular width of the soft rim inside the cone in degrees, at most half of
    /// `full_cone_angle_degrees`.
    pub penumbra_degrees: f64,
    /// Strength of the light. An intensity or color is the value along the cone's axis.
    pub strength: PointLightStrength,
}

static SPOT: BlockSchema = block_schema("SpotLight", "point light limited to a cone")
    .with_fields(&[
        field_schema("position", FieldKind::Point, "apex of the cone").make_required(),
        field_schema("direction", FieldKind::Direction, "axis of the cone; give this or `lookAt`"),
        field_schema("lookAt", FieldKind::Point, "point on the axis of the cone"),
        field_schema("angle", FieldKind::Number, "full opening angle of the cone")
            .with_range(FieldRange::LeftOpenInterval(0.0, 360.0))
            .make_required()
            .with_unit("degrees"),
        field_schema("penumbra", FieldKind::Number, "width of the soft rim inside the cone, at most half of `angle`")
            .with_range(FieldRange::DescribedOnly("≥ 0"))
            .with_default_numbers(&[0.0])
            .with_unit("degrees"),
    ])
    .with_shared_fields(&[POINT_STRENGTH_FIELDS]);

impl LightBlock for SpotLightDescription {
    const BLOCK: &'static BlockSchema = &SPOT;
    const IS_INFINITE: bool = false;

    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let position = f.value_or_default("position")?;
        let (aim, _) = parse_direction_or_target(f, "position", position)?;
        let (angle, penumbra) = (f.value_or_default("angle")?, f.value_or_default("penumbra")?);
        if let Some(field) = f.get("penumbra") {
            let is_valid = (0.0..=angle / 2.0).contains(&penumbra);
            field.ensure_valid(is_valid, "must lie between 0 and half of the cone's angle")?;
        }
        Ok(Self {
            position,
            aim,
            full_cone_angle_degrees: angle,
            penumbra_degrees: penumbra,
            strength: PointLightStrength::parse(f)?,
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_vec3("position", self.position)?;
        write_direction_or_target(out, self.aim)?;
        out.write_number("angle", self.full_cone_angle_degrees)?;
        out.write_number("penumbra", self.penumbra_degrees)?;
        self.strength.write(out)
    }

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, _: Span) -> Result<(), SceneError> {
        let outer = 0.5 * self.full_cone_angle_degrees.to_radians();
        let kind = UnscaledDeltaLight::Spot {
            position: self.position,
            axis: self.aim.direction_from(self.position),
            inner: (outer - self.penumbra_degrees.to_radians()).max(0.0),
            outer,
        };
        add_delta_light(r, kind, self.strength.resolve(), motion);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
