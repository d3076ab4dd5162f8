//! The block `Dielectric`.

use super::fields::{
    MULTIPLE_SCATTERING_FIELD, PRIORITY_FIELD, ROUGHNESS_FIELD, TRANSMITTANCE_RANGE, with_multiple_scattering,
    write_multiple_scattering,
};
use super::{BoundedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::parser::Parser;
use crate::format::language::schema::{
    BlockSchema, FieldKind, FieldRange, MAX_MEDIUM_COEFFICIENT, block_schema, field_schema,
};
use crate::format::language::writer::SceneWriter;
use crate::format::materials::absorption::{
    DielectricAbsorption, parse_dielectric_absorption, write_dielectric_absorption,
};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::materials::refraction::{
    INDEX_FIELD, RefractiveIndexDescription, parse_refraction, resolve_refractive_index, write_refraction,
};
use crate::format::resolve::textures::TextureRequirements;
use crate::format::resolve::{Resolver, rgb};
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::{Body, Material};
use std::fmt;

/// Boundary of a body of glass, water or another dielectric.
#[derive(Clone, Debug, PartialEq)]
pub struct DielectricDescription {
    /// Index of refraction of the body.
    pub refraction: RefractiveIndexDescription,
    /// Absorption inside the body.
    pub absorption: DielectricAbsorption,
    /// GGX α, inside [0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// False if light that several microfacets scatter is lost, as in pbrt-v4 and Mitsuba 3.
    pub has_multiple_scattering: bool,
    /// Priority where bodies overlap (Schmidt and Budge 2002): the highest wins. Among equal
    /// priorities, the body that was entered last wins.
    pub priority: u8,
}

const COEFFICIENT_RANGE: FieldRange = FieldRange::ClosedInterval(0.0, MAX_MEDIUM_COEFFICIENT);

static DIELECTRIC: BlockSchema = block_schema("Dielectric", "boundary of a body of glass, water or the like")
    .with_fields(&[
        INDEX_FIELD,
        field_schema("abbe", FieldKind::Number, "with `indexOfRefraction`: Abbe number")
            .with_range(FieldRange::Positive)
            .make_optional("none: no dispersion"),
        field_schema("glass", FieldKind::Name, "instead of `indexOfRefraction`: a glass by name"),
        field_schema(
            "cauchy",
            FieldKind::NumberList,
            "instead of `indexOfRefraction`: Cauchy's equation; C is optional",
        )
        .with_range(FieldRange::DescribedOnly("A, B \\[µm²], C \\[µm⁴]")),
        field_schema("sellmeierB", FieldKind::NumberList, "instead of `indexOfRefraction`: Sellmeier's equation")
            .with_range(FieldRange::DescribedOnly("1 to 4")),
        field_schema("sellmeierC", FieldKind::NumberList, "squared resonance wavelengths for `sellmeierB`")
            .with_range(FieldRange::DescribedOnly("1 to 4"))
            .with_unit("µm²"),
        field_schema("absorption", FieldKind::Color, "absorption coefficient of the inside")
            .with_range(COEFFICIENT_RANGE)
            .make_optional("0 0 0")
            .with_unit("1/length"),
        field_schema("tint", FieldKind::Color, "instead of `absorption`: transmittance over `tintDistance`")
            .with_range(TRANSMITTANCE_RANGE),
        field_schema("tintDistance", FieldKind::Number, "distance of `tint`; the absorption is at most 1e12")
            .with_range(FieldRange::Positive)
            .with_default_numbers(&[1.0])
            .with_unit("length"),
        ROUGHNESS_FIELD,
        MULTIPLE_SCATTERING_FIELD,
        PRIORITY_FIELD,
        field_schema("medium", FieldKind::Name, "medium that fills the body").make_optional("none"),
    ])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);

impl MaterialBlock for DielectricDescription {
    const BLOCK: &'static BlockSchema = &DIELECTRIC;
    const BODY: BoundedBody = BoundedBody::Dielectric;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self {
            refraction: parse_refraction(f)?,
            absorption: parse_dielectric_absorption(f)?,
            roughness: f.value_or_default("roughness")?,
            has_multiple_scattering: f.field_word_or_default("multipleScattering")? == "yes",
            priority: f.value_or_default::<u32>("priority")? as u8,
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        write_refraction(out, &self.refraction)?;
        write_dielectric_absorption(out, self.absorption)?;
        out.write_number_or_texture("roughness", &self.roughness)?;
        write_multiple_scattering(out, self.has_multiple_scattering)?;
        out.write_field("priority", self.priority)
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let roughness = r.resolve_fraction_parameter(&self.roughness, requirements)?;
        let (index, glass) = resolve_refractive_index(r, &self.refraction)?;
        let absorption = rgb(self.absorption.absorption_coefficient());
        let body = Body { absorption, priority: self.priority, glass, ..Body::new(index) };
        Ok(with_multiple_scattering(Material::rough_boundary(body, roughness), self.has_multiple_scattering))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.roughness.texture_name().into_iter().collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}
