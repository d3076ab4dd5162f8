//! The block `Conductor` of the scene language: a metal.

use super::fields::{MULTIPLE_SCATTERING_FIELD, ROUGHNESS_FIELD, with_multiple_scattering};
use super::{EnclosedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, block_schema};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::metal::{METAL, MetalDescription, resolve_metal};
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;

/// An opaque conductor.
#[derive(Clone, Debug, PartialEq)]
pub struct ConductorDescription {
    /// Complex index of refraction, or reflectance.
    pub metal: MetalDescription,
    /// GGX α, inside \[0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// True if light that several microfacets scatter in turn is included; false if this light is
    /// lost, as in pbrt-v4 and Mitsuba 3.
    pub has_multiple_scattering: bool,
}

field_table!(ConductorDescription {
    metal: METAL,
    roughness: ROUGHNESS_FIELD,
    has_multiple_scattering: MULTIPLE_SCATTERING_FIELD,
});

impl MaterialBlock for ConductorDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Conductor", "metal; opaque, reflects on both sides")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let index = resolve_metal(r, &self.metal, requirements)?;
        let roughness = r.resolve_fraction_parameter(&self.roughness, requirements)?;
        let metal = Material::conductor_of_index(index, roughness);
        Ok(with_multiple_scattering(metal, self.has_multiple_scattering))
    }
}
