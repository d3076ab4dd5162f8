//! Conversion of one glTF material: its textures as parameters, parts of its mixes, and messages.

use super::GltfMaterials;
use crate::format::description::{MaterialKindDescription, NormalPerturbationDescription, TexturedValue};
use crate::format::gltf::context::{FileContext, ReadResult};
use crate::format::gltf::textures::{GltfConvertedTexture, GltfTextureUse, TextureReference};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_materials::mix_of;
use glam::DVec3;

/// Conversion of one glTF material, with the tables that receive its materials and messages.
pub(super) struct GltfMaterialConversion<'m, 'a> {
    /// Materials of the imported scene so far. The conversion adds its results here.
    pub materials: &'m mut GltfMaterials<'a>,
    /// Messages about content that is ignored or approximated.
    pub notes: &'m mut ImportNotes,
    /// The glTF file that is imported, for error messages.
    pub context: &'m FileContext<'a>,
    /// Name of the material in the imported scene, also for messages.
    pub name: String,
    /// Index of the texture coordinates that the material's first texture uses (`TEXCOORD_0`, …);
    /// `None` as long as no texture has been converted.
    pub texcoord_set: Option<u32>,
    /// Normal map of the material; `None` without one.
    pub normal: Option<NormalPerturbationDescription>,
}

impl GltfMaterialConversion<'_, '_> {
    /// Converts the normal map of a material; `None` without one, or if all its pixels are equal.
    pub(super) fn normal_map(
        &mut self,
        material: &gltf::Material<'_>,
    ) -> ReadResult<Option<NormalPerturbationDescription>> {
        let Some(normal) = material.normal_texture() else { return Ok(None) };
        let reference = self.with_valid_transform(TextureReference::from_normal_texture(&normal));
        let scale = f64::from(normal.scale());
        let values = self
            .convert_texture(reference.as_ref(), GltfTextureUse::Normal(if scale.is_finite() { scale } else { 1.0 }))?;
        Ok(match values {
            Some(GltfConvertedTexture::Texture(name, _)) => Some(NormalPerturbationDescription::NormalMap(name)),
            Some(GltfConvertedTexture::Constant(_)) | None => None,
        })
    }

    /// Returns the texture that `info` refers to, with its texture coordinates.
    ///
    /// `None` if `info` is `None`. A texture whose transform is not invertible also gives `None`,
    /// and a message tells the user.
    pub(super) fn texture_reference<'t>(
        &mut self,
        info: Option<&gltf::texture::Info<'t>>,
    ) -> Option<TextureReference<'t>> {
        self.with_valid_transform(TextureReference::from_info(info?))
    }

    /// Returns `reference`. Returns `None` if its texture transform is not invertible, and a
    /// message tells the user.
    pub(super) fn with_valid_transform<'t>(&mut self, reference: TextureReference<'t>) -> Option<TextureReference<'t>> {
        if reference.has_valid_transform() {
            return Some(reference);
        }
        self.add_note("textures that are scaled to nothing are left out");
        None
    }

    /// Returns the color of a surface: `factor` times the texture, if there is one.
    pub(super) fn textured_color(
        &mut self,
        texture: Option<&TextureReference<'_>>,
        factor: DVec3,
    ) -> ReadResult<TexturedValue<DVec3>> {
        Ok(match self.convert_texture(texture, GltfTextureUse::Color(factor))? {
            Some(GltfConvertedTexture::Constant(color)) => TexturedValue::Constant(color),
            Some(GltfConvertedTexture::Texture(name, _)) => TexturedValue::Texture(name),
            None => TexturedValue::Constant(factor),
        })
    }

    /// Returns a number parameter in \[0, 1], as a constant or a texture, and its mean over all
    /// pixels.
    ///
    /// `texture_use` states the parameter: it selects the channel of `texture`, and holds the
    /// parameter's factor in the file. Without a texture, the channel counts as 1.
    pub(super) fn textured_scalar_and_mean(
        &mut self,
        texture: Option<&TextureReference<'_>>,
        texture_use: GltfTextureUse,
    ) -> ReadResult<(TexturedValue<f64>, f64)> {
        let value_without_texture = match texture_use {
            GltfTextureUse::Channel(_, factor) => factor,
            GltfTextureUse::GgxAlpha(factor) => factor * factor,
            GltfTextureUse::AlphaMask(factor, cutoff) => f64::from(factor >= cutoff),
            GltfTextureUse::Color(_) | GltfTextureUse::Normal(_) => 1.0,
        };
        Ok(match self.convert_texture(texture, texture_use)? {
            Some(GltfConvertedTexture::Constant(value)) => (TexturedValue::Constant(value.x), value.x),
            Some(GltfConvertedTexture::Texture(name, mean)) => (TexturedValue::Texture(name), mean.x),
            None => (TexturedValue::Constant(value_without_texture), value_without_texture),
        })
    }

    /// Converts the pixels of `texture` for the parameter `texture_use`, such as a color. Returns
    /// `None` if there is no texture, or if its picture has an unsupported format.
    ///
    /// All textures of a material share one set of texture coordinates, the set of the first
    /// texture. A later texture with another set becomes a constant: the mean of its pixels.
    fn convert_texture(
        &mut self,
        texture: Option<&TextureReference<'_>>,
        texture_use: GltfTextureUse,
    ) -> ReadResult<Option<GltfConvertedTexture>> {
        let Some(texture) = texture else { return Ok(None) };
        let values = self.materials.textures.convert_texture(texture, texture_use, self.notes)?;
        if let Some(GltfConvertedTexture::Texture(..)) = &values {
            let texcoord_set = *self.texcoord_set.get_or_insert(texture.texcoord_set);
            if texcoord_set != texture.texcoord_set {
                self.add_note("textures with other texture coordinates than the first one become their mean");
                return Ok(values.map(|values| GltfConvertedTexture::Constant(values.mean())));
            }
        }
        Ok(values)
    }

    /// Adds one of the two materials of a mix to the imported scene, and returns its name.
    ///
    /// The name of the added material is the name of the mix, followed by `suffix`.
    pub(super) fn add_mix_component(&mut self, suffix: &str, kind: MaterialKindDescription) -> String {
        let name = self.materials.list.unique_name(&format!("{} {suffix}", self.name));
        let normal = if kind.mix_material_names().is_none() { self.normal.clone() } else { None };
        self.materials.list.push_surface(name.clone(), kind, normal);
        name
    }

    /// Adds two materials to the imported scene, each given by a suffix for its name and its kind.
    /// Returns a mix of both, in which `amount` is the weight of the second one.
    pub(super) fn mix_components(
        &mut self,
        [first, second]: [(&str, MaterialKindDescription); 2],
        amount: TexturedValue<f64>,
    ) -> MaterialKindDescription {
        let first = self.add_mix_component(first.0, first.1);
        let second = self.add_mix_component(second.0, second.1);
        mix_of(first, second, amount)
    }

    pub(super) fn add_note(&mut self, message: &str) {
        self.notes.add_unsupported(message, format!("material `{}`", self.name));
    }
}

/// Returns `factor` clamped to \[0, 1]; 0 for NaN.
pub(super) fn clamped_to_unit(factor: f32) -> f64 {
    if factor.is_nan() { 0.0 } else { f64::from(factor).clamp(0.0, 1.0) }
}
