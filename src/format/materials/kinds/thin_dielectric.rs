//! The block `Thin`.

use super::fields::TRANSMITTANCE_RANGE;
use super::{BoundedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::parser::Parser;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::materials::refraction::INDEX_FIELD;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;
use std::fmt;

/// A pane without thickness: light passes straight through or is reflected.
#[derive(Clone, Debug, PartialEq)]
pub struct ThinDielectricDescription {
    /// Index of refraction relative to the surroundings.
    pub eta: f64,
    /// Transmittance of the pane's interior at normal incidence, inside (0, 1].
    pub transmittance: TexturedValue<DVec3>,
}

static THIN: BlockSchema = block_schema("Thin", "pane without thickness; the index is relative to the surroundings")
    .with_fields(&[
        INDEX_FIELD,
        field_schema("transmittance", FieldKind::ColorOrTexture, "transmittance of the inside at normal incidence")
            .with_range(TRANSMITTANCE_RANGE)
            .with_default_numbers(&[1.0, 1.0, 1.0]),
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for ThinDielectricDescription {
    const BLOCK: &'static BlockSchema = &THIN;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self { eta: f.value_or_default("indexOfRefraction")?, transmittance: f.value_or_default("transmittance")? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_number("indexOfRefraction", self.eta)?;
        out.write_color_or_texture("transmittance", &self.transmittance)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let transmittance = r.resolve_reflectance_parameter(&self.transmittance, requirements)?;
        Ok(Material::thin_dielectric(self.eta as f32, transmittance))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.transmittance.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}
