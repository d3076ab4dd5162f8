//! The block `CoatedDiffuse`.

use super::fields::{ROUGHNESS_FIELD, UNIT_RANGE};
use super::{BoundedBody, MaterialBlock};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::parser::Parser;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
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

/// A diffuse base under a dielectric coat, such as plastic.
#[derive(Clone, Debug, PartialEq)]
pub struct CoatedDiffuseDescription {
    /// Reflectance of the base, inside [0, 1].
    pub reflectance: TexturedValue<DVec3>,
    /// Index of refraction of the coat relative to the surroundings, inside [1, 4].
    pub eta: f64,
    /// GGX α of the coat, inside [0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// True to account for color shifts by interreflection between coat and base, like `nonlinear`
    /// of Mitsuba's `plastic`.
    pub is_nonlinear: bool,
}

static COATED_DIFFUSE: BlockSchema =
    block_schema("CoatedDiffuse", "diffuse base under a dielectric coat: plastic, varnish, glaze")
        .with_fields(&[
            field_schema("reflectance", FieldKind::ColorOrTexture, "albedo of the base")
                .with_range(UNIT_RANGE)
                .make_required(),
            field_schema("indexOfRefraction", FieldKind::Number, "index of the coat relative to the surroundings")
                .with_range(FieldRange::ClosedInterval(1.0, MAX_COAT_INDEX as f64))
                .with_default_numbers(&[1.5]),
            ROUGHNESS_FIELD,
            field_schema(
                "nonlinear",
                FieldKind::Word(&["yes", "no"]),
                "`no`: light between coat and base does not make colors deeper",
            )
            .with_default_word("yes"),
        ])
        .with_aliases(&["Plastic"])
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for CoatedDiffuseDescription {
    const BLOCK: &'static BlockSchema = &COATED_DIFFUSE;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self {
            reflectance: f.value_or_default("reflectance")?,
            eta: f.value_or_default("indexOfRefraction")?,
            roughness: f.value_or_default("roughness")?,
            is_nonlinear: f.field_word_or_default("nonlinear")? == "yes",
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_color_or_texture("reflectance", &self.reflectance)?;
        out.write_number("indexOfRefraction", self.eta)?;
        out.write_number_or_texture("roughness", &self.roughness)?;
        out.write_field("nonlinear", if self.is_nonlinear { "yes" } else { "no" })
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let reflectance = r.resolve_reflectance_parameter(&self.reflectance, requirements)?;
        let roughness = r.resolve_fraction_parameter(&self.roughness, requirements)?;
        Ok(Material::coated_diffuse(reflectance, self.eta as f32, roughness, self.is_nonlinear))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        [self.reflectance.texture_name(), self.roughness.texture_name()].into_iter().flatten().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}
