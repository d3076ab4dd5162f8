//! The block `DiffuseTransmission` of the scene language: a sheet that scatters light to both
//! sides.

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

/// A thin sheet that scatters light diffusely to both sides, such as paper or a leaf.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseTransmissionDescription {
    /// Reflectance, inside \[0, 1]. Where its sum with `transmittance` exceeds 1, both are scaled
    /// down.
    pub reflectance: TexturedValue<DVec3>,
    /// Transmittance, inside \[0, 1]. Where its sum with `reflectance` exceeds 1, both are scaled
    /// down.
    pub transmittance: TexturedValue<DVec3>,
}

field_table!(DiffuseTransmissionDescription {
    reflectance: field_schema(
        "reflectance",
        FieldKind::ColorOrTexture,
        "part of the light that is reflected; scaled where its sum with `transmittance` exceeds 1",
    )
    .with_range(UNIT_RANGE)
    .make_required(),
    transmittance: field_schema("transmittance", FieldKind::ColorOrTexture, "part of the light that is transmitted")
        .with_range(UNIT_RANGE)
        .make_required(),
});

impl MaterialBlock for DiffuseTransmissionDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("DiffuseTransmission", "sheet that scatters light diffusely to both sides: paper, cloth, leaves")
            .with_table(Self::FIELDS)
            .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let reflectance = r.resolve_reflectance_parameter(&self.reflectance, requirements)?;
        let transmittance = r.resolve_reflectance_parameter(&self.transmittance, requirements)?;
        Ok(Material::diffuse_transmission(reflectance, transmittance))
    }
}
