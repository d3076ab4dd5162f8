//! The block `PointLight` of the scene language: a point light with equal intensity in all
//! directions.

use super::LightBlock;
use super::delta::{POINT_STRENGTH, PointLightStrength, add_delta_light};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::resolve::Resolver;
use crate::format::span::Span;
use crate::math::Motion;
use crate::scene::UnscaledDeltaLight;
use glam::DVec3;

/// A point light with equal intensity in all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct PointLightDescription {
    /// Position of the point light.
    pub position: DVec3,
    /// Radiant intensity, flux, or color of the shading model of MIT course 6.837.
    pub strength: PointLightStrength,
}

field_table!(PointLightDescription {
    position: field_schema("position", FieldKind::Point, "position").make_required().mark_as_mit_6837_syntax(),
    strength: POINT_STRENGTH,
});

impl LightBlock for PointLightDescription {
    const BLOCK: &'static BlockSchema = &block_schema("PointLight", "point light, equal in all directions")
        .with_table(Self::FIELDS)
        .mark_as_mit_6837_syntax();
    const IS_INFINITE: bool = false;

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, _: Span) -> Result<(), SceneError> {
        add_delta_light(r, UnscaledDeltaLight::Point { position: self.position }, self.strength.resolve(), motion);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        None
    }
}
