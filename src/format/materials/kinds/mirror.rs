//! The block `Mirror`.

use super::fields::UNIT_RANGE;
use super::{BoundedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::parser::Parser;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;
use std::fmt;

/// A perfect mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorDescription {
    /// Reflectance, inside [0, 1].
    pub reflectance: TexturedValue<DVec3>,
}

static MIRROR: BlockSchema = block_schema("Mirror", "perfect mirror")
    .with_fields(&[field_schema("reflectance", FieldKind::ColorOrTexture, "reflectance")
        .with_range(UNIT_RANGE)
        .with_default_numbers(&[1.0, 1.0, 1.0])])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for MirrorDescription {
    const BLOCK: &'static BlockSchema = &MIRROR;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self { reflectance: f.value_or_default("reflectance")? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_color_or_texture("reflectance", &self.reflectance)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        Ok(Material::mirror(r.resolve_reflectance_parameter(&self.reflectance, requirements)?))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.reflectance.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}
