//! The block `SpotLight` of the scene language: a point light limited to a cone.

use super::LightBlock;
use super::delta::{POINT_STRENGTH, PointLightStrength, add_delta_light};
use crate::format::aim::{DirectionOrTarget, parse_direction_or_target, write_direction_or_target};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldGroup, FieldWithCheck, field_table};
use crate::format::language::fields::{BlockFields, ParsedField};
use crate::format::language::schema::{BlockSchema, FieldKind, FieldList, FieldRange, block_schema, field_schema};
use crate::format::resolve::Resolver;
use crate::format::span::Span;
use crate::math::Motion;
use crate::scene::UnscaledDeltaLight;
use glam::DVec3;

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

field_table!(SpotLightDescription {
    position: field_schema("position", FieldKind::Point, "apex of the cone").make_required(),
    aim: AIM,
    full_cone_angle_degrees: field_schema("angle", FieldKind::Number, "full opening angle of the cone")
        .with_range(FieldRange::LeftOpenInterval(0.0, 360.0))
        .make_required()
        .with_unit("degrees"),
    penumbra_degrees: FieldWithCheck::new(
        field_schema("penumbra", FieldKind::Number, "width of the soft rim inside the cone, at most half of `angle`")
            .with_range(FieldRange::DescribedOnly("≥ 0"))
            .with_default_numbers(&[0.0])
            .with_unit("degrees"),
        check_penumbra,
    ),
    strength: POINT_STRENGTH,
});

/// Fields for the direction of a spotlight's axis, or for a point on it.
const AIM: FieldGroup<DirectionOrTarget> = FieldGroup {
    list: FieldList::own(&[
        field_schema("direction", FieldKind::Direction, "axis of the cone; give this or `lookAt`"),
        field_schema("lookAt", FieldKind::Point, "point on the axis of the cone"),
    ]),
    parse: |f| Ok(parse_direction_or_target(f, "position", f.value_or_default("position")?)?.0),
    write: |aim, out| write_direction_or_target(out, *aim),
    texture_name: |_| None,
};

impl LightBlock for SpotLightDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("SpotLight", "point light limited to a cone").with_table(Self::FIELDS);
    const IS_INFINITE: bool = false;

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

/// Fails unless the width of the soft rim lies between 0 and half of the cone's opening angle.
fn check_penumbra(f: &BlockFields<'_>, penumbra: &ParsedField<'_, '_>) -> Result<(), SceneError> {
    let half_angle = f.value_or_default::<f64>("angle")? / 2.0;
    let is_valid = (0.0..=half_angle).contains(&penumbra.value::<f64>());
    penumbra.ensure_valid(is_valid, "must lie between 0 and half of the cone's angle")
}
