//! The block `DirectionalLight` of the scene language: parallel light from infinity.

use super::LightBlock;
use super::delta::add_delta_light;
use crate::format::error::SceneError;
use crate::format::language::field_table::BlockCodec;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::{Resolver, rgb};
use crate::format::span::Span;
use crate::math::Motion;
use crate::scene::{LightStrength, UnscaledDeltaLight};
use glam::DVec3;
use std::fmt;

/// A directional light: parallel light from infinity.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectionalLightDescription {
    /// Direction in which the light travels; need not have unit length.
    pub direction: DVec3,
    /// Irradiance, or color of the shading model of MIT course 6.837.
    pub strength: DirectionalLightStrength,
}

/// Strength of a directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionalLightStrength {
    /// Color c in the shading model of MIT course 6.837: the light gives the irradiance π·c to a
    /// surface perpendicular to it, in W/m².
    Mit6837Color(DVec3),
    /// Irradiance in W/m² of a surface perpendicular to the light.
    Irradiance(DVec3),
}

impl BlockCodec for DirectionalLightDescription {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let strength = f.require_one_color_field(&[
            ("color", DirectionalLightStrength::Mit6837Color),
            ("irradiance", DirectionalLightStrength::Irradiance),
        ])?;
        Ok(Self { direction: f.value_or_default("direction")?, strength })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_vec3("direction", self.direction)?;
        match self.strength {
            DirectionalLightStrength::Mit6837Color(c) => out.write_vec3("color", c),
            DirectionalLightStrength::Irradiance(c) => out.write_vec3("irradiance", c),
        }
    }
}

impl LightBlock for DirectionalLightDescription {
    const BLOCK: &'static BlockSchema = &block_schema("DirectionalLight", "parallel light from infinity")
        .with_own_fields(&[
            field_schema("direction", FieldKind::Direction, "direction in which the light travels")
                .make_required()
                .mark_as_mit_6837_syntax(),
            field_schema("color", FieldKind::Color, "color of MIT course 6.837; give this or `irradiance`")
                .mark_as_mit_6837_syntax(),
            field_schema("irradiance", FieldKind::Color, "irradiance of a surface that faces the light")
                .with_unit("W/m²"),
        ])
        .mark_as_mit_6837_syntax();
    const IS_INFINITE: bool = true;

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, _: Span) -> Result<(), SceneError> {
        let strength = match self.strength {
            DirectionalLightStrength::Mit6837Color(c) => LightStrength::Mit6837Color(rgb(c)),
            DirectionalLightStrength::Irradiance(e) => LightStrength::Physical(rgb(e)),
        };
        add_delta_light(r, UnscaledDeltaLight::Directional { direction: self.direction }, strength, motion);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
