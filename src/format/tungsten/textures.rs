//! Converts textures of Tungsten: constants, bitmaps and checkerboards.

use super::context::ImportContext;
use super::object::{ReadResult, TungstenObject, vector_of};
use crate::format::description::{
    PictureEncoding, Span, Spanned, TexcoordTransformDescription, TextureDescription, TextureKindDescription, WrapMode,
};
use crate::format::import::SceneReadError;
use crate::format::imported_textures::ConvertedTexture;
use crate::image::{Image, PixelMeaning, ReadError, decode, decode_quantized_rgba};
use glam::{DVec2, DVec3, Vec3};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::PathBuf;
use std::sync::Arc;

/// Greatest number of squares of a checkerboard along an axis.
const MAX_CHECKER_RESOLUTION: f64 = 1e6;

/// Greatest factor of a texture's values.
const MAX_SCALE: f64 = 1e12;

/// Quantity that a texture describes. It selects the conversion of pixel values and their range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TungstenTextureUse {
    /// Colors inside \[0, 1].
    Color,
    /// Numbers inside \[0, 1]: the means of the channels.
    Fraction,
    /// Opacities inside \[0, 1]: the alpha channel of a picture that has one, or else the means of
    /// the channels.
    Opacity,
    /// Colors of at least 0, such as radiance.
    NonNegative,
}

impl TungstenTextureUse {
    /// True if the quantity is a number, not a color.
    fn is_number(self) -> bool {
        matches!(self, Self::Fraction | Self::Opacity)
    }

    /// Returns a color as this quantity, clamped to its range. All channels of a number are equal.
    fn convert(self, color: DVec3) -> DVec3 {
        let is_gray = color.x == color.y && color.y == color.z;
        let value = if self.is_number() && !is_gray { DVec3::splat(color.element_sum() / 3.0) } else { color };
        match self {
            Self::Color | Self::Fraction | Self::Opacity => value.clamp(DVec3::ZERO, DVec3::ONE),
            Self::NonNegative => value.max(DVec3::ZERO),
        }
    }
}

/// A picture file and how its pixels become values.
#[derive(Clone, PartialEq, Eq, Hash)]
struct PictureKey {
    file: PathBuf,
    /// True if integer values are decoded as sRGB; false if they are linear.
    is_srgb: bool,
    texture_use: TungstenTextureUse,
    /// Bits of the factor of the values.
    factor_bits: u64,
}

/// Textures and embedded pictures of the imported scene so far.
#[derive(Default)]
pub(super) struct TungstenTextures {
    /// Textures of the imported scene.
    pub descriptions: Vec<Spanned<TextureDescription>>,
    /// Embedded pictures, by path.
    pub pictures: BTreeMap<String, Arc<Image>>,
    /// Paths and means of the embedded pictures of converted files.
    converted_pictures: HashMap<PictureKey, (String, DVec3)>,
    /// Names of the imported textures. A key is the content of a texture as text, so equal textures
    /// become one.
    texture_names_by_content: HashMap<String, String>,
}

impl TungstenTextures {
    /// Converts the texture in the member `name` of `object`. A missing member counts as gray of
    /// value `default`. Values are multiplied by `factor`.
    ///
    /// # Errors
    /// If the member is no number, color, picture or texture, or if its picture cannot be read.
    pub fn convert_member(
        &mut self,
        context: &ImportContext<'_>,
        object: &TungstenObject<'_>,
        (name, default): (&str, f64),
        texture_use: TungstenTextureUse,
        factor: f64,
    ) -> ReadResult<ConvertedTexture> {
        let Some(value) = object.value(name) else {
            return Ok(ConvertedTexture::Constant(texture_use.convert(DVec3::splat(default * factor))));
        };
        if let Some(color) = vector_of(value) {
            return Ok(ConvertedTexture::Constant(texture_use.convert(color * factor)));
        }
        match value {
            Value::String(file) => {
                let picture = BitmapOptions::read(None, file)?;
                self.convert_bitmap(context, object, &picture, texture_use, factor)
            }
            Value::Object(members) => {
                let texture = object.nested(members, name);
                self.convert_texture(context, &texture, texture_use, factor)
            }
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::Array(_) => {
                let help = "write a number, a list of three numbers, the path of a picture, or a texture";
                Err(object.error(format!("`{name}` is no color and no texture"), help))
            }
        }
    }

    /// Converts a texture that is a JSON object. A texture of unknown kind counts as white, and a
    /// message tells the user.
    fn convert_texture(
        &mut self,
        context: &ImportContext<'_>,
        texture: &TungstenObject<'_>,
        texture_use: TungstenTextureUse,
        factor: f64,
    ) -> ReadResult<ConvertedTexture> {
        match texture.kind()? {
            "constant" => {
                let value = texture.vector("value")?.unwrap_or(DVec3::ONE);
                Ok(ConvertedTexture::Constant(texture_use.convert(value * factor)))
            }
            "bitmap" => {
                let file = texture.text("file")?;
                let Some(file) = file else {
                    return Err(texture.error("this bitmap has no file", "state it as `file`"));
                };
                let picture = BitmapOptions::read(Some(texture), file)?;
                if !texture.boolean("interpolate", true)? {
                    context.add_note("textures are interpolated instead of showing square pixels", texture);
                }
                self.convert_bitmap(context, texture, &picture, texture_use, factor)
            }
            "checker" => {
                let color = |name: &str, default: f64| -> ReadResult<DVec3> {
                    let color = texture.vector(name)?.unwrap_or(DVec3::splat(default));
                    Ok(texture_use.convert(color * factor))
                };
                // The square at the origin of texture coordinates has the color `off_color`.
                let colors = [color("off_color", 0.2)?, color("on_color", 0.8)?];
                let count = |name: &str| texture.number_in(name, 20.0, 1.0..=MAX_CHECKER_RESOLUTION);
                let scale = DVec2::new(count("res_u")?.trunc(), count("res_v")?.trunc());
                let uv_transform = TexcoordTransformDescription { scale, ..TexcoordTransformDescription::default() };
                let name = self.texture_name(TextureKindDescription::Checker { colors, uv_transform });
                Ok(ConvertedTexture::Texture(name, 0.5 * (colors[0] + colors[1])))
            }
            other => {
                context.add_whole_object_note(&format!("textures of kind `{other}` become white"), texture);
                Ok(ConvertedTexture::Constant(texture_use.convert(DVec3::splat(factor))))
            }
        }
    }

    /// Converts a picture file, with its values multiplied by `factor`. Returns a constant if all
    /// values are equal.
    fn convert_bitmap(
        &mut self,
        context: &ImportContext<'_>,
        object: &TungstenObject<'_>,
        options: &BitmapOptions<'_>,
        texture_use: TungstenTextureUse,
        factor: f64,
    ) -> ReadResult<ConvertedTexture> {
        let factor = factor * options.scale;
        let key = PictureKey {
            file: context.files.find_file(options.file, object)?,
            // Tungsten takes numbers as they are stored.
            is_srgb: options.is_srgb && !texture_use.is_number(),
            texture_use,
            factor_bits: factor.to_bits(),
        };
        let (path, mean) = match self.converted_pictures.get(&key) {
            Some(known) => known.clone(),
            None => {
                let image = converted_picture(context, object, &key, factor)?;
                let mean = image.pixels().iter().map(|pixel| pixel.as_dvec3()).sum::<DVec3>();
                let mean = mean / image.pixels().len().max(1) as f64;
                let embedded = (self.embed_picture(image), mean);
                self.converted_pictures.insert(key, embedded.clone());
                embedded
            }
        };
        let wrap = if options.is_clamped { WrapMode::Clamp } else { WrapMode::Repeat };
        let kind = TextureKindDescription::Image {
            path: Spanned::new(path, Span::default()),
            encoding: PictureEncoding::Linear,
            wrap,
            uv_transform: TexcoordTransformDescription::default(),
        };
        Ok(ConvertedTexture::Texture(self.texture_name(kind), mean))
    }

    /// Embeds a picture and returns its path.
    pub fn embed_picture(&mut self, image: Image) -> String {
        let path = format!("picture{}", self.pictures.len());
        self.pictures.insert(path.clone(), Arc::new(image));
        path
    }

    /// Returns the picture of the imported texture called `name`; `None` if the texture is no
    /// picture.
    pub fn picture_of_texture(&self, name: &str) -> Option<Arc<Image>> {
        let texture = self.descriptions.iter().find(|texture| texture.value.name == name)?;
        match &texture.value.kind {
            TextureKindDescription::Image { path, .. } => self.pictures.get(&path.value).cloned(),
            TextureKindDescription::Checker { .. } | TextureKindDescription::Solid { .. } => None,
        }
    }

    /// Removes all textures but those called `names`, and all pictures that neither these textures
    /// nor lights use.
    ///
    /// `light_pictures` are the paths of the pictures that lights use.
    pub fn keep_textures(&mut self, names: &HashSet<String>, light_pictures: &HashSet<String>) {
        self.descriptions.retain(|texture| names.contains(&texture.name));
        let path = |texture: &Spanned<TextureDescription>| match &texture.kind {
            TextureKindDescription::Image { path, .. } => Some(path.value.clone()),
            TextureKindDescription::Checker { .. } | TextureKindDescription::Solid { .. } => None,
        };
        let shown: HashSet<String> = self.descriptions.iter().filter_map(path).collect();
        self.pictures.retain(|path, _| shown.contains(path) || light_pictures.contains(path));
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

/// A picture file with the members of a `bitmap` texture.
struct BitmapOptions<'a> {
    /// Path of the picture, relative to the folder of the scene.
    file: &'a str,
    /// True if integer colors are encoded by a transfer function; false if they are linear.
    is_srgb: bool,
    /// True if the picture ends with its border pixels; false if it repeats.
    is_clamped: bool,
    /// Factor of the values.
    scale: f64,
}

impl<'a> BitmapOptions<'a> {
    /// Reads the members of a `bitmap` texture. `texture` is `None` for a picture that is stated by
    /// its path alone.
    fn read(texture: Option<&TungstenObject<'_>>, file: &'a str) -> ReadResult<Self> {
        let Some(texture) = texture else {
            return Ok(Self { file, is_srgb: true, is_clamped: false, scale: 1.0 });
        };
        Ok(Self {
            file,
            is_srgb: texture.boolean("gamma_correct", true)?,
            is_clamped: texture.boolean("clamp", false)?,
            scale: texture.number_in("scale", 1.0, 0.0..=MAX_SCALE)?,
        })
    }
}

/// Reads a picture file and converts its pixels as `key` states. Values are multiplied by `factor`.
fn converted_picture(
    context: &ImportContext<'_>,
    object: &TungstenObject<'_>,
    key: &PictureKey,
    factor: f64,
) -> ReadResult<Image> {
    let files = context.files;
    let bytes = files.read_file(&key.file)?;
    let free = files.free_memory().map(|free| free.saturating_sub(bytes.len() as u64));
    let failed = |error: ReadError| picture_error(files.path, object, &error);
    let value = |color: Vec3| -> Vec3 {
        let color = if color.is_finite() { color.as_dvec3() } else { DVec3::ZERO };
        key.texture_use.convert(color * factor).as_vec3()
    };
    let Some(levels) = decode_quantized_rgba(&key.file, &bytes, free).map_err(failed)? else {
        let mut image = decode(&key.file, &bytes, PixelMeaning::Color, free).map_err(failed)?.0;
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel = value(*pixel));
        return Ok(image);
    };
    files.check_memory(&key.file, 12 * levels.pixels.len() as u64)?;
    let greatest = levels.max_level;
    let table: Vec<f32> = if key.is_srgb {
        levels.srgb_table()
    } else {
        (0..=greatest).map(|level| (f64::from(level) / f64::from(greatest)) as f32).collect()
    };
    let uses_alpha = key.texture_use == TungstenTextureUse::Opacity && levels.pixels.iter().any(|p| p[3] != greatest);
    let channels = if uses_alpha { [3, 3, 3] } else { [0, 1, 2] };
    let color = |pixel: &[u16; 4]| value(Vec3::from(channels.map(|k| table[usize::from(pixel[k])])));
    let pixels = levels.pixels.iter().map(color).collect();
    let image = Image::from_pixels(levels.width, levels.height, pixels);
    image.map_err(|error| object.error(error, "name another picture"))
}

/// Converts `error`, a defect of a picture file, to a scene error about `object`.
fn picture_error(scene: &std::path::Path, object: &TungstenObject<'_>, error: &ReadError) -> SceneReadError {
    if matches!(error, ReadError::Memory { .. }) {
        let message = format!("{}: {error}", object.label());
        let help = "use a smaller picture, or allow more memory (--memory)";
        let file = scene.display().to_string();
        return crate::format::SceneError::error_without_position(&file, message, help).marked_out_of_memory().into();
    }
    object.error(error, "repair the picture or name another: PNG, JPEG, BMP, TGA, OpenEXR or Radiance HDR")
}
