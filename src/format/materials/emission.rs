//! Emission of a material: description, fields, reading, writing and conversion.

use crate::color::Rgb;
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldRange, FieldSchema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::textures::{NON_NEGATIVE_TEXTURE_RANGE, TextureRequirements};
use crate::format::resolve::{MaterialEmission, Resolver, rgb};
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use glam::DVec3;
use std::fmt;

/// Emitted radiance of a material: constant, or varied by a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum EmissionDescription {
    /// Constant radiance in W/(m² sr).
    Constant(DVec3),
    /// Radiance given by the values of a texture.
    Texture {
        /// Name of the texture.
        name: Spanned<String>,
        /// Factor from texture values to radiance in W/(m² sr), at least 0.
        scale: f64,
    },
}

/// Fields for the emission of a material.
pub(super) const EMISSION_FIELDS: &[FieldSchema] = &[
    field_schema("emission", FieldKind::ColorOrTexture, "emitted radiance; not for `Clear`")
        .make_optional("0 0 0")
        .with_unit("W/(m² sr)"),
    field_schema("emissionScale", FieldKind::Number, "with a texture as `emission`: factor of its values")
        .with_range(FieldRange::NonNegative)
        .with_default_numbers(&[1.0]),
];

impl EmissionDescription {
    /// Parses the emission; `None` if the block has none.
    pub(super) fn parse(f: &BlockFields<'_>) -> Result<Option<Self>, SceneError> {
        let radiance = match f.optional_value("emission") {
            Some(TexturedValue::Texture(name)) => {
                return Ok(Some(Self::Texture { name, scale: f.value_or_default("emissionScale")? }));
            }
            Some(TexturedValue::Constant(radiance)) => Some(Self::Constant(radiance)),
            None => None,
        };
        f.forbid_fields(&["emissionScale"], "has no effect without a texture as `emission`")?;
        Ok(radiance)
    }

    /// Writes the fields of the emission.
    pub(super) fn write(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        match self {
            Self::Constant(radiance) => out.write_vec3("emission", *radiance),
            Self::Texture { name, scale } => {
                out.write_texture_name_field("emission", name)?;
                out.write_number("emissionScale", *scale)
            }
        }
    }

    /// Returns the name of the texture that varies the emission; `None` for constant emission.
    pub(super) fn texture_name(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Constant(_) => None,
            Self::Texture { name, .. } => Some(name),
        }
    }

    /// Returns the emission with its texture looked up.
    ///
    /// Records in `requirements` that a texture is used, and whether it needs texture coordinates.
    pub(super) fn resolve(
        &self,
        r: &Resolver<'_>,
        requirements: &mut TextureRequirements,
    ) -> Result<MaterialEmission, SceneError> {
        match self {
            Self::Constant(radiance) => Ok(MaterialEmission { radiance: rgb(*radiance), texture: None }),
            Self::Texture { name, scale } => {
                let texture = r.texture_by_name(name, &NON_NEGATIVE_TEXTURE_RANGE)?;
                requirements.add_texture_requirements(&texture);
                let scale = Rgb::splat(*scale as f32);
                Ok(MaterialEmission { radiance: texture.mean * scale, texture: Some((texture.index, scale)) })
            }
        }
    }
}
