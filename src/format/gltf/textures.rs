//! Converts textures of a glTF file: decodes pictures and takes their colors or one channel.

use super::accessors::GltfBuffers;
use super::context::{FileContext, ReadResult};
use crate::color::Rgb;
use crate::format::description::{
    PictureEncoding, Span, Spanned, TexcoordTransformDescription, TextureDescription, TextureKindDescription, WrapMode,
};
use crate::format::import_notes::ImportNotes;
use crate::image::{Image, QuantizedRgba, decode_quantized_rgba};
use glam::{DVec2, DVec3, Vec3};
use gltf::image::Source;
use gltf::texture::{MagFilter, WrappingMode};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::rc::Rc;
use std::sync::Arc;

/// Reference of a material to a texture: the texture, its texture coordinates and their transform.
#[derive(Clone)]
pub(super) struct TextureReference<'a> {
    /// Texture in the glTF file: an image and its sampler.
    pub texture: gltf::Texture<'a>,
    /// Index of the texture coordinates that the texture uses (`TEXCOORD_0`, …).
    pub texcoord_set: u32,
    /// Transform from texture coordinates of the imported mesh to picture coordinates. In both, v
    /// grows upwards.
    pub transform: TexcoordTransformDescription,
}

/// Parameter of a material that a texture controls. It selects the conversion of pixel values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum GltfTextureUse {
    /// Colors, decoded from sRGB and multiplied by the given factor.
    Color(DVec3),
    /// Index of one channel (0 for red to 3 for alpha), and a factor. The parameter is the linear
    /// value of this channel, multiplied by the factor.
    Channel(usize, f64),
    /// GGX α: (green channel · given factor)².
    GgxAlpha(f64),
    /// Opacity mask with the given factor and cutoff: 1 where alpha · factor ≥ cutoff, else 0.
    AlphaMask(f64, f64),
    /// Tangent-space normals, stored as colors. The given factor multiplies x and y of each normal.
    Normal(f64),
}

/// Result of converting a texture: a constant, or a texture of the imported scene.
#[derive(Clone, Debug)]
pub(super) enum GltfConvertedTexture {
    /// Value of every pixel, if all pixels are equal.
    Constant(DVec3),
    /// Name of a texture in the imported scene, and the mean of its values.
    Texture(Spanned<String>, DVec3),
}

impl GltfConvertedTexture {
    /// Returns the mean of all pixels.
    pub fn mean(&self) -> DVec3 {
        match self {
            Self::Constant(mean) | Self::Texture(_, mean) => *mean,
        }
    }
}

/// Textures and embedded pictures of the imported scene so far.
pub(super) struct GltfTextures<'a> {
    context: &'a FileContext<'a>,
    document: &'a gltf::Document,
    buffers: &'a GltfBuffers<'a>,
    /// Decoded pictures by image index; `None` for an image in an unsupported format.
    decoded_pictures: HashMap<usize, Option<Rc<QuantizedRgba>>>,
    /// Results of image conversions. A key holds the image index, and the [`GltfTextureUse`] as
    /// text.
    ///
    /// If the value is `GltfConvertedTexture::Texture`, its text is the path of an embedded
    /// picture, and not the name of a texture as elsewhere.
    converted_pictures: HashMap<(usize, String), GltfConvertedTexture>,
    /// Names of the imported scene's textures. A key is a text that states picture path, wrap mode
    /// and transform, so that equal textures become one.
    texture_names_by_content: HashMap<String, Spanned<String>>,
    /// Textures of the imported scene.
    pub textures: Vec<Spanned<TextureDescription>>,
    /// Embedded pictures, by path.
    pub pictures: BTreeMap<String, Arc<Image>>,
}

impl<'a> GltfTextures<'a> {
    /// Returns an empty table of textures and pictures; decodes nothing yet.
    pub fn new(context: &'a FileContext<'a>, document: &'a gltf::Document, buffers: &'a GltfBuffers<'a>) -> Self {
        Self {
            context,
            document,
            buffers,
            decoded_pictures: HashMap::new(),
            converted_pictures: HashMap::new(),
            texture_names_by_content: HashMap::new(),
            textures: Vec::new(),
            pictures: BTreeMap::new(),
        }
    }

    /// Returns the texture to which the JSON object `info` of a material extension refers; `None`
    /// if the file has no such texture.
    pub fn texture_of_json(&self, info: &Value) -> Option<TextureReference<'a>> {
        TextureReference::from_json(self.document.textures(), info)
    }

    /// Converts the pixels of a texture for `texture_use`; `None` if its picture has an unsupported
    /// format.
    pub fn convert_texture(
        &mut self,
        reference: &TextureReference<'_>,
        texture_use: GltfTextureUse,
        notes: &mut ImportNotes,
    ) -> ReadResult<Option<GltfConvertedTexture>> {
        let Some(image) = reference.texture.source() else {
            let place = format!("textures[{}]", reference.texture.index());
            notes.add_unsupported("textures in other formats than PNG and JPEG are left out", place);
            return Ok(None);
        };
        let key = (image.index(), format!("{texture_use:?}"));
        let values = match self.converted_pictures.get(&key) {
            Some(values) => values.clone(),
            None => {
                let Some(levels) = self.decoded_levels(image.index(), &image, notes)? else { return Ok(None) };
                let values = self.embed_converted_picture(&levels, texture_use)?;
                self.converted_pictures.insert(key, values.clone());
                values
            }
        };
        Ok(Some(match values {
            GltfConvertedTexture::Constant(_) => values,
            GltfConvertedTexture::Texture(path, mean) => {
                GltfConvertedTexture::Texture(self.texture_name(reference, path, notes), mean)
            }
        }))
    }

    /// Removes all textures but those with `names`, and all pictures that these textures do not
    /// use.
    pub fn keep_textures(&mut self, names: &HashSet<String>) {
        self.textures.retain(|texture| names.contains(&texture.name));
        let shown = |path: &str| {
            self.textures.iter().any(|texture| match &texture.kind {
                TextureKindDescription::Image { path: shown, .. } => shown.value == path,
                TextureKindDescription::Checker { .. } | TextureKindDescription::Solid { .. } => false,
            })
        };
        let unused: Vec<String> = self.pictures.keys().filter(|path| !shown(path)).cloned().collect();
        unused.iter().for_each(|path| drop(self.pictures.remove(path)));
    }

    /// Returns the name of the imported texture that shows the embedded picture `path`, with the
    /// wrap mode and transform of `reference`.
    ///
    /// The first call for this combination adds the texture to the imported scene.
    fn texture_name(
        &mut self,
        reference: &TextureReference<'_>,
        path: Spanned<String>,
        notes: &mut ImportNotes,
    ) -> Spanned<String> {
        let sampler = reference.texture.sampler();
        let place = format!("textures[{}]", reference.texture.index());
        let wrap = match sampler.wrap_s() {
            WrappingMode::Repeat => WrapMode::Repeat,
            WrappingMode::ClampToEdge => WrapMode::Clamp,
            WrappingMode::MirroredRepeat => WrapMode::Mirror,
        };
        if sampler.wrap_s() != sampler.wrap_t() {
            notes.add_unsupported("textures wrap along v as along u", place.clone());
        }
        if sampler.mag_filter() == Some(MagFilter::Nearest) {
            notes.add_unsupported("textures are interpolated instead of showing square pixels", place);
        }
        let coordinates = reference.transform;
        let key = format!("{} {wrap:?} {coordinates:?}", path.value);
        if let Some(name) = self.texture_names_by_content.get(&key) {
            return name.clone();
        }
        let name = format!("texture{}", self.textures.len());
        let kind =
            TextureKindDescription::Image { path, encoding: PictureEncoding::Linear, wrap, uv_transform: coordinates };
        self.textures.push(Spanned::new(TextureDescription { name: name.clone(), kind }, Span::default()));
        let name = Spanned::new(name, Span::default());
        self.texture_names_by_content.insert(key, name.clone());
        name
    }

    /// Returns the pixels of an image as integer levels, before any conversion to linear values.
    /// `None` if the format of the image is not supported.
    ///
    /// Each image is decoded once.
    fn decoded_levels(
        &mut self,
        index: usize,
        image: &gltf::Image<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<Option<Rc<QuantizedRgba>>> {
        if let Some(decoded) = self.decoded_pictures.get(&index) {
            return Ok(decoded.clone());
        }
        let place = format!("images[{index}]");
        let bytes = match image.source() {
            Source::View { view, .. } => self.buffers.view_bytes(&view)?.into_vec(),
            Source::Uri { uri, .. } => self.context.read_uri(&place, uri)?,
        };
        let levels = decode_quantized_rgba(self.context.path, &bytes, self.context.free_memory())
            .map_err(|e| self.context.error(&place, e))?
            .map(Rc::new);
        if levels.is_none() {
            notes.add_unsupported("textures in other formats than PNG and JPEG are left out", place);
        }
        self.decoded_pictures.insert(index, levels.clone());
        Ok(levels)
    }

    /// Converts pixels for `texture_use`, and embeds them as a picture.
    ///
    /// Returns `GltfConvertedTexture::Texture`, with the path of the picture in place of a
    /// texture's name. If all pixels are equal, returns `Constant`, and embeds nothing.
    fn embed_converted_picture(
        &mut self,
        levels: &QuantizedRgba,
        texture_use: GltfTextureUse,
    ) -> ReadResult<GltfConvertedTexture> {
        self.context.check_memory(12 * levels.pixels.len() as u64)?;
        let greatest = f64::from(levels.max_level);
        let srgb = if matches!(texture_use, GltfTextureUse::Color(_)) { levels.srgb_table() } else { Vec::new() };
        let gray = |value: f64| Vec3::splat(value as f32);
        let value = |pixel: &[u16; 4]| {
            let channel = |k: usize| f64::from(pixel[k]) / greatest;
            match texture_use {
                GltfTextureUse::Color(factor) => {
                    let [r, g, b] = [0, 1, 2].map(|k| srgb[usize::from(pixel[k])]);
                    Vec3::new(r, g, b) * factor.as_vec3()
                }
                GltfTextureUse::Channel(k, factor) => gray(channel(k) * factor),
                GltfTextureUse::GgxAlpha(factor) => {
                    let roughness = channel(1) * factor;
                    gray(roughness * roughness)
                }
                GltfTextureUse::AlphaMask(factor, cutoff) => gray(f64::from(channel(3) * factor >= cutoff)),
                GltfTextureUse::Normal(scale) => {
                    let [x, y, z] = [0, 1, 2].map(channel);
                    if scale == 1.0 {
                        return Vec3::new(x as f32, y as f32, z as f32);
                    }
                    let normal = (2.0 * DVec3::new(x, y, z) - 1.0) * DVec3::new(scale, scale, 1.0);
                    (0.5 * normal.normalize_or(DVec3::Z) + 0.5).as_vec3()
                }
            }
        };
        let pixels: Vec<Rgb> = levels.pixels.iter().map(value).collect();
        if pixels.iter().all(|pixel| *pixel == pixels[0]) {
            return Ok(GltfConvertedTexture::Constant(pixels[0].as_dvec3()));
        }
        let mean = pixels.iter().map(|pixel| pixel.as_dvec3()).sum::<DVec3>() / pixels.len() as f64;
        let path = format!("picture{}", self.pictures.len());
        let image =
            Image::from_pixels(levels.width, levels.height, pixels).map_err(|e| self.context.error("images", e))?;
        self.pictures.insert(path.clone(), Arc::new(image));
        Ok(GltfConvertedTexture::Texture(Spanned::new(path, Span::default()), mean))
    }
}

impl<'a> TextureReference<'a> {
    /// Returns the texture that `info` refers to, with the extension KHR_texture_transform applied.
    pub fn from_info(info: &gltf::texture::Info<'a>) -> Self {
        let extension = info.texture_transform();
        let texcoord_set = extension.as_ref().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord());
        let transform = extension.map_or_else(TexcoordTransformDescription::default, |t| {
            texcoord_transform_description(t.offset().map(f64::from), f64::from(t.rotation()), t.scale().map(f64::from))
        });
        Self { texture: info.texture(), texcoord_set, transform }
    }

    /// Returns the texture of a normal map, with the extension KHR_texture_transform applied.
    pub fn from_normal_texture(normal: &gltf::material::NormalTexture<'a>) -> Self {
        let extension = normal.extension_value("KHR_texture_transform");
        Self::with_raw_transform(normal.texture(), normal.tex_coord(), extension)
    }

    /// Returns the texture to which the JSON object `info` of a material extension refers, with the
    /// extension KHR_texture_transform applied.
    ///
    /// `textures` are all textures of the file. `None` if the index in `info` is not among them.
    pub fn from_json(mut textures: gltf::iter::Textures<'a>, info: &Value) -> Option<Self> {
        let index = usize::try_from(info.get("index")?.as_u64()?).ok()?;
        let texcoord_set = info.get("texCoord").and_then(Value::as_u64).unwrap_or(0);
        let extension = info.get("extensions").and_then(|extensions| extensions.get("KHR_texture_transform"));
        Some(Self::with_raw_transform(textures.nth(index)?, u32::try_from(texcoord_set).ok()?, extension))
    }

    /// Returns a reference to `texture` with the transform of `extension`, the JSON object of
    /// KHR_texture_transform.
    ///
    /// Reads the transform from the JSON, because the crate `gltf` parses this extension only for
    /// some kinds of textures.
    fn with_raw_transform(texture: gltf::Texture<'a>, texcoord_set: u32, extension: Option<&Value>) -> Self {
        let Some(extension) = extension else {
            return Self { texture, texcoord_set, transform: TexcoordTransformDescription::default() };
        };
        let numbers = |key: &str, default: f64| -> [f64; 2] {
            let number = |i: usize| extension.get(key)?.get(i)?.as_f64();
            [0, 1].map(|i| number(i).unwrap_or(default))
        };
        let number = |key: &str| extension.get(key)?.as_f64();
        let transform = texcoord_transform_description(
            numbers("offset", 0.0),
            number("rotation").unwrap_or(0.0),
            numbers("scale", 1.0),
        );
        Self { texture, texcoord_set: number("texCoord").map_or(texcoord_set, |set| set as u32), transform }
    }

    /// True if the texture transform is invertible: all its numbers are finite, and no scale is 0.
    pub fn has_valid_transform(&self) -> bool {
        let TexcoordTransformDescription { scale, rotation_degrees: rotate, offset } = self.transform;
        scale.is_finite() && scale.x != 0.0 && scale.y != 0.0 && rotate.is_finite() && offset.is_finite()
    }
}

/// Converts a transform of KHR_texture_transform, where v grows downwards, to one where v grows
/// upwards in both mesh and picture.
///
/// `rotation` is in radians.
fn texcoord_transform_description(offset: [f64; 2], rotation: f64, scale: [f64; 2]) -> TexcoordTransformDescription {
    let (sin, cos) = (libm::sin(rotation), libm::cos(rotation));
    TexcoordTransformDescription {
        scale: scale.into(),
        rotation_degrees: rotation.to_degrees(),
        offset: DVec2::new(offset[0] + scale[1] * sin, 1.0 - offset[1] - scale[1] * cos),
    }
}
