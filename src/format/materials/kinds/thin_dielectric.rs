//! The block `Thin` of the scene language: a pane without thickness.

use super::fields::TRANSMITTANCE_RANGE;
use super::{EnclosedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::materials::refraction::{MAX_REFRACTIVE_INDEX, MIN_REFRACTIVE_INDEX};
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;

/// A pane without thickness: light passes straight through or is reflected.
#[derive(Clone, Debug, PartialEq)]
pub struct ThinDielectricDescription {
    /// Index of refraction relative to the surroundings.
    pub eta: f64,
    /// Transmittance of the pane's interior at normal incidence, inside (0, 1].
    pub transmittance: TexturedValue<DVec3>,
}

field_table!(ThinDielectricDescription {
    eta: field_schema("indexOfRefraction", FieldKind::Number, "index of refraction relative to the surroundings")
        .with_range(FieldRange::ClosedInterval(MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX))
        .with_default_numbers(&[1.5]),
    transmittance: field_schema(
        "transmittance",
        FieldKind::ColorOrTexture,
        "transmittance of the inside at normal incidence"
    )
    .with_range(TRANSMITTANCE_RANGE)
    .with_default_numbers(&[1.0, 1.0, 1.0]),
});

impl MaterialBlock for ThinDielectricDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Thin", "pane without thickness")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let transmittance = r.resolve_reflectance_parameter(&self.transmittance, requirements)?;
        Ok(Material::thin_dielectric(self.eta as f32, transmittance))
    }
}
