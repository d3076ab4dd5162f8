//! The block `Principled` of the scene language: the metallic-roughness model.

use super::fields::{MULTIPLE_SCATTERING_FIELD, ROUGHNESS_FIELD, UNIT_RANGE, with_multiple_scattering};
use super::{EnclosedBody, MaterialBlock};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::materials::absorption::{ABSORPTION, DielectricAbsorption};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::resolve::{Resolver, rgb};
use crate::format::textured_value::TexturedValue;
use crate::scene::{Body, ConductorIndex, Material, MaterialParameter};
use glam::DVec3;

/// A surface of the metallic-roughness model: a mix of metal, glass and a coated diffuse base.
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipledDescription {
    /// Color of the surface, inside \[0, 1]: reflectance of the diffuse base, and reflectance of
    /// the metal at normal incidence.
    pub base_color: TexturedValue<DVec3>,
    /// Fraction of the surface that is metal, inside \[0, 1].
    pub metallic: TexturedValue<f64>,
    /// GGX α of metal, glass and coat, inside \[0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// Index of refraction, inside \[1, 4]. The coat of the diffuse base has this index relative to
    /// the surroundings; the glass has it as its absolute index.
    pub eta: f64,
    /// Fraction of the non-metal part that is glass, inside \[0, 1].
    pub transmission: TexturedValue<f64>,
    /// Absorption inside the body of glass.
    pub absorption: DielectricAbsorption,
    /// Fraction of metal and coated base that a clear coat of index 1.5 covers, inside \[0, 1].
    pub clearcoat: TexturedValue<f64>,
    /// GGX α of the clear coat, inside \[0, 1]; 0 is smooth.
    pub clearcoat_roughness: f64,
    /// True if metal and glass include light that several microfacets scatter in turn; false if
    /// this light is lost.
    pub has_multiple_scattering: bool,
}

impl PrincipledDescription {
    /// True if a component of the mix is glass, so that the surface bounds a dielectric body.
    pub(super) fn transmits(&self) -> bool {
        self.transmission != TexturedValue::Constant(0.0) && self.metallic != TexturedValue::Constant(1.0)
    }
}

field_table!(PrincipledDescription {
    base_color: field_schema("baseColor", FieldKind::ColorOrTexture, "albedo of the base; reflectance of the metal")
        .with_range(UNIT_RANGE)
        .make_required(),
    metallic: field_schema("metallic", FieldKind::NumberOrTexture, "share of metal")
        .with_range(UNIT_RANGE)
        .with_default_numbers(&[0.0]),
    roughness: ROUGHNESS_FIELD,
    eta: field_schema(
        "indexOfRefraction",
        FieldKind::Number,
        "index of the coat relative to the surroundings, and absolute index of the glass"
    )
    .with_range(FieldRange::ClosedInterval(1.0, MAX_COAT_INDEX as f64))
    .with_default_numbers(&[1.5]),
    transmission: field_schema(
        "transmission",
        FieldKind::NumberOrTexture,
        "share of glass in the part that is no metal",
    )
    .with_range(UNIT_RANGE)
    .with_default_numbers(&[0.0]),
    absorption: ABSORPTION,
    clearcoat: field_schema(
        "clearcoat",
        FieldKind::NumberOrTexture,
        "share under a clear coat of index 1.5; not for glass",
    )
    .with_range(UNIT_RANGE)
    .with_default_numbers(&[0.0]),
    clearcoat_roughness: field_schema("clearcoatRoughness", FieldKind::Number, "GGX α of the clear coat")
        .with_range(UNIT_RANGE)
        .with_default_numbers(&[0.0]),
    has_multiple_scattering: MULTIPLE_SCATTERING_FIELD,
});

impl MaterialBlock for PrincipledDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("Principled", "mix of metal, glass and a coated diffuse base, as in glTF and Blender")
            .with_table(Self::FIELDS)
            .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let base_color = r.resolve_reflectance_parameter(&self.base_color, requirements)?;
        let mut fraction = |value| r.resolve_fraction_parameter(value, requirements);
        let (metallic, roughness) = (fraction(&self.metallic)?, fraction(&self.roughness)?);
        let (transmission, clearcoat) = (fraction(&self.transmission)?, fraction(&self.clearcoat)?);
        let (eta, clearcoat_alpha) = (self.eta as f32, self.clearcoat_roughness as f32);
        let under_clear_coat = |material: Material| match clearcoat {
            MaterialParameter::Constant(0.0) => material,
            _ => material.with_clear_coat(clearcoat, clearcoat_alpha),
        };
        let with_scattering = |material| with_multiple_scattering(material, self.has_multiple_scattering);
        let coated = under_clear_coat(Material::coated_diffuse(base_color, eta, roughness, false));
        let absorption = rgb(self.absorption.absorption_coefficient());
        let glass = with_scattering(Material::rough_boundary(Body { absorption, ..Body::new(eta) }, roughness));
        let metal = Material::conductor_of_index(ConductorIndex::OfReflectance(base_color), roughness);
        let metal = under_clear_coat(with_scattering(metal));
        let dielectric = r.material_parts.mix(coated, glass, transmission);
        Ok(r.material_parts.mix(dielectric, metal, metallic))
    }
}
