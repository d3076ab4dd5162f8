//! Converts textures of pbrt to textures and embedded pictures of the imported scene.

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::parameters::{Parameter, Parameters};
use super::pictures::{LevelCurve, PbrtPicture, read_picture};
use super::spectra::{ColorMeaning, SpectralValue, linear_rgb, spectral_value};
use crate::format::description::{
    PictureEncoding, SolidPatternDescription, Span, Spanned, TexcoordTransformDescription, TextureDescription,
    TextureKindDescription, TexturedValue, WrapMode,
};
use crate::format::import_notes::ImportNotes;
use crate::image::Image;
use glam::{DVec2, DVec3, Vec3};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Value of a pbrt texture or color parameter: a constant or a function of the surface point.
#[derive(Clone, Debug)]
pub(super) enum PbrtTexture {
    /// One value everywhere.
    Constant(DVec3),
    /// Pixels of a picture.
    Picture {
        /// The picture; its values are linear.
        image: Arc<Image>,
        /// Factor on the pixel values.
        factor: DVec3,
        /// Rule for texture coordinates beyond the picture's edges.
        wrap: WrapMode,
        /// Transform from the surface's texture coordinates to those of the picture.
        coordinates: TexcoordTransformDescription,
    },
    /// A checkerboard of two colors.
    Checker {
        /// Colors of the two kinds of squares.
        colors: [DVec3; 2],
        /// Transform from the surface's texture coordinates to those of the checkerboard.
        coordinates: TexcoordTransformDescription,
    },
    /// A solid texture (a function of the position in space): noise that blends two colors.
    Solid {
        /// Pattern in space. Its values from 0 to 1 blend the two colors.
        pattern: SolidPatternDescription,
        /// Colors where the pattern has the values 0 and 1.
        colors: [DVec3; 2],
        /// Number of noise octaves.
        octaves: u32,
    },
}

impl PbrtTexture {
    /// Returns the texture with `map` applied to each of its values: constant, pixels or colors.
    fn with_mapped_values(&self, map: &dyn Fn(DVec3) -> DVec3) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(map(*value)),
            Self::Picture { image, factor, wrap, coordinates } => {
                let mut image = (**image).clone();
                for pixel in image.pixels_mut() {
                    *pixel = map(pixel.as_dvec3() * *factor).as_vec3();
                }
                Self::Picture { image: image.into(), factor: DVec3::ONE, wrap: *wrap, coordinates: *coordinates }
            }
            Self::Checker { colors, coordinates } => {
                Self::Checker { colors: colors.map(map), coordinates: *coordinates }
            }
            Self::Solid { pattern, colors, octaves } => {
                Self::Solid { pattern: *pattern, colors: colors.map(map), octaves: *octaves }
            }
        }
    }

    /// Returns the mean of the values: over all pixels of a picture, or over both colors of a
    /// pattern.
    pub fn mean(&self) -> DVec3 {
        match self {
            Self::Constant(value) => *value,
            Self::Picture { image, factor, .. } => {
                let pixels = image.pixels();
                *factor * pixels.iter().map(|pixel| pixel.as_dvec3()).sum::<DVec3>() / pixels.len().max(1) as f64
            }
            Self::Checker { colors, .. } | Self::Solid { colors, .. } => 0.5 * (colors[0] + colors[1]),
        }
    }

    /// Returns the memory that a copy of the texture takes \[bytes].
    fn memory_bytes(&self) -> u64 {
        match self {
            Self::Picture { image, .. } => 12 * image.pixels().len() as u64,
            Self::Constant(_) | Self::Checker { .. } | Self::Solid { .. } => 0,
        }
    }
}

/// Textures that the pbrt file defines, and textures and pictures of the imported scene.
#[derive(Default)]
pub(super) struct PbrtTextures {
    /// Textures that the pbrt file defines. A key is a flag and a name: pbrt has separate names for
    /// color textures (true) and number textures (false).
    defined: HashMap<(bool, String), PbrtTexture>,
    /// Textures of the imported scene.
    pub descriptions: Vec<Spanned<TextureDescription>>,
    /// Embedded pictures of the imported scene, by path.
    pub pictures: BTreeMap<String, Arc<Image>>,
}

impl PbrtTextures {
    /// Adds the texture of a `Texture` directive.
    ///
    /// `class` is the type of the texture, such as `imagemap`. `is_color` is true for a color
    /// texture, and false for a number texture. `is_v3` is true for a scene of pbrt-v3.
    pub fn define_texture(
        &mut self,
        (name, class, is_color): (&str, &str, bool),
        parameters: &Parameters,
        is_v3: bool,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<()> {
        let place = &parameters.place;
        let value = |names: &[&str], default: f64| match parameters.find_any(names) {
            Some(parameter) => self.parameter_value(parameter, is_color, place, files),
            None => Ok(PbrtTexture::Constant(DVec3::splat(default))),
        };
        let texture = match class {
            "constant" => value(&["value"], 1.0)?,
            "scale" => {
                let (first, second) = (value(&["tex", "tex1"], 1.0)?, value(&["scale", "tex2"], 1.0)?);
                let (texture, factor) = match (&first, &second) {
                    (PbrtTexture::Constant(factor), _) => (&second, *factor),
                    (_, PbrtTexture::Constant(factor)) => (&first, *factor),
                    _ => {
                        let message = "products of two textures are the first, times the mean of the second";
                        notes.add_unsupported(message, place.position_text());
                        (&first, second.mean())
                    }
                };
                files.reserve_memory(texture.memory_bytes())?;
                texture.with_mapped_values(&|value| value * factor)
            }
            "mix" | "directionmix" => {
                let (first, second) = (value(&["tex1"], 0.0)?, value(&["tex2"], 1.0)?);
                let amount = if class == "directionmix" {
                    notes.add_unsupported("mixes by direction are half and half", place.position_text());
                    PbrtTexture::Constant(DVec3::splat(0.5))
                } else {
                    value(&["amount"], 0.5)?
                };
                match (&first, &second, &amount) {
                    (PbrtTexture::Constant(a), PbrtTexture::Constant(b), amount) => {
                        let (a, b) = (*a, *b);
                        files.reserve_memory(amount.memory_bytes())?;
                        amount.with_mapped_values(&|t| a + (b - a) * t)
                    }
                    _ => {
                        notes.add_unsupported("mixes of textures are their mean", place.position_text());
                        let (a, b) = (first.mean(), second.mean());
                        PbrtTexture::Constant(a + (b - a) * amount.mean())
                    }
                }
            }
            "checkerboard" => {
                let squares = [value(&["tex1"], 1.0)?, value(&["tex2"], 0.0)?];
                if squares.iter().any(|square| !matches!(square, PbrtTexture::Constant(_))) {
                    notes.add_unsupported("textures inside a checkerboard become their mean", place.position_text());
                }
                let colors = squares.map(|square| square.mean());
                if parameters.number_or("dimension", 2.0) != 2.0 {
                    notes.add_unsupported("checkerboards of three dimensions have two", place.position_text());
                }
                PbrtTexture::Checker { colors, coordinates: texcoord_transform_description(parameters, notes) }
            }
            "imagemap" => image_map(parameters, (is_color, is_v3), files, notes)?,
            "fbm" | "wrinkled" | "windy" | "marble" => {
                notes.add_unsupported("procedural textures have Caustica's noise, not pbrt's", place.position_text());
                let (pattern, colors) = match class {
                    "marble" => (SolidPatternDescription::Marble, [DVec3::new(0.2, 0.2, 0.3), DVec3::splat(0.9)]),
                    _ => (SolidPatternDescription::Noise, [DVec3::ZERO, DVec3::ONE]),
                };
                let octaves = parameters.number_or("octaves", 8.0).clamp(1.0, 16.0) as u32;
                PbrtTexture::Solid { pattern, colors, octaves }
            }
            "bilerp" => {
                notes.add_unsupported("textures between four corners are their mean", place.position_text());
                let mut sum = DVec3::ZERO;
                for (name, default) in [("v00", 0.0), ("v01", 1.0), ("v10", 0.0), ("v11", 1.0)] {
                    sum += value(&[name], default)?.mean();
                }
                PbrtTexture::Constant(0.25 * sum)
            }
            "dots" => {
                notes.add_unsupported("textures of dots have the color between the dots", place.position_text());
                value(&["outside"], 0.0)?
            }
            _ => {
                let message = format!("no texture `{class}` is supported");
                return Err(place.error(message, "use imagemap, constant, scale, mix or checkerboard"));
            }
        };
        files.reserve_memory(400 + texture.memory_bytes())?;
        self.defined.insert((is_color, name.to_owned()), texture);
        Ok(())
    }

    /// Returns the value of a parameter, which is a number, a color, or the name of a texture.
    ///
    /// If `is_color` is true, a name is looked up among color textures first, else among number
    /// textures first. Negative RGB values become 0. RGB values above 1 are kept, because they may
    /// be factors: the caller clamps the product.
    pub fn parameter_value(
        &self,
        parameter: &Parameter,
        is_color: bool,
        place: &PbrtSourceLocation,
        files: &PbrtSceneFiles<'_>,
    ) -> ReadResult<PbrtTexture> {
        if parameter.kind != "texture" {
            if parameter.numbers.len() == 1 && (!is_color || parameter.kind == "float") {
                return Ok(PbrtTexture::Constant(DVec3::splat(parameter.numbers[0])));
            }
            if is_color
                && matches!(&*parameter.kind, "rgb" | "color")
                && let SpectralValue::Rgb(rgb) = spectral_value(parameter, place, files)?
            {
                // A color may be a factor above 1. The material clamps the product.
                return Ok(PbrtTexture::Constant(rgb.max(DVec3::ZERO)));
            }
            let meaning = if is_color { ColorMeaning::Reflectance } else { ColorMeaning::Unbounded };
            return linear_rgb(parameter, meaning, place, files).map(PbrtTexture::Constant);
        }
        let name = parameter.texts.first().map(String::as_str).unwrap_or_default();
        let find = |is_color: bool| self.defined.get(&(is_color, name.to_owned()));
        find(is_color).or_else(|| find(!is_color)).cloned().ok_or_else(|| {
            place.error(format!("no texture is called `{name}`"), "define it before its use: `Texture \"name\" …`")
        })
    }

    /// Applies `map` to all values of a texture, and adds the result to the imported scene.
    ///
    /// Returns the name of the added texture, and the mean of its values. If all values are equal,
    /// adds no texture, and returns this value in place of both.
    pub fn add_texture(
        &mut self,
        value: &PbrtTexture,
        map: &dyn Fn(DVec3) -> DVec3,
        files: &PbrtSceneFiles<'_>,
    ) -> ReadResult<(TexturedValue<DVec3>, DVec3)> {
        files.reserve_memory(value.memory_bytes())?;
        let mapped = value.with_mapped_values(map);
        let mean = mapped.mean();
        let kind = match mapped {
            PbrtTexture::Constant(value) => return Ok((TexturedValue::Constant(value), value)),
            PbrtTexture::Picture { image, wrap, coordinates, .. } => {
                let first = image.pixels().first().copied().unwrap_or_default();
                if image.pixels().iter().all(|pixel| *pixel == first) {
                    return Ok((TexturedValue::Constant(first.as_dvec3()), first.as_dvec3()));
                }
                let path = Spanned::new(self.embed_picture((*image).clone(), files)?, Span::default());
                TextureKindDescription::Image {
                    path,
                    encoding: PictureEncoding::Linear,
                    wrap,
                    uv_transform: coordinates,
                }
            }
            PbrtTexture::Checker { colors, coordinates } => {
                TextureKindDescription::Checker { colors, uv_transform: coordinates }
            }
            PbrtTexture::Solid { pattern, colors, octaves } => TextureKindDescription::Solid {
                pattern,
                colors,
                octaves,
                frequency: 1.0,
                amplitude: 1.0,
                steps: Vec::new(),
            },
        };
        files.reserve_memory(400)?;
        let name = format!("texture{}", self.descriptions.len());
        self.descriptions.push(Spanned::new(TextureDescription { name: name.clone(), kind }, Span::default()));
        Ok((TexturedValue::Texture(Spanned::new(name, Span::default())), mean))
    }

    /// True if the texture `name` of the imported scene depends on texture coordinates (u, v).
    pub fn needs_texcoords(&self, name: &str) -> bool {
        let texture = self.descriptions.iter().rev().find(|texture| texture.name == name);
        texture.is_some_and(|texture| !matches!(texture.kind, TextureKindDescription::Solid { .. }))
    }

    /// Embeds a picture in the imported scene, and returns its path there.
    pub fn embed_picture(&mut self, image: Image, files: &PbrtSceneFiles<'_>) -> ReadResult<String> {
        files.reserve_memory(12 * image.pixels().len() as u64)?;
        let path = format!("picture{}", self.pictures.len());
        self.pictures.insert(path.clone(), image.into());
        Ok(path)
    }
}

/// Returns the texture of an `imagemap`, with the pixels of its picture file.
///
/// For a number texture, the value of a pixel is the mean of its channels. In pbrt-v4, the value is
/// alpha instead, if the picture has an alpha channel that is not 1 everywhere.
fn image_map(
    parameters: &Parameters,
    (is_color, is_v3): (bool, bool),
    files: &PbrtSceneFiles<'_>,
    notes: &mut ImportNotes,
) -> ReadResult<PbrtTexture> {
    let place = &parameters.place;
    let name = parameters.text("filename").unwrap_or_default();
    let PbrtPicture { mut image, alpha } = read_picture(name, LevelCurve::from_parameters(parameters)?, place, files)?;
    let factor = parameters.number_or("scale", 1.0).max(0.0);
    let inverts = parameters.flag("invert") == Some(true);
    let numbers = alpha.filter(|_| !(is_color || is_v3));
    for (i, pixel) in image.pixels_mut().iter_mut().enumerate() {
        let color = if pixel.is_finite() { pixel.max(Vec3::ZERO) } else { Vec3::ZERO };
        let value = match &numbers {
            Some(numbers) => Vec3::splat(numbers.get(i).copied().unwrap_or_default()),
            None if is_color => color,
            None => Vec3::splat(color.element_sum() / 3.0),
        };
        // pbrt inverts the scaled value.
        *pixel = if inverts { (1.0 - value * factor as f32).max(Vec3::ZERO) } else { value };
    }
    let wrap = match parameters.text("wrap") {
        Some("clamp") => WrapMode::Clamp,
        Some("black") => {
            notes.add_unsupported("textures that are black beyond their edges repeat", place.position_text());
            WrapMode::Repeat
        }
        _ => WrapMode::Repeat,
    };
    Ok(PbrtTexture::Picture {
        image: image.into(),
        factor: if inverts { DVec3::ONE } else { DVec3::splat(factor) },
        wrap,
        coordinates: texcoord_transform_description(parameters, notes),
    })
}

/// Returns the transform of texture coordinates from a texture's parameters `uscale`, `vscale`,
/// `udelta` and `vdelta`.
///
/// A `mapping` other than `uv` is ignored, and a message tells the user. Scales of 0 become 10⁻¹².
fn texcoord_transform_description(parameters: &Parameters, notes: &mut ImportNotes) -> TexcoordTransformDescription {
    if parameters.text("mapping").is_some_and(|mapping| mapping != "uv") {
        let message = "textures are mapped by texture coordinates only";
        notes.add_unsupported(message, parameters.place.position_text());
    }
    let pair =
        |u: &str, v: &str, default: f64| DVec2::new(parameters.number_or(u, default), parameters.number_or(v, default));
    let mut scale = pair("uscale", "vscale", 1.0);
    // A scale of 0 shows a single line of the texture. A tiny scale does so too, and is invertible.
    scale = scale.map(|s| if s == 0.0 { 1e-12 } else { s });
    TexcoordTransformDescription { scale, rotation_degrees: 0.0, offset: pair("udelta", "vdelta", 0.0) }
}

#[cfg(test)]
mod tests;
