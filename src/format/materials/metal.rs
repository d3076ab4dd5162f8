//! Refractive index or reflectance of a `Conductor`: description, fields, reading, writing and
//! conversion.

use super::refraction::{MAX_REFRACTIVE_INDEX, MIN_REFRACTIVE_INDEX};
use crate::bsdf::{METAL_NAMES, metal_refractive_index};
use crate::format::error::SceneError;
use crate::format::language::field_table::FieldGroup;
use crate::format::language::field_value::FieldValue;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldList, FieldRange, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::resolve::{Resolver, rgb};
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::ConductorIndex;
use glam::DVec3;
use std::fmt;

/// Optical constants of a conductor. The scene states the name of a metal, the complex index η +
/// ik, or the reflectance at normal incidence.
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
    /// Reflectance at normal incidence, inside \[0, 1].
    Reflectance(TexturedValue<DVec3>),
}

impl MetalDescription {
    /// Returns a conductor with the complex index η + ik. Each component of η and k is clamped to
    /// the range that materials accept.
    #[must_use]
    pub fn with_clamped_index(eta: DVec3, k: DVec3) -> Self {
        let [least, greatest] = [MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX].map(DVec3::splat);
        Self::Index { eta: eta.clamp(least, greatest), k: k.clamp(DVec3::ZERO, greatest) }
    }

    /// Returns the conductor with the `reflectance` at normal incidence. A constant reflectance is
    /// clamped to \[0, 1].
    #[must_use]
    pub fn with_clamped_reflectance(reflectance: impl Into<TexturedValue<DVec3>>) -> Self {
        Self::Reflectance(match reflectance.into() {
            TexturedValue::Constant(color) => color.clamp(DVec3::ZERO, DVec3::ONE).into(),
            texture @ TexturedValue::Texture(_) => texture,
        })
    }

    /// Returns the name of the texture of the reflectance; `None` if no texture is used.
    pub(super) fn texture_name(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Named(_) | Self::Index { .. } => None,
            Self::Reflectance(reflectance) => reflectance.texture_name(),
        }
    }
}

/// Fields that state the complex refractive index of a conductor, or its reflectance.
pub(super) const METAL: FieldGroup<MetalDescription> = FieldGroup {
    list: FieldList::own(&[
        field_schema("metal", FieldKind::Name, "a metal by name; give this, `eta` and `k`, or `reflectance`"),
        field_schema("eta", FieldKind::Color, "η of the complex index η + ik for red, green and blue")
            .with_range(FieldRange::ClosedInterval(MIN_REFRACTIVE_INDEX, MAX_REFRACTIVE_INDEX)),
        field_schema("k", FieldKind::Color, "k of the complex index")
            .with_range(FieldRange::ClosedInterval(0.0, MAX_REFRACTIVE_INDEX)),
        field_schema(
            "reflectance",
            FieldKind::ColorOrTexture,
            "reflectance at normal incidence; above 0.9999 counts as 0.9999",
        )
        .with_range(FieldRange::ClosedInterval(0.0, 1.0)),
    ]),
    parse: parse_metal,
    write: write_metal,
    texture_name: MetalDescription::texture_name,
};

/// Parses the complex refractive index of a conductor, the name of its metal, or its reflectance.
fn parse_metal(f: &BlockFields<'_>) -> Result<MetalDescription, SceneError> {
    for index in ["eta", "k"] {
        f.forbid_both_fields("metal", index)?;
        f.forbid_both_fields("reflectance", index)?;
    }
    f.forbid_both_fields("metal", "reflectance")?;
    if let Some(reflectance) = f.get("reflectance") {
        return Ok(MetalDescription::Reflectance(reflectance.value()));
    }
    if let Some(name) = f.optional_value("metal") {
        return Ok(MetalDescription::Named(name));
    }
    if f.get("k").is_none() {
        // If `eta` is absent too, this error lists the alternatives `metal`, `eta` and
        // `reflectance`.
        f.require_one_field_of(&["metal", "eta", "reflectance"])?;
    }
    Ok(MetalDescription::Index { eta: f.value_or_default("eta")?, k: f.value_or_default("k")? })
}

/// Writes the metal as one of three forms: its name, its reflectance, or the numbers η and k.
fn write_metal(metal: &MetalDescription, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
    match metal {
        MetalDescription::Named(name) => out.write_name_field("metal", name),
        MetalDescription::Index { eta, k } => {
            out.write_vec3("eta", *eta)?;
            out.write_vec3("k", *k)
        }
        MetalDescription::Reflectance(reflectance) => reflectance.write(out, "reflectance"),
    }
}

/// Returns the complex refractive index of a metal, or its reflectance at normal incidence.
///
/// If a texture gives the reflectance, records in `requirements` that it is used, and whether it
/// needs texture coordinates.
pub(super) fn resolve_metal(
    r: &Resolver<'_>,
    described: &MetalDescription,
    requirements: &mut TextureRequirements,
) -> Result<ConductorIndex, SceneError> {
    match described {
        MetalDescription::Index { eta, k } => Ok(ConductorIndex::Complex { eta: rgb(*eta), k: rgb(*k) }),
        MetalDescription::Reflectance(reflectance) => {
            Ok(ConductorIndex::OfReflectance(r.resolve_reflectance_parameter(reflectance, requirements)?))
        }
        MetalDescription::Named(name) => {
            metal_refractive_index(name).map(|(eta, k)| ConductorIndex::Complex { eta, k }).ok_or_else(|| {
                let message = format!("no metal is called `{}`", name.value);
                let help =
                    format!("known are {}; of others, give `eta` and `k`, or `reflectance`", METAL_NAMES.join(", "));
                SceneError::error_at_span(r.source, name.span, message, "unknown name", help)
            })
        }
    }
}
