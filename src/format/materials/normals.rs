//! Bump maps and normal maps of materials: description, fields, reading, writing and conversion.

use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{FieldKind, FieldRange, FieldSchema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::span::Spanned;
use crate::image::PixelMeaning;
use crate::scene::NormalPerturbation;
use std::fmt;

/// Perturbation of shading normals by the values of a texture: a bump map or a normal map.
///
/// Both kinds of maps refer to the texture by its name. A name that no texture has is taken as the
/// path of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum NormalPerturbationDescription {
    /// Bump map (Blinn 1978): heights by which the surface is displaced along its normal for
    /// shading.
    Bump {
        /// Name of the texture that holds the heights, or path of a picture.
        texture: Spanned<String>,
        /// Height of texture value 1 in world units; may be negative.
        height: f64,
    },
    /// Tangent-space normal map: name of a texture, or path of a picture.
    NormalMap(Spanned<String>),
}

/// Fields for the bump map or normal map of a material.
pub(super) const NORMAL_PERTURBATION_FIELDS: &[FieldSchema] = &[
    field_schema("bump", FieldKind::Name, "texture or picture of heights; not for `Clear`").make_optional("none"),
    field_schema("bumpHeight", FieldKind::Number, "height of the value 1 of `bump`, required with it")
        .with_range(FieldRange::SinglePrecision)
        .with_unit("length"),
    field_schema("normalMap", FieldKind::Name, "instead of `bump`: texture or picture of normals")
        .make_optional("none"),
];

impl NormalPerturbationDescription {
    /// Parses the fields of a bump map or a normal map. Returns `None` if the block has no such
    /// fields.
    pub(super) fn parse(f: &BlockFields<'_>) -> Result<Option<Self>, SceneError> {
        f.forbid_both_fields("bump", "normalMap")?;
        let Some(texture) = f.optional_value("bump") else {
            f.forbid_fields(&["bumpHeight"], "has no effect without `bump`")?;
            return Ok(f.optional_value("normalMap").map(Self::NormalMap));
        };
        Ok(Some(Self::Bump { texture, height: f.value_or_default("bumpHeight")? }))
    }

    /// Writes the fields of the bump map or normal map.
    pub(super) fn write(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        match self {
            Self::Bump { texture, height } => {
                out.write_name_field("bump", texture)?;
                out.write_number("bumpHeight", *height)
            }
            Self::NormalMap(texture) => out.write_name_field("normalMap", texture),
        }
    }

    /// Returns the name of the texture, or the path of the picture.
    pub(super) fn texture_name_or_path(&self) -> &Spanned<String> {
        match self {
            Self::Bump { texture, .. } | Self::NormalMap(texture) => texture,
        }
    }

    /// Returns the name of the texture, or the path of the picture.
    pub(super) fn ambiguous_texture_reference_mut(&mut self) -> &mut Spanned<String> {
        match self {
            Self::Bump { texture, .. } | Self::NormalMap(texture) => texture,
        }
    }

    /// Returns the bump map or normal map with its texture looked up. A bump map of height 0 gives
    /// no perturbation.
    ///
    /// Adds to `requirements` the surface properties that the texture needs.
    pub(super) fn resolve(
        &self,
        r: &mut Resolver<'_>,
        requirements: &mut TextureRequirements,
    ) -> Result<NormalPerturbation, SceneError> {
        Ok(match self {
            Self::Bump { texture, height } => {
                let texture = r.texture_or_picture(texture, PixelMeaning::NonColor)?;
                if *height == 0.0 {
                    return Ok(NormalPerturbation::None);
                }
                requirements.add_texture_requirements(&texture);
                NormalPerturbation::BumpMap { texture: texture.index, height: *height as f32 }
            }
            Self::NormalMap(name) => {
                let texture = r.texture_or_picture(name, PixelMeaning::NonColor)?;
                if texture.is_srgb {
                    let message = format!("the texture `{}` is read as a picture of light", name.value);
                    let help = "give it `encoding linear`: normals are numbers";
                    return Err(SceneError::error_at_span(r.source, name.span, message, "no normals", help));
                }
                // Even if the texture is solid, a normal map needs texture coordinates: its
                // tangents follow from them.
                *requirements = TextureRequirements { uses_textures: true, needs_texcoords: true };
                NormalPerturbation::NormalMap(texture.index)
            }
        })
    }
}
