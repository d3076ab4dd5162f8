//! The block `Mirror` of the scene language: a perfect mirror.

use super::fields::UNIT_RANGE;
use super::{EnclosedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;

/// A perfect mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorDescription {
    /// Reflectance, inside \[0, 1].
    pub reflectance: TexturedValue<DVec3>,
}

field_table!(MirrorDescription {
    reflectance: field_schema("reflectance", FieldKind::ColorOrTexture, "reflectance")
        .with_range(UNIT_RANGE)
        .with_default_numbers(&[1.0, 1.0, 1.0]),
});

impl MaterialBlock for MirrorDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Mirror", "perfect mirror")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        Ok(Material::mirror(r.resolve_reflectance_parameter(&self.reflectance, requirements)?))
    }
}
