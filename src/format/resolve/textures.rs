//! Adds textures to the scene, and resolves textured material parameters.

use super::{Resolver, rgb};
use crate::color::{self, Rgb};
use crate::format::SceneError;
use crate::format::span::Spanned;
use crate::format::textured_value::TexturedValue;
use crate::image::{self, Image, PixelMeaning};
use crate::scene::MaterialParameter;
use crate::stats::format_bytes;
use crate::texture::{MipMap, Texture, UvTransform, WrapMode};
use glam::{DVec2, DVec3};
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// A texture that was added to the scene: its index and properties.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct AddedTexture {
    pub index: u32,
    /// Mean color of the texture.
    pub mean: Rgb,
    /// Least and greatest value of the texture, over all positions and channels.
    range: (f32, f32),
    /// True if the texture is a function of position, not of texture coordinates.
    is_solid_texture: bool,
    /// True for a picture that is read as color: its integer values are decoded as sRGB.
    pub is_srgb: bool,
}

/// Properties that a surface needs so that the textures of its material can be evaluated.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::format) struct TextureRequirements {
    /// True if the material uses any texture.
    pub uses_textures: bool,
    /// True if a texture of the material is a function of texture coordinates.
    pub needs_texcoords: bool,
}

/// Memory per pixel while an embedded picture becomes a texture \[bytes]: a copy and its mipmap.
const EMBEDDED_BYTES_PER_PIXEL: u64 = 28;

/// Allowed texture values of parameters without an upper bound, such as radiance.
pub(in crate::format) const NON_NEGATIVE_TEXTURE_RANGE: RangeInclusive<f32> = 0.0..=f32::MAX;

/// Allowed texture values of reflectance, transmittance, roughness and mix amounts.
const UNIT_RANGE: RangeInclusive<f32> = 0.0..=1.0;

impl<'a> Resolver<'a> {
    /// Adds a texture to the scene. `is_srgb` is true for a picture that was read as color.
    pub(in crate::format) fn add_texture(&mut self, texture: Texture, is_srgb: bool) -> AddedTexture {
        let (mean, range, is_solid_texture) = (texture.mean(), texture.value_range(), texture.is_solid_texture());
        AddedTexture { index: self.builder.add_texture(texture), mean, range, is_solid_texture, is_srgb }
    }

    /// Reads a picture and adds it as a texture.
    pub(in crate::format) fn add_picture_texture(
        &mut self,
        path: &Spanned<String>,
        content: PixelMeaning,
        wrap: WrapMode,
        to_picture: UvTransform,
    ) -> Result<AddedTexture, SceneError> {
        let image = self.read_picture(path, content)?;
        let mip_map = MipMap::new(&image, wrap)
            .map_err(|e| self.file_error(path, &e, "a texture's values must be finite and not negative"))?;
        Ok(self.add_texture(Texture::Image(mip_map, to_picture), content == PixelMeaning::Color))
    }

    /// Returns a copy of the embedded picture with this path. If there is none, reads the picture
    /// file.
    pub(in crate::format) fn read_picture(
        &self,
        path: &Spanned<String>,
        content: PixelMeaning,
    ) -> Result<Image, SceneError> {
        if let Some(picture) = self.assets.pictures.get(path.as_str()) {
            let needed = EMBEDDED_BYTES_PER_PIXEL * picture.pixels().len() as u64;
            if let Some(free) = self.memory.available_bytes().filter(|free| needed > *free) {
                let (needed, free) = (format_bytes(needed), format_bytes(free));
                let message = format!("a picture takes {needed} of memory, and {free} are free");
                return Err(self.file_or_memory_error(path, &message, true, ""));
            }
            return Ok((**picture).clone());
        }
        let file = self.find_file("picture", path)?;
        let help = "repair the picture or name another: PNG, OpenEXR or Radiance HDR";
        image::read_with_memory_limit(&file, content, self.memory.available_bytes())
            .map_err(|e| self.file_or_memory_error(path, &e, matches!(e, image::ReadError::Memory { .. }), help))
    }

    /// Returns the texture called `name`.
    ///
    /// # Errors
    /// If there is none, or if a value of the texture is outside `range`.
    pub(in crate::format) fn texture_by_name(
        &self,
        name: &Spanned<String>,
        range: &RangeInclusive<f32>,
    ) -> Result<AddedTexture, SceneError> {
        let texture = self.textures.get(name.as_str()).copied().ok_or_else(|| {
            let message = format!("no texture is called `{}`", name.value);
            SceneError::error_at_span(self.source, name.span, message, "unknown name", "define it in Textures first")
        })?;
        let (least, most) = texture.range;
        if range.contains(&least) && range.contains(&most) {
            return Ok(texture);
        }
        let message = format!("the texture `{}` goes from {least} to {most}", name.value);
        let help = format!("its values must lie between {} and {} here", range.start(), range.end());
        Err(SceneError::error_at_span(self.source, name.span, message, "out of range", help))
    }

    /// Returns the texture called `name`. If no texture has this name, `name` is taken as the path
    /// of a picture, and the picture becomes a texture.
    ///
    /// `content` says whether the picture holds colors or other data. A picture that is used for
    /// both becomes two textures.
    pub(in crate::format) fn texture_or_picture(
        &mut self,
        name: &Spanned<String>,
        content: PixelMeaning,
    ) -> Result<AddedTexture, SceneError> {
        if self.textures.contains_key(name.as_str()) {
            return self.texture_by_name(name, &NON_NEGATIVE_TEXTURE_RANGE);
        }
        let key: (PathBuf, bool) = (self.find_file("texture or picture", name)?, content == PixelMeaning::Color);
        if let Some(texture) = self.picture_textures.get(&key) {
            return Ok(*texture);
        }
        let unchanged = UvTransform::new(DVec2::ONE, 0.0, DVec2::ZERO);
        let texture = self.add_picture_texture(name, content, WrapMode::Repeat, unchanged)?;
        self.picture_textures.insert(key, texture);
        Ok(texture)
    }

    /// Converts a color parameter, which is constant or a texture. Texture values outside `range`
    /// are errors; a constant is not checked.
    ///
    /// For a texture, records in `requirements` that it is used, and whether it needs texture
    /// coordinates.
    pub(in crate::format) fn resolve_color_parameter(
        &self,
        value: &TexturedValue<DVec3>,
        range: &RangeInclusive<f32>,
        requirements: &mut TextureRequirements,
    ) -> Result<MaterialParameter<Rgb>, SceneError> {
        match value {
            TexturedValue::Constant(color) => Ok(MaterialParameter::Constant(rgb(*color))),
            TexturedValue::Texture(name) => {
                let texture = self.texture_by_name(name, range)?;
                requirements.add_texture_requirements(&texture);
                Ok(MaterialParameter::Texture { texture: texture.index, factor: Rgb::ONE, mean: texture.mean })
            }
        }
    }

    /// Converts a parameter in \[0, 1], which is constant or a texture. Texture values outside
    /// \[0, 1] are errors; a constant is not checked.
    pub(in crate::format) fn resolve_fraction_parameter(
        &self,
        value: &TexturedValue<f64>,
        requirements: &mut TextureRequirements,
    ) -> Result<MaterialParameter<f32>, SceneError> {
        match value {
            TexturedValue::Constant(number) => Ok(MaterialParameter::Constant(*number as f32)),
            TexturedValue::Texture(name) => {
                let texture = self.texture_by_name(name, &UNIT_RANGE)?;
                requirements.add_texture_requirements(&texture);
                Ok(MaterialParameter::Texture {
                    texture: texture.index,
                    factor: 1.0,
                    mean: color::channel_mean(texture.mean),
                })
            }
        }
    }

    /// Converts a reflectance or transmittance, which is constant or a texture. Texture values
    /// outside \[0, 1] are errors.
    pub(in crate::format) fn resolve_reflectance_parameter(
        &self,
        value: &TexturedValue<DVec3>,
        requirements: &mut TextureRequirements,
    ) -> Result<MaterialParameter<Rgb>, SceneError> {
        self.resolve_color_parameter(value, &UNIT_RANGE, requirements)
    }

    /// Returns the diffuse color of a `Phong` material: the product of `diffuse` and `texture`,
    /// which names a texture or a picture.
    ///
    /// Fails if `diffuse` is a texture too, because two textures are not multiplied.
    pub(in crate::format) fn resolve_phong_diffuse_parameter(
        &mut self,
        diffuse: &TexturedValue<DVec3>,
        texture: Option<&Spanned<String>>,
        requirements: &mut TextureRequirements,
    ) -> Result<MaterialParameter<Rgb>, SceneError> {
        let Some(name) = texture else {
            return self.resolve_color_parameter(diffuse, &NON_NEGATIVE_TEXTURE_RANGE, requirements);
        };
        let TexturedValue::Constant(factor) = diffuse else {
            let help = "give `diffuseColor` in numbers, or leave `texture` out";
            return Err(SceneError::error_at_span(
                self.source,
                name.span,
                "two textures for one colour",
                "the second",
                help,
            ));
        };
        let texture = self.texture_or_picture(name, PixelMeaning::Color)?;
        requirements.add_texture_requirements(&texture);
        let factor = rgb(*factor);
        Ok(MaterialParameter::Texture { texture: texture.index, factor, mean: factor * texture.mean })
    }

    /// Fails if the mesh at `path` lacks texture coordinates that its material needs.
    ///
    /// `file_material` is the name of a material from the mesh's MTL file; `None` for the material
    /// that the scene text sets.
    pub(in crate::format) fn require_texcoords(
        &self,
        has_texcoords: bool,
        path: &Spanned<String>,
        file_material: Option<&str>,
    ) -> Result<(), SceneError> {
        let requirements = self.current_material().map(|material| material.texture_requirements).unwrap_or_default();
        if has_texcoords || !requirements.needs_texcoords {
            return Ok(());
        }
        let name = file_material.or_else(|| self.current_material().and_then(|material| material.name.as_deref()));
        let material =
            name.map_or(format!("material {}", self.current_material_index), |name| format!("the material `{name}`"));
        let message = format!("the mesh `{}` has no texture coordinates, which {material} needs", path.value);
        let help = "export it with texture coordinates (lines `vt`), or use Noise, Marble or Wood, which need none";
        Err(self.file_error(path, &message, help))
    }
}

impl TextureRequirements {
    pub fn add_texture_requirements(&mut self, texture: &AddedTexture) {
        self.uses_textures = true;
        self.needs_texcoords |= !texture.is_solid_texture;
    }
}
