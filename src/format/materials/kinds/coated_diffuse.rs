//! The block `CoatedDiffuse` of the scene language: a diffuse base under a dielectric coat.

use super::fields::{ROUGHNESS_FIELD, UNIT_RANGE};
use super::{EnclosedBody, MaterialBlock};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;

/// A diffuse base under a dielectric coat, such as plastic.
#[derive(Clone, Debug, PartialEq)]
pub struct CoatedDiffuseDescription {
    /// Reflectance of the base, inside \[0, 1].
    pub reflectance: TexturedValue<DVec3>,
    /// Index of refraction of the coat relative to the surroundings, inside \[1, 4].
    pub eta: f64,
    /// GGX α of the coat, inside \[0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// True if colors become deeper, as with `nonlinear` of Mitsuba's `plastic`. Light that is
    /// reflected between coat and base then takes on the base's color repeatedly.
    pub is_nonlinear: bool,
}

field_table!(CoatedDiffuseDescription {
    reflectance: field_schema("reflectance", FieldKind::ColorOrTexture, "albedo of the base")
        .with_range(UNIT_RANGE)
        .make_required(),
    eta: field_schema("indexOfRefraction", FieldKind::Number, "index of the coat relative to the surroundings")
        .with_range(FieldRange::ClosedInterval(1.0, MAX_COAT_INDEX as f64))
        .with_default_numbers(&[1.5]),
    roughness: ROUGHNESS_FIELD,
    is_nonlinear: field_schema(
        "nonlinear",
        FieldKind::Word(&["yes", "no"]),
        "`no`: light between coat and base does not make colors deeper",
    )
    .with_default_word("yes"),
});

impl MaterialBlock for CoatedDiffuseDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("CoatedDiffuse", "diffuse base under a dielectric coat: plastic, varnish, glaze")
            .with_table(Self::FIELDS)
            .with_aliases(&["Plastic"])
            .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let reflectance = r.resolve_reflectance_parameter(&self.reflectance, requirements)?;
        let roughness = r.resolve_fraction_parameter(&self.roughness, requirements)?;
        Ok(Material::coated_diffuse(reflectance, self.eta as f32, roughness, self.is_nonlinear))
    }
}
