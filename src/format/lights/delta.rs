//! Strengths of lights without area, and adding such lights to the scene.

use crate::format::error::SceneError;
use crate::format::language::field_table::FieldGroup;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldList, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::{Resolver, rgb};
use crate::math::Motion;
use crate::scene::{LightStrength, UnscaledDeltaLight};
use glam::DVec3;
use std::fmt;

/// Strength of a point light, spotlight, projector or goniometric light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointLightStrength {
    /// Color in the shading model of MIT course 6.837, where light does not fall off with
    /// distance.
    Mit6837Color(DVec3),
    /// Radiant intensity in W/sr.
    Intensity(DVec3),
    /// Radiant flux in W.
    Power(DVec3),
}

/// Fields for the strength of a point light or spotlight; a block has exactly one of them.
pub(super) const POINT_STRENGTH: FieldGroup<PointLightStrength> = FieldGroup {
    list: FieldList::shared(&[
        field_schema(
            "color",
            FieldKind::Color,
            "color of MIT course 6.837, without distance falloff; give one of the three",
        )
        .mark_as_mit_6837_syntax(),
        field_schema("intensity", FieldKind::Color, "radiant intensity; on the axis of a spotlight").with_unit("W/sr"),
        field_schema("power", FieldKind::Color, "radiant flux").with_unit("W"),
    ]),
    parse: PointLightStrength::parse,
    write: PointLightStrength::write,
    texture_name: |_| None,
};

/// Fields for the strength of a projector or goniometric light; a block has exactly one of them.
pub(super) const PATTERN_STRENGTH: FieldGroup<PointLightStrength> = FieldGroup {
    list: FieldList::shared(&[
        field_schema("intensity", FieldKind::Color, "radiant intensity where the picture or profile is 1")
            .with_unit("W/sr"),
        field_schema(
            "power",
            FieldKind::Color,
            "radiant flux, of white light through the picture; give one of the two",
        )
        .with_unit("W"),
    ]),
    parse: PointLightStrength::parse_pattern_strength,
    write: PointLightStrength::write,
    texture_name: |_| None,
};

impl PointLightStrength {
    /// Parses the strength of a point light or spotlight.
    fn parse(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        f.require_one_color_field(&[
            ("color", Self::Mit6837Color),
            ("intensity", Self::Intensity),
            ("power", Self::Power),
        ])
    }

    /// Parses the strength of a projector or goniometric light.
    fn parse_pattern_strength(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        f.require_one_color_field(&[("intensity", Self::Intensity), ("power", Self::Power)])
    }

    /// Writes the field that states the strength.
    fn write(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        match *self {
            Self::Mit6837Color(c) => out.write_vec3("color", c),
            Self::Intensity(c) => out.write_vec3("intensity", c),
            Self::Power(c) => out.write_vec3("power", c),
        }
    }

    /// Returns the strength in single precision.
    pub(super) fn resolve(self) -> LightStrength {
        match self {
            Self::Mit6837Color(c) => LightStrength::Mit6837Color(rgb(c)),
            Self::Intensity(i) => LightStrength::Physical(rgb(i)),
            Self::Power(w) => LightStrength::Power(rgb(w)),
        }
    }
}

/// Adds a light without area to the scene. `motion` moves the light while the shutter is open; its
/// rotations and scales are about the light's own position.
pub(super) fn add_delta_light(
    r: &mut Resolver<'_>,
    kind: UnscaledDeltaLight,
    strength: LightStrength,
    motion: &Motion,
) {
    if motion.is_constant() {
        r.builder.add_delta_light(kind, strength);
    } else {
        r.builder.add_moving_delta_light(kind, strength, motion);
    }
}
