//! Converts textures of Mitsuba: bitmaps and checkerboards.

use super::color::ColorMeaning;
use super::context::ImportContext;
use super::files::ReadResult;
use super::meshes::TexcoordConvention;
use super::tree::{MitsubaObject, ObjectClass};
use crate::color::{Rgb, luminance};
use crate::format::SceneError;
use crate::format::description::{
    PictureEncoding, Span, Spanned, TexcoordTransformDescription, TextureDescription, TextureKindDescription, WrapMode,
};
use crate::format::import::SceneReadError;
use crate::format::imported_textures::ConvertedTexture;
use crate::image::{Image, PixelMeaning, ReadError, decode, decode_quantized_rgba};
use glam::{DMat2, DMat4, DVec2, DVec3, Vec3};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

/// Greatest nesting depth of textures.
const MAX_TEXTURE_DEPTH: u32 = 8;

/// Quantity that a texture describes. It selects the conversion of pixel values and their range.
///
/// Some quantities are numbers, not colors. A pixel then gives its luminance as the number, and a
/// constant color gives the mean of its channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum MitsubaTextureUse {
    /// Colors inside \[0, 1].
    Color,
    /// Numbers inside \[0, 1].
    Fraction,
    /// Numbers that are clamped to \[0, 1] and then squared, such as `roughness` for GGX α =
    /// `roughness`².
    SquaredFraction,
    /// Numbers of at least 0, such as heights.
    Height,
    /// RGB radiance of at least 0.
    Radiance,
    /// Tangent-space normals, stored as linear colors inside \[0, 1].
    Normal,
}

impl MitsubaTextureUse {
    /// Returns the quantity that a constant color describes where the file could also give a
    /// texture. The quantity selects how a spectrum becomes RGB.
    fn color_meaning(self) -> ColorMeaning {
        match self {
            Self::Color => ColorMeaning::Reflectance,
            Self::Radiance => ColorMeaning::Emission,
            Self::Fraction | Self::SquaredFraction | Self::Height | Self::Normal => ColorMeaning::Unbounded,
        }
    }
}

/// Textures and embedded pictures of the imported scene so far.
#[derive(Default)]
pub(super) struct MitsubaTextures {
    /// Textures of the imported scene.
    pub descriptions: Vec<Spanned<TextureDescription>>,
    /// Embedded pictures, by path.
    pub pictures: BTreeMap<String, Arc<Image>>,
    /// Decoded picture files. A key holds the path, and a flag: true for raw values, false for
    /// values decoded from sRGB.
    decoded_pictures: HashMap<(PathBuf, bool), Rc<Image>>,
    /// Results of converting picture files. A key holds the path of the file, a flag (true for raw
    /// values), the [`MitsubaTextureUse`], and the bits of the factor that multiplies the values.
    ///
    /// If a value is `ConvertedTexture::Texture`, its text is the path of an embedded
    /// picture, and not the name of a texture as elsewhere.
    converted_pictures: HashMap<(PathBuf, bool, MitsubaTextureUse, u64), ConvertedTexture>,
    /// Names of the imported textures. A key is the content of a texture as text, so equal textures
    /// become one.
    texture_names_by_content: HashMap<String, String>,
}

impl MitsubaTextures {
    /// Converts the color or texture that the parameter `name` of `object` states. A missing
    /// parameter counts as gray of value `default`.
    ///
    /// Values are multiplied by `factor`, and clamped to the range of `texture_use`, the quantity
    /// that they describe. `convention` relates the shape's texture coordinates to Mitsuba's.
    pub fn convert_texture_parameter(
        &mut self,
        context: &ImportContext<'_>,
        object: &MitsubaObject,
        (name, default): (&str, f64),
        (texture_use, convention): (MitsubaTextureUse, TexcoordConvention),
        factor: f64,
    ) -> ReadResult<ConvertedTexture> {
        if context.color_value(object, name)?.is_none()
            && let Some(texture) = context.named_child(object, ObjectClass::Texture, name)?
        {
            return self.convert_texture(context, &texture, (texture_use, convention), factor, 0);
        }
        let color = factor * context.linear_rgb(object, name, texture_use.color_meaning(), default)?;
        Ok(ConvertedTexture::Constant(clamped_to_range(color, texture_use)))
    }

    /// Converts a texture object to the quantity `texture_use`, with its values multiplied by
    /// `factor`.
    ///
    /// Values are clamped to the range of `texture_use`. A texture of unknown kind counts as gray
    /// of value 0.5, and a message tells the user. `depth` is the number of textures in which this
    /// one is nested.
    pub fn convert_texture(
        &mut self,
        context: &ImportContext<'_>,
        texture: &MitsubaObject,
        (texture_use, convention): (MitsubaTextureUse, TexcoordConvention),
        factor: f64,
        depth: u32,
    ) -> ReadResult<ConvertedTexture> {
        if depth > MAX_TEXTURE_DEPTH {
            return Err(texture.place.error("textures are nested too deep", "nest them less deep"));
        }
        if let Some(color) = context.spectrum_from_object(texture)? {
            let color = color.to_rgb(texture_use.color_meaning()).max(DVec3::ZERO) * factor;
            return Ok(ConvertedTexture::Constant(clamped_to_range(color, texture_use)));
        }
        match texture.plugin.as_str() {
            "bitmap" => self.convert_bitmap(context, texture, (texture_use, convention), factor),
            "checkerboard" => self.convert_checkerboard(context, texture, (texture_use, convention), factor, depth),
            "scale" => {
                let inner_factor = factor * scale_factor(texture);
                match context.children_of_class(texture, ObjectClass::Texture)?.first() {
                    Some((_, inner)) => {
                        self.convert_texture(context, inner, (texture_use, convention), inner_factor, depth + 1)
                    }
                    None => Ok(ConvertedTexture::Constant(clamped_to_range(DVec3::splat(inner_factor), texture_use))),
                }
            }
            _ => {
                let message = format!("textures of kind `{}` become gray of reflectance 0.5", texture.plugin);
                context.add_whole_object_note(&message, texture);
                Ok(ConvertedTexture::Constant(clamped_to_range(DVec3::splat(0.5 * factor), texture_use)))
            }
        }
    }

    /// Reads the picture file of a `bitmap` texture or emitter. Returns the file's path and the
    /// picture.
    ///
    /// Integer values are decoded as sRGB, unless `is_raw` is true.
    pub fn decode_picture_file(
        &mut self,
        context: &ImportContext<'_>,
        object: &MitsubaObject,
        is_raw: bool,
    ) -> ReadResult<(PathBuf, Rc<Image>)> {
        let Some(name) = object.text("filename") else {
            return Err(object.place.error("this picture has no file", "give it a `filename`"));
        };
        let file = context.files.find_file(name, &object.place)?;
        if let Some(image) = self.decoded_pictures.get(&(file.clone(), is_raw)) {
            return Ok((file, Rc::clone(image)));
        }
        let bytes = context.files.read_file(&file)?;
        let free = context.files.free_memory().map(|free| free.saturating_sub(bytes.len() as u64));
        let failed = |error: ReadError| {
            let help = "repair the picture or name another: PNG, JPEG, BMP, TGA, OpenEXR or Radiance HDR";
            let place = &object.place;
            let described =
                SceneError::error_at_span(&place.source, place.span, error.to_string(), "this picture", help);
            let is_memory = matches!(error, ReadError::Memory { .. });
            SceneReadError::from(if is_memory { described.marked_out_of_memory() } else { described })
        };
        let image = match decode_quantized_rgba(&file, &bytes, free).map_err(failed)? {
            Some(levels) => {
                let greatest = f64::from(levels.max_level);
                let table: Vec<f32> = if is_raw {
                    (0..=levels.max_level).map(|level| (f64::from(level) / greatest) as f32).collect()
                } else {
                    levels.srgb_table()
                };
                let pixel = |p: &[u16; 4]| Vec3::from([0, 1, 2].map(|k| table[usize::from(p[k])]));
                let pixels = levels.pixels.iter().map(pixel).collect();
                Image::from_pixels(levels.width, levels.height, pixels)
                    .map_err(|error| object.place.error(error, "name another picture"))?
            }
            None => decode(&file, &bytes, PixelMeaning::Color, free).map_err(failed)?.0,
        };
        let image = Rc::new(image);
        self.decoded_pictures.insert((file.clone(), is_raw), Rc::clone(&image));
        Ok((file, image))
    }

    /// Embeds a picture and returns its path.
    pub fn embed_picture(&mut self, image: Image) -> String {
        let path = format!("picture{}", self.pictures.len());
        self.pictures.insert(path.clone(), Arc::new(image));
        path
    }

    /// Removes all textures but those called `names`, and all pictures that neither these textures
    /// nor lights use.
    ///
    /// `light_pictures` are the paths of the pictures that lights use.
    pub fn keep_textures(&mut self, names: &HashSet<String>, light_pictures: &HashSet<String>) {
        self.descriptions.retain(|texture| names.contains(&texture.name));
        let shown: HashSet<&str> = self
            .descriptions
            .iter()
            .filter_map(|texture| match &texture.kind {
                TextureKindDescription::Image { path, .. } => Some(path.value.as_str()),
                TextureKindDescription::Checker { .. } | TextureKindDescription::Solid { .. } => None,
            })
            .collect();
        self.pictures.retain(|path, _| shown.contains(path.as_str()) || light_pictures.contains(path));
    }

    /// Converts the picture file of a `bitmap` texture, with its values multiplied by `factor`.
    ///
    /// Values are clamped to the range of `texture_use`, the quantity that they describe. Returns a
    /// constant if all pixels are equal.
    pub fn convert_bitmap(
        &mut self,
        context: &ImportContext<'_>,
        texture: &MitsubaObject,
        (texture_use, convention): (MitsubaTextureUse, TexcoordConvention),
        factor: f64,
    ) -> ReadResult<ConvertedTexture> {
        // Before version 2, the encoding is called `gamma`.
        let is_raw = texture_use == MitsubaTextureUse::Normal
            || texture.boolean("raw", false)
            || texture.number("gamma").is_some_and(|gamma| gamma == 1.0);
        let (file, picture) = self.decode_picture_file(context, texture, is_raw)?;
        let key = (file, is_raw, texture_use, factor.to_bits());
        let values = match self.converted_pictures.get(&key) {
            Some(values) => values.clone(),
            None => {
                context.files.check_memory(&key.0, 12 * picture.pixels().len() as u64)?;
                let value = |pixel: &Rgb| -> Vec3 { value_for_use(*pixel * factor as f32, texture_use) };
                let pixels: Vec<Rgb> = picture.pixels().iter().map(value).collect();
                let mean = pixels.iter().map(|pixel| pixel.as_dvec3()).sum::<DVec3>() / pixels.len() as f64;
                let values = if pixels.iter().all(|pixel| *pixel == pixels[0]) {
                    ConvertedTexture::Constant(pixels[0].as_dvec3())
                } else {
                    let image = Image::from_pixels(picture.width(), picture.height(), pixels);
                    let image = image.map_err(|error| texture.place.error(error, "name another picture"))?;
                    ConvertedTexture::Texture(Spanned::new(self.embed_picture(image), Span::default()), mean)
                };
                self.converted_pictures.insert(key, values.clone());
                values
            }
        };
        let ConvertedTexture::Texture(path, mean) = values else { return Ok(values) };
        if texture.text("filter_type") == Some("nearest") {
            context.add_note("textures are interpolated instead of showing square pixels", texture);
        }
        let wrap = ["wrap_mode", "wrap_mode_u"].iter().find_map(|name| texture.text(name)).unwrap_or("repeat");
        let wrap = match wrap {
            "repeat" => WrapMode::Repeat,
            "mirror" => WrapMode::Mirror,
            "clamp" => WrapMode::Clamp,
            _ => {
                context.add_note("textures end with their border pixels", texture);
                WrapMode::Clamp
            }
        };
        let to_uv = mitsuba_texcoord_transform(context, texture, convention);
        // v = 0 is the top of a picture in Mitsuba, and the bottom in Caustica.
        let coordinates = texcoord_transform_description(context, texture, flipped_v(to_uv));
        let kind =
            TextureKindDescription::Image { path, encoding: PictureEncoding::Linear, wrap, uv_transform: coordinates };
        Ok(ConvertedTexture::Texture(self.texture_name(kind), mean))
    }

    /// Converts a checkerboard of two colors. A texture inside the checkerboard becomes its mean,
    /// and a message tells the user.
    fn convert_checkerboard(
        &mut self,
        context: &ImportContext<'_>,
        texture: &MitsubaObject,
        (texture_use, convention): (MitsubaTextureUse, TexcoordConvention),
        factor: f64,
        depth: u32,
    ) -> ReadResult<ConvertedTexture> {
        let mut colors = [DVec3::ZERO; 2];
        for (color, (name, default)) in colors.iter_mut().zip([("color0", 0.4), ("color1", 0.2)]) {
            let inner = match context.color_value(texture, name)? {
                Some(_) => None,
                None => context.named_child(texture, ObjectClass::Texture, name)?,
            };
            *color = match inner {
                Some(inner) => {
                    context.add_note("textures inside a checkerboard become their mean", &inner);
                    self.convert_texture(context, &inner, (texture_use, convention), factor, depth + 1)?.mean()
                }
                None => {
                    let color = context.linear_rgb(texture, name, texture_use.color_meaning(), default)? * factor;
                    clamped_to_range(color, texture_use)
                }
            };
        }
        let mean = 0.5 * (colors[0] + colors[1]);
        // Mitsuba's checkerboard has period 1, and Caustica's has period 2.
        let (linear, offset) = mitsuba_texcoord_transform(context, texture, convention);
        let coordinates = texcoord_transform_description(context, texture, (linear * 2.0, offset * 2.0));
        let name = self.texture_name(TextureKindDescription::Checker { colors, uv_transform: coordinates });
        Ok(ConvertedTexture::Texture(name, mean))
    }

    /// Returns the name of the imported texture with the content `kind`. The first call for this
    /// content adds the texture to the imported scene.
    fn texture_name(&mut self, kind: TextureKindDescription) -> Spanned<String> {
        let next = format!("texture{}", self.descriptions.len());
        let name = self.texture_names_by_content.entry(format!("{kind:?}")).or_insert_with(|| next.clone()).clone();
        if name == next {
            let description = TextureDescription { name: next, kind };
            self.descriptions.push(Spanned::new(description, Span::default()));
        }
        Spanned::new(name, Span::default())
    }
}

/// Returns the sign of the product of the factors of nested `scale` textures: −1 or 1.
///
/// The caller multiplies the height of a bump map by this sign, because converted texture values
/// are never negative.
pub(super) fn sign_of_scales(context: &ImportContext<'_>, texture: &Rc<MitsubaObject>) -> ReadResult<f64> {
    let (mut sign, mut texture) = (1.0, Rc::clone(texture));
    for _ in 0..=MAX_TEXTURE_DEPTH {
        if texture.plugin != "scale" {
            break;
        }
        if scale_factor(&texture) < 0.0 {
            sign = -sign;
        }
        let Some((_, inner)) = context.children_of_class(&texture, ObjectClass::Texture)?.into_iter().next() else {
            break;
        };
        texture = inner;
    }
    Ok(sign)
}

/// Returns the factor by which a `scale` texture multiplies its nested texture.
fn scale_factor(texture: &MitsubaObject) -> f64 {
    texture.number("scale").or_else(|| texture.number("value")).unwrap_or(1.0)
}

/// Converts a constant color to the quantity `texture_use`, clamped to the range of this quantity.
///
/// If the quantity is a number, all channels of the result are equal, from the mean of the color's
/// channels.
fn clamped_to_range(color: DVec3, texture_use: MitsubaTextureUse) -> DVec3 {
    let is_number = matches!(
        texture_use,
        MitsubaTextureUse::Fraction | MitsubaTextureUse::SquaredFraction | MitsubaTextureUse::Height
    );
    // The mean of three equal channels could have a rounding error.
    let is_gray = color.x == color.y && color.y == color.z;
    clamped_value(if is_number && !is_gray { DVec3::splat(color.element_sum() / 3.0) } else { color }, texture_use)
}

/// Returns the quantity `texture_use` for a value of the texture: clamped, and squared for
/// [`MitsubaTextureUse::SquaredFraction`].
fn clamped_value(value: DVec3, texture_use: MitsubaTextureUse) -> DVec3 {
    match texture_use {
        MitsubaTextureUse::Color | MitsubaTextureUse::Fraction | MitsubaTextureUse::Normal => {
            value.clamp(DVec3::ZERO, DVec3::ONE)
        }
        MitsubaTextureUse::SquaredFraction => {
            let fraction = value.clamp(DVec3::ZERO, DVec3::ONE);
            fraction * fraction
        }
        MitsubaTextureUse::Height | MitsubaTextureUse::Radiance => value.max(DVec3::ZERO),
    }
}

/// Converts a pixel to the quantity `texture_use`, clamped to the range of this quantity.
///
/// If the quantity is a number, all channels of the result are equal, from the luminance of the
/// pixel. A pixel with a channel that is not finite counts as black.
fn value_for_use(pixel: Rgb, texture_use: MitsubaTextureUse) -> Vec3 {
    let pixel = if pixel.is_finite() { pixel } else { Rgb::ZERO };
    let pixel = match texture_use {
        MitsubaTextureUse::Color | MitsubaTextureUse::Radiance | MitsubaTextureUse::Normal => pixel,
        MitsubaTextureUse::Fraction | MitsubaTextureUse::SquaredFraction | MitsubaTextureUse::Height => {
            Rgb::splat(luminance(pixel))
        }
    };
    // The square of a single-precision number is exact in double precision.
    clamped_value(pixel.as_dvec3(), texture_use).as_vec3()
}

/// Returns an affine map of texture coordinates, as its linear part and its offset. The map goes
/// from a shape's coordinates in Caustica to those at which Mitsuba looks up `texture`.
///
/// The map includes the transform `to_uv` of the texture. A singular transform is ignored, and a
/// message tells the user.
fn mitsuba_texcoord_transform(
    context: &ImportContext<'_>,
    texture: &MitsubaObject,
    convention: TexcoordConvention,
) -> (DMat2, DVec2) {
    let matrix = texture.transform("to_uv").unwrap_or(DMat4::IDENTITY);
    let mut linear = DMat2::from_cols(matrix.x_axis.truncate().truncate(), matrix.y_axis.truncate().truncate());
    let mut offset = matrix.w_axis.truncate().truncate();
    // A 3 × 3 matrix has its offset in the third column.
    if offset == DVec2::ZERO {
        offset = matrix.z_axis.truncate().truncate();
    }
    // Before version 2, textures have scales and offsets instead of `to_uv`.
    let number = |name: &str, default: f64| texture.number(name).unwrap_or(default);
    let scale = DVec2::new(number("uscale", 1.0), number("vscale", 1.0));
    linear *= DMat2::from_diagonal(scale);
    offset += DVec2::new(number("uoffset", 0.0), number("voffset", 0.0));
    if !(linear.determinant() != 0.0 && linear.is_finite() && offset.is_finite()) {
        context.add_note("transforms of texture coordinates that are singular are ignored", texture);
        (linear, offset) = (DMat2::IDENTITY, DVec2::ZERO);
    }
    match convention {
        TexcoordConvention::Same => (linear, offset),
        TexcoordConvention::FlippedV => {
            (linear * DMat2::from_diagonal(DVec2::new(1.0, -1.0)), offset + linear * DVec2::Y)
        }
    }
}

/// Returns the affine map of (u, v) that applies the given map first, and then replaces v by 1 − v.
fn flipped_v((linear, offset): (DMat2, DVec2)) -> (DMat2, DVec2) {
    let flip = DMat2::from_diagonal(DVec2::new(1.0, -1.0));
    (flip * linear, flip * offset + DVec2::Y)
}

/// Converts an affine map of texture coordinates to three steps: scale, then rotation, then offset.
///
/// A shear of the map is ignored, and a message tells the user.
fn texcoord_transform_description(
    context: &ImportContext<'_>,
    texture: &MitsubaObject,
    (linear, offset): (DMat2, DVec2),
) -> TexcoordTransformDescription {
    let (u, v) = (linear.x_axis, linear.y_axis);
    if u.dot(v).abs() > 1e-9 * u.length() * v.length() {
        context.add_note("textures are not sheared", texture);
    }
    let scale = DVec2::new(u.length(), linear.determinant() / u.length());
    let is_half_turn = u.y == 0.0 && u.x < 0.0;
    if is_half_turn {
        // Negative scales are exact. A rotation by 180 degrees would have rounding errors.
        return TexcoordTransformDescription { scale: -scale, rotation_degrees: 0.0, offset };
    }
    TexcoordTransformDescription { scale, rotation_degrees: libm::atan2(u.y, u.x).to_degrees(), offset }
}
