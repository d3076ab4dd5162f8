//! The block `PhongMaterial`.

use super::{BoundedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::fields::BlockFields;
use crate::format::language::parser::Parser;
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::NON_NEGATIVE_TEXTURE_RANGE;
use crate::format::resolve::textures::TextureRequirements;
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;
use std::fmt;

/// The Phong model of MIT course 6.837.
#[derive(Clone, Debug, PartialEq)]
pub struct PhongDescription {
    /// Diffuse color kd.
    pub diffuse: TexturedValue<DVec3>,
    /// Specular color ks.
    pub specular: TexturedValue<DVec3>,
    /// Phong exponent, at least 0.
    pub shininess: f64,
    /// Name of a texture that multiplies kd. If no texture has the name, it is the path of a
    /// picture.
    pub texture: Option<Spanned<String>>,
}

static PHONG: BlockSchema = block_schema("PhongMaterial", "Phong's reflection model")
    .with_fields(&[
        field_schema("diffuseColor", FieldKind::ColorOrTexture, "diffuse reflectance kd")
            .with_default_numbers(&[1.0, 1.0, 1.0])
            .mark_as_mit_6837_syntax(),
        field_schema("specularColor", FieldKind::ColorOrTexture, "specular coefficient ks")
            .with_default_numbers(&[0.0, 0.0, 0.0])
            .mark_as_mit_6837_syntax(),
        field_schema("shininess", FieldKind::Number, "Phong exponent")
            .with_range(FieldRange::NonNegative)
            .with_default_numbers(&[0.0])
            .mark_as_mit_6837_syntax(),
        field_schema("texture", FieldKind::Name, "texture or picture that `diffuseColor` is multiplied by")
            .make_optional("none")
            .mark_as_mit_6837_syntax(),
    ])
    .with_aliases(&["Material", "Phong"])
    .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS])
    .mark_as_mit_6837_syntax();

impl MaterialBlock for PhongDescription {
    const BLOCK: &'static BlockSchema = &PHONG;
    const BODY: BoundedBody = BoundedBody::None;

    fn parse<'a>(_: &Parser<'a>, f: &BlockFields<'a>) -> Result<Self, SceneError> {
        Ok(Self {
            diffuse: f.value_or_default("diffuseColor")?,
            specular: f.value_or_default("specularColor")?,
            shininess: f.value_or_default("shininess")?,
            texture: f.optional_value("texture"),
        })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        out.write_color_or_texture("diffuseColor", &self.diffuse)?;
        out.write_color_or_texture("specularColor", &self.specular)?;
        out.write_number("shininess", self.shininess)?;
        self.texture.as_ref().map_or(Ok(()), |name| out.write_name_field("texture", name))
    }

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let diffuse = r.resolve_phong_diffuse_parameter(&self.diffuse, self.texture.as_ref(), requirements)?;
        let specular = r.resolve_color_parameter(&self.specular, &NON_NEGATIVE_TEXTURE_RANGE, requirements)?;
        Ok(Material::phong(diffuse, specular, self.shininess as f32))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        [self.diffuse.texture_name(), self.specular.texture_name(), self.texture.as_ref()]
            .into_iter()
            .flatten()
            .collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        self.texture.as_mut()
    }
}
