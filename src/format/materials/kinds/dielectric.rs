//! The block `Dielectric` of the scene language: a body of glass, water or another dielectric.

use super::fields::{MULTIPLE_SCATTERING_FIELD, PRIORITY_FIELD, ROUGHNESS_FIELD, with_multiple_scattering};
use super::{EnclosedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::materials::absorption::{ABSORPTION, DielectricAbsorption};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::materials::refraction::{REFRACTION, RefractiveIndexDescription, resolve_refractive_index};
use crate::format::resolve::textures::TextureRequirements;
use crate::format::resolve::{Resolver, rgb};
use crate::format::textured_value::TexturedValue;
use crate::scene::{Body, Material};

/// Boundary of a body of glass, water or another dielectric.
#[derive(Clone, Debug, PartialEq)]
pub struct DielectricDescription {
    /// Index of refraction of the body.
    pub refraction: RefractiveIndexDescription,
    /// Absorption inside the body.
    pub absorption: DielectricAbsorption,
    /// GGX α, inside \[0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// True if light that several microfacets scatter in turn is included; false if this light is
    /// lost, as in pbrt-v4 and Mitsuba 3.
    pub has_multiple_scattering: bool,
    /// Priority of the body (Schmidt and Budge 2002). Where bodies overlap, the body with the
    /// highest priority fills the overlap; among equal priorities, the body that a ray entered
    /// last.
    pub priority: u8,
}

field_table!(DielectricDescription {
    refraction: REFRACTION,
    absorption: ABSORPTION,
    roughness: ROUGHNESS_FIELD,
    has_multiple_scattering: MULTIPLE_SCATTERING_FIELD,
    priority: PRIORITY_FIELD,
});

impl MaterialBlock for DielectricDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Dielectric", "boundary of a body of glass, water or the like")
        .with_table(Self::FIELDS)
        .with_own_fields(&[field_schema("medium", FieldKind::Name, "medium that fills the body").make_optional("none")])
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::Dielectric;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let roughness = r.resolve_fraction_parameter(&self.roughness, requirements)?;
        let (index, dispersion_formula) = resolve_refractive_index(r, &self.refraction)?;
        let absorption = rgb(self.absorption.absorption_coefficient());
        let body = Body { absorption, priority: self.priority, dispersion_formula, ..Body::new(index) };
        Ok(with_multiple_scattering(Material::rough_boundary(body, roughness), self.has_multiple_scattering))
    }
}
