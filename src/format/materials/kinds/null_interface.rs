//! The block `Clear` of the scene language: a boundary that light crosses unchanged.

use super::fields::PRIORITY_FIELD;
use super::{EnclosedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldEntry};
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::scene::{Body, Material};
use std::fmt;

/// Null interface: bounds a region of a medium. Light crosses it unchanged.
#[derive(Clone, Debug, PartialEq)]
pub struct NullInterfaceDescription {
    /// Priority of the region. Where bodies overlap, the body with the highest priority fills the
    /// overlap.
    pub priority: u8,
}

impl BlockCodec for NullInterfaceDescription {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let advice = "needs a surface, and `Clear` has none: ";
        f.forbid_fields(&["emission", "emissionScale"], &format!("{advice}give `emission` to its medium"))?;
        f.forbid_fields(&["bump", "bumpHeight", "normalMap"], &format!("{advice}leave it out"))?;
        Ok(Self { priority: PRIORITY_FIELD.parse(f)? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        PRIORITY_FIELD.write(out, &self.priority)
    }
}

impl MaterialBlock for NullInterfaceDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("Clear", "null interface: boundary of a region without a surface")
            .with_own_fields(&[
                field_schema("medium", FieldKind::Name, "medium that fills the region").make_optional("none"),
                PRIORITY_FIELD,
            ])
            .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::NullInterface;

    fn resolve(&self, _: &mut Resolver<'_>, _: &mut TextureRequirements) -> Result<Material, SceneError> {
        let body = Body { priority: self.priority, is_null_interface: true, ..Body::new(1.0) };
        Ok(Material::smooth_boundary(body))
    }
}
