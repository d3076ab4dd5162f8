//! The block `Conductor`.

use super::fields::{MULTIPLE_SCATTERING_FIELD, ROUGHNESS_FIELD, with_multiple_scattering};
use super::{BoundedBody, MaterialBlock};
use crate::bsdf::{METAL_NAMES, metal_refractive_index};
use crate::color::Rgb;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldGroup, field_table};
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldList, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::materials::refraction::{MAX_REFRACTIVE_INDEX, MIN_REFRACTIVE_INDEX};
use crate::format::resolve::textures::TextureRequirements;
use crate::format::resolve::{Resolver, rgb};
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;
use std::fmt;

/// An opaque conductor.
#[derive(Clone, Debug, PartialEq)]
pub struct ConductorDescription {
    /// Complex index of refraction.
    pub metal: MetalDescription,
    /// GGX α, inside [0, 1]; 0 is smooth.
    pub roughness: TexturedValue<f64>,
    /// False if light that several microfacets scatter is lost, as in pbrt-v4 and Mitsuba 3.
    pub has_multiple_scattering: bool,
}

/// Complex index of refraction of a conductor: that of a named metal, or given numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum MetalDescription {
    /// Name of a metal with a known complex index.
    Named(Spanned<String>),
    /// Index η + ik, relative to the surroundings.
    Index {
        /// Real part η of the complex index of refraction, above 0.
        eta: DVec3,
        /// Imaginary part k of the complex index of refraction, at least 0.
        k: DVec3,
    },
}

impl MetalDescription {
    /// Returns the conductor index η + ik, with each component clamped to the range that materials
    /// accept.
    #[must_use]
    pub fn with_clamped_index(eta: DVec3, k: DVec3) -> Self {
        let [least, greatest] = [MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX].map(DVec3::splat);
        Self::Index { eta: eta.clamp(least, greatest), k: k.clamp(DVec3::ZERO, greatest) }
    }
}

field_table!(ConductorDescription {
    metal: METAL,
    roughness: ROUGHNESS_FIELD,
    has_multiple_scattering: MULTIPLE_SCATTERING_FIELD,
});

/// Fields that state the complex refractive index of a conductor.
const METAL: FieldGroup<MetalDescription> = FieldGroup {
    fields: FieldList::own(&[
        field_schema("metal", FieldKind::Name, "a metal by name; give this, or `eta` and `k`"),
        field_schema("eta", FieldKind::Color, "η of the complex index η + ik for red, green and blue")
            .with_range(FieldRange::ClosedInterval(MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX)),
        field_schema("k", FieldKind::Color, "k of the complex index")
            .with_range(FieldRange::ClosedInterval(0.0, MAX_REFRACTIVE_INDEX)),
    ]),
    parse: parse_metal,
    write: write_metal,
};

impl MaterialBlock for ConductorDescription {
    const BLOCK: &'static BlockSchema = &block_schema("Conductor", "metal; opaque, reflects on both sides")
        .with_table(Self::FIELDS)
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS]);
    const BODY: BoundedBody = BoundedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let (eta, k) = complex_refractive_index(r, &self.metal)?;
        let metal = Material::conductor(eta, k, r.resolve_fraction_parameter(&self.roughness, requirements)?);
        Ok(with_multiple_scattering(metal, self.has_multiple_scattering))
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        None
    }
}

/// Parses the complex refractive index of a conductor, or the name of its metal.
fn parse_metal(f: &BlockFields<'_>) -> Result<MetalDescription, SceneError> {
    for index in ["eta", "k"] {
        f.forbid_both_fields("metal", index)?;
    }
    if let Some(name) = f.optional_value("metal") {
        return Ok(MetalDescription::Named(name));
    }
    if f.get("k").is_none() {
        // If both `metal` and `eta` are absent, this error names both.
        f.require_one_field_of(&["metal", "eta"])?;
    }
    Ok(MetalDescription::Index { eta: f.value_or_default("eta")?, k: f.value_or_default("k")? })
}

/// Writes the fields that state the complex index.
fn write_metal(metal: &MetalDescription, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
    match metal {
        MetalDescription::Named(name) => out.write_name_field("metal", name),
        MetalDescription::Index { eta, k } => {
            out.write_vec3("eta", *eta)?;
            out.write_vec3("k", *k)
        }
    }
}

/// Returns η and k of a metal's complex refractive index η + ik, for red, green and blue.
fn complex_refractive_index(r: &Resolver<'_>, described: &MetalDescription) -> Result<(Rgb, Rgb), SceneError> {
    match described {
        MetalDescription::Index { eta, k } => Ok((rgb(*eta), rgb(*k))),
        MetalDescription::Named(name) => metal_refractive_index(name).ok_or_else(|| {
            let message = format!("no metal is called `{}`", name.value);
            let help = format!("known are {}; of others, give `eta` and `k`", METAL_NAMES.join(", "));
            SceneError::error_at_span(r.source, name.span, message, "unknown name", help)
        }),
    }
}
