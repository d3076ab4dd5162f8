//! The block `PhongMaterial` of the scene language: the Phong model of MIT course 6.837.

use super::{EnclosedBody, MaterialBlock};
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, field_table};
use crate::format::language::schema::{BlockSchema, FieldKind, FieldRange, block_schema, field_schema};
use crate::format::materials::emission::EMISSION_FIELDS;
use crate::format::materials::normals::NORMAL_PERTURBATION_FIELDS;
use crate::format::resolve::Resolver;
use crate::format::resolve::textures::{NON_NEGATIVE_TEXTURE_RANGE, TextureRequirements};
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::scene::Material;
use glam::DVec3;

/// The Phong model of MIT course 6.837.
#[derive(Clone, Debug, PartialEq)]
pub struct PhongDescription {
    /// Diffuse reflectance kd, at least 0.
    pub diffuse: TexturedValue<DVec3>,
    /// Specular coefficient ks, at least 0.
    pub specular: TexturedValue<DVec3>,
    /// Phong exponent, at least 0.
    pub shininess: f64,
    /// Name of a texture that multiplies kd. If no texture has this name, it is the path of a
    /// picture, and the picture multiplies kd.
    pub texture: Option<Spanned<String>>,
}

/// Smallest GGX α that is converted to a Phong lobe. A smaller α is clamped to this value, because
/// its lobe would be narrower than a degree.
const MIN_PHONG_ALPHA: f64 = 0.01;

impl PhongDescription {
    /// Returns a diffuse surface with a Phong lobe of exponent `shininess`. The lobe reflects the
    /// fraction `reflectance` at normal incidence.
    pub fn with_lobe_reflectance(diffuse: TexturedValue<DVec3>, reflectance: DVec3, shininess: f64) -> Self {
        let specular = reflectance * (0.5 * (shininess + 2.0));
        Self { diffuse, specular: specular.into(), shininess, texture: None }
    }

    /// Returns a diffuse surface with a Phong lobe that approximates a GGX lobe of roughness
    /// `alpha`.
    ///
    /// The lobe reflects the fraction `reflectance` at normal incidence. Its exponent is 2/α² − 2,
    /// with α clamped to \[0.01, 1].
    pub fn in_place_of_ggx(diffuse: TexturedValue<DVec3>, reflectance: DVec3, alpha: f64) -> Self {
        let alpha = alpha.clamp(MIN_PHONG_ALPHA, 1.0);
        Self::with_lobe_reflectance(diffuse, reflectance, 2.0 / (alpha * alpha) - 2.0)
    }
}

field_table!(PhongDescription {
    diffuse: field_schema("diffuseColor", FieldKind::ColorOrTexture, "diffuse reflectance kd")
        .with_default_numbers(&[1.0, 1.0, 1.0])
        .mark_as_mit_6837_syntax(),
    specular: field_schema("specularColor", FieldKind::ColorOrTexture, "specular coefficient ks")
        .with_default_numbers(&[0.0, 0.0, 0.0])
        .mark_as_mit_6837_syntax(),
    shininess: field_schema("shininess", FieldKind::Number, "Phong exponent")
        .with_range(FieldRange::NonNegative)
        .with_default_numbers(&[0.0])
        .mark_as_mit_6837_syntax(),
    texture: field_schema("texture", FieldKind::Name, "texture or picture that `diffuseColor` is multiplied by")
        .make_optional("none")
        .mark_as_mit_6837_syntax(),
});

impl MaterialBlock for PhongDescription {
    const BLOCK: &'static BlockSchema = &block_schema("PhongMaterial", "Phong's reflection model")
        .with_table(Self::FIELDS)
        .with_aliases(&["Material", "Phong"])
        .with_shared_fields(&[NORMAL_PERTURBATION_FIELDS, EMISSION_FIELDS])
        .mark_as_mit_6837_syntax();
    const ENCLOSED_BODY: EnclosedBody = EnclosedBody::None;

    fn resolve(&self, r: &mut Resolver<'_>, requirements: &mut TextureRequirements) -> Result<Material, SceneError> {
        let diffuse = r.resolve_phong_diffuse_parameter(&self.diffuse, self.texture.as_ref(), requirements)?;
        let specular = r.resolve_color_parameter(&self.specular, &NON_NEGATIVE_TEXTURE_RANGE, requirements)?;
        Ok(Material::phong(diffuse, specular, self.shininess as f32))
    }

    fn texture_names(&self) -> Vec<&Spanned<String>> {
        self.field_textures().into_iter().chain(&self.texture).collect()
    }

    fn ambiguous_texture_reference_mut(&mut self) -> Option<&mut Spanned<String>> {
        self.texture.as_mut()
    }
}
