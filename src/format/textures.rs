//! Textures in the scene language: descriptions, parsing and writing of their blocks, and
//! conversion to the textures that are rendered.

use super::error::SceneError;
use super::language::fields::{BlockFields, parse_block_by_keyword};
use super::language::lexer::Token;
use super::language::names::parse_unique_block_name;
use super::language::parser::Parser;
use super::language::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, block_keywords, block_schema, field_schema,
};
use super::language::transforms::write_transform_field;
use super::language::writer::SceneWriter;
use super::resolve::{Resolver, SINGULAR_REMEDY, rgb};
use super::span::Spanned;
use super::transform_step::TransformStep;
use crate::image::PixelMeaning;
use crate::math::Transform;
pub use crate::texture::WrapMode;
use crate::texture::{Checkerboard, SolidPattern, SolidTexture, Texture, UvTransform};
use glam::{DVec2, DVec3};
use std::fmt;

/// A texture as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDescription {
    /// Name that materials refer to: not empty, without line breaks.
    pub name: String,
    /// Picture, checkerboard or solid pattern.
    pub kind: TextureKindDescription,
}

/// Picture, checkerboard or solid texture, with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureKindDescription {
    /// A picture in a file of its own.
    Image {
        /// Path of the picture, as the scene file states it: not empty, without line breaks.
        path: Spanned<String>,
        /// Encoding of pictures with integer values, such as PNG. Floating-point pictures are
        /// linear.
        encoding: PictureEncoding,
        /// Rule for texture coordinates beyond the picture's edges: repeat, mirror or clamp.
        wrap: WrapMode,
        /// Transform from the surface's texture coordinates to those of the picture.
        uv_transform: TexcoordTransformDescription,
    },
    /// Checkerboard with squares of side 1 in texture coordinates.
    Checker {
        /// Colors where ⌊u⌋ + ⌊v⌋ is even, and where it is odd.
        colors: [DVec3; 2],
        /// Transform from the surface's texture coordinates to those of the checkerboard.
        uv_transform: TexcoordTransformDescription,
    },
    /// A solid texture: a function of the position in object space.
    Solid {
        /// Function of the position.
        pattern: SolidPatternDescription,
        /// Colors where the pattern has the values 0 and 1.
        colors: [DVec3; 2],
        /// Number of noise octaves, from 1 to 16.
        octaves: u32,
        /// Number of periods per unit of length in pattern space, above 0. The first noise octave
        /// has this frequency, and so have marble veins and wood rings.
        frequency: f64,
        /// Factor of the noise, at least 0. In marble and wood, factor times noise is the shift of
        /// the veins or rings, in periods.
        amplitude: f64,
        /// Steps from pattern space to object space; see [`TransformStep::composed_matrix`].
        steps: Vec<TransformStep>,
    },
}

/// Function of position, with values from 0 to 1, that a solid texture evaluates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidPatternDescription {
    /// Perlin noise.
    Noise,
    /// Veins across the x axis of pattern space, distorted by noise.
    Marble,
    /// Rings about the y axis of pattern space, distorted by noise.
    Wood,
}

/// Encoding of pictures with integer values, such as PNG files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureEncoding {
    /// Integer values are encoded by the sRGB transfer function, as in photographs.
    #[default]
    Srgb,
    /// Integer values are linear, as in pictures of heights or normals.
    Linear,
}

/// Transform of texture coordinates: a scale, then a rotation, then an offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexcoordTransformDescription {
    /// Factors by which u and v are multiplied, neither of them 0.
    pub scale: DVec2,
    /// Counterclockwise rotation in degrees.
    pub rotation_degrees: f64,
    /// Offset of u and v.
    pub offset: DVec2,
}

impl Default for TexcoordTransformDescription {
    fn default() -> Self {
        Self { scale: DVec2::ONE, rotation_degrees: 0.0, offset: DVec2::ZERO }
    }
}

/// Texture blocks of the scene language, each with the function that converts its fields.
pub(super) static TEXTURE_BLOCK_PARSERS: &[BlockParser<ParseTexture>] = &[
    BlockParser { block: &IMAGE, parse: parse_image_texture },
    BlockParser { block: &CHECKER, parse: parse_checker_texture },
    BlockParser { block: &NOISE, parse: |f| parse_solid_pattern(f, SolidPatternDescription::Noise) },
    BlockParser { block: &MARBLE, parse: |f| parse_solid_pattern(f, SolidPatternDescription::Marble) },
    BlockParser { block: &WOOD, parse: |f| parse_solid_pattern(f, SolidPatternDescription::Wood) },
];

/// Function that converts the parsed fields of a texture block to a texture.
type ParseTexture = fn(&BlockFields<'_>) -> Result<TextureKindDescription, SceneError>;

const COORDINATE_FIELDS: &[FieldSchema] = &[
    field_schema("scale", FieldKind::Pair, "factors of u and v")
        .with_range(FieldRange::NonZero)
        .with_default_numbers(&[1.0, 1.0]),
    field_schema("rotate", FieldKind::Number, "rotation of (u, v) after that, anticlockwise")
        .with_default_numbers(&[0.0])
        .with_unit("degrees"),
    field_schema("offset", FieldKind::Pair, "offset of (u, v) after that").with_default_numbers(&[0.0, 0.0]),
];

const COLOR_FIELDS: &[FieldSchema] = &[
    field_schema("color0", FieldKind::Color, "first color; of a checker where ⌊u⌋ + ⌊v⌋ is even")
        .with_default_numbers(&[0.0, 0.0, 0.0]),
    field_schema("color1", FieldKind::Color, "second color").with_default_numbers(&[1.0, 1.0, 1.0]),
];

// The last of 16 octaves is 32,768 times finer than the first.
const PATTERN_FIELDS: &[FieldSchema] = &[
    field_schema("octaves", FieldKind::WholeNumber, "octaves of noise")
        .with_range(FieldRange::ClosedInterval(1.0, 16.0))
        .with_default_numbers(&[4.0]),
    field_schema("frequency", FieldKind::Number, "frequency f of the first octave, of veins and of rings")
        .with_range(FieldRange::Positive)
        .with_default_numbers(&[1.0])
        .with_unit("1/length"),
    field_schema("amplitude", FieldKind::Number, "factor a of the noise")
        .with_range(FieldRange::NonNegative)
        .with_default_numbers(&[1.0]),
    field_schema("Transform", FieldKind::TransformSteps, "maps from the pattern's space to the object's")
        .make_optional("none"),
];

static IMAGE: BlockSchema = block_schema("Image", "a picture, which covers the unit square of texture coordinates")
    .with_own_fields(&[
        field_schema("file", FieldKind::Name, "picture: PNG, OpenEXR or Radiance HDR").make_required(),
        field_schema(
            "encoding",
            FieldKind::Word(&["srgb", "linear"]),
            "encoding of a PNG; other formats are always linear",
        )
        .with_default_word("srgb"),
        field_schema("wrap", FieldKind::Word(&["repeat", "clamp", "mirror"]), "continuation beyond the edges")
            .with_default_word("repeat"),
    ])
    .with_shared_fields(&[COORDINATE_FIELDS]);

static CHECKER: BlockSchema = block_schema("Checker", "squares of side 1 in texture coordinates")
    .with_shared_fields(&[COLOR_FIELDS, COORDINATE_FIELDS]);

static NOISE: BlockSchema = block_schema("Noise", "solid noise, t = ½ + ½ a N, clamped to 0 … 1: clouds, lumps")
    .with_shared_fields(&[COLOR_FIELDS, PATTERN_FIELDS]);

static MARBLE: BlockSchema = block_schema("Marble", "solid veins across the x axis, t = ½ + ½ sin 2π(f x + a N)")
    .with_shared_fields(&[COLOR_FIELDS, PATTERN_FIELDS]);

static WOOD: BlockSchema = block_schema("Wood", "solid rings about the y axis, t = ½ + ½ sin 2π(f √(x² + z²) + a N)")
    .with_shared_fields(&[COLOR_FIELDS, PATTERN_FIELDS]);

/// Parses a `Textures` block. Its textures replace those of an earlier `Textures` block.
pub(super) fn parse_textures_block<'a>(
    parser: &mut Parser<'a>,
    block: Token<'a>,
) -> Result<Vec<Spanned<TextureDescription>>, SceneError> {
    let mut textures = Vec::new();
    parser.scope.check_precedes_materials(parser.lexer, block)?;
    parser.scope.texture_names.clear();
    let allowed = block_keywords(&["numTextures"], TEXTURE_BLOCK_PARSERS);
    parser.parse_list_block(block, ("numTextures", "texture"), &allowed, |parser, word| {
        let is_taken = |parser: &Parser<'a>, name: &str| parser.scope.texture_names.iter().any(|t| t == name);
        let name = parse_unique_block_name(parser, word, ("texture", "textures"), is_taken)?;
        let (kind, result) = match parse_texture(parser, word) {
            Ok(kind) => (kind, Ok(())),
            // A texture with errors still defines its name, so that references to it cause no more
            // errors.
            Err(error) => (placeholder_texture(), Err(error)),
        };
        parser.scope.texture_names.push(name.clone());
        textures.push(Spanned::new(TextureDescription { name, kind }, word.span()));
        result
    })?;
    Ok(textures)
}

fn placeholder_texture() -> TextureKindDescription {
    TextureKindDescription::Checker { colors: [DVec3::ZERO; 2], uv_transform: TexcoordTransformDescription::default() }
}

fn parse_texture<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<TextureKindDescription, SceneError> {
    let (entry, fields) = parse_block_by_keyword(parser, word, TEXTURE_BLOCK_PARSERS)?;
    (entry.parse)(&fields)
}

fn parse_image_texture(f: &BlockFields<'_>) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Image {
        path: f.value_or_default("file")?,
        encoding: if f.field_word_or_default("encoding")? == "linear" {
            PictureEncoding::Linear
        } else {
            PictureEncoding::Srgb
        },
        wrap: match f.field_word_or_default("wrap")? {
            "clamp" => WrapMode::Clamp,
            "mirror" => WrapMode::Mirror,
            _ => WrapMode::Repeat,
        },
        uv_transform: parse_texcoord_transform(f)?,
    })
}

fn parse_checker_texture(f: &BlockFields<'_>) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Checker { colors: parse_pattern_colors(f)?, uv_transform: parse_texcoord_transform(f)? })
}

/// Converts the fields of a solid texture, which depends on position and not on texture
/// coordinates.
fn parse_solid_pattern(
    f: &BlockFields<'_>,
    pattern: SolidPatternDescription,
) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Solid {
        pattern,
        colors: parse_pattern_colors(f)?,
        octaves: f.value_or_default("octaves")?,
        frequency: f.value_or_default("frequency")?,
        amplitude: f.value_or_default("amplitude")?,
        steps: f.optional_value("Transform").unwrap_or_default(),
    })
}

fn parse_pattern_colors(f: &BlockFields<'_>) -> Result<[DVec3; 2], SceneError> {
    Ok([f.value_or_default("color0")?, f.value_or_default("color1")?])
}

fn parse_texcoord_transform(f: &BlockFields<'_>) -> Result<TexcoordTransformDescription, SceneError> {
    Ok(TexcoordTransformDescription {
        scale: f.value_or_default("scale")?,
        rotation_degrees: f.value_or_default("rotate")?,
        offset: f.value_or_default("offset")?,
    })
}

/// Writes a texture as scene text.
pub(super) fn write_texture(out: &mut SceneWriter<'_, '_>, texture: &TextureDescription) -> fmt::Result {
    let block = match texture.kind {
        TextureKindDescription::Image { .. } => &IMAGE,
        TextureKindDescription::Checker { .. } => &CHECKER,
        TextureKindDescription::Solid { pattern: SolidPatternDescription::Noise, .. } => &NOISE,
        TextureKindDescription::Solid { pattern: SolidPatternDescription::Marble, .. } => &MARBLE,
        TextureKindDescription::Solid { pattern: SolidPatternDescription::Wood, .. } => &WOOD,
    };
    out.begin_named_block(block, &texture.name)?;
    match &texture.kind {
        TextureKindDescription::Image { path, encoding, wrap, uv_transform: coordinates } => {
            out.write_name_field("file", path)?;
            let encoding = match encoding {
                PictureEncoding::Srgb => "srgb",
                PictureEncoding::Linear => "linear",
            };
            out.write_field("encoding", encoding)?;
            let wrap = match wrap {
                WrapMode::Repeat => "repeat",
                WrapMode::Clamp => "clamp",
                WrapMode::Mirror => "mirror",
            };
            out.write_field("wrap", wrap)?;
            write_texcoord_transform(out, coordinates)?;
        }
        TextureKindDescription::Checker { colors, uv_transform: coordinates } => {
            write_pattern_colors(out, colors)?;
            write_texcoord_transform(out, coordinates)?;
        }
        TextureKindDescription::Solid { pattern: _, colors, octaves, frequency, amplitude, steps } => {
            write_pattern_colors(out, colors)?;
            out.write_field("octaves", octaves)?;
            out.write_number("frequency", *frequency)?;
            out.write_number("amplitude", *amplitude)?;
            write_transform_field(out, steps)?;
        }
    }
    out.end_block()
}

fn write_pattern_colors(out: &mut SceneWriter<'_, '_>, colors: &[DVec3; 2]) -> fmt::Result {
    out.write_vec3("color0", colors[0])?;
    out.write_vec3("color1", colors[1])
}

fn write_texcoord_transform(out: &mut SceneWriter<'_, '_>, coordinates: &TexcoordTransformDescription) -> fmt::Result {
    out.write_vec2("scale", coordinates.scale)?;
    out.write_number("rotate", coordinates.rotation_degrees)?;
    out.write_vec2("offset", coordinates.offset)
}

/// Adds all `textures` of the description to the scene.
pub(super) fn add_textures<'a>(
    r: &mut Resolver<'a>,
    textures: &'a [Spanned<TextureDescription>],
) -> Result<(), SceneError> {
    for texture in textures {
        let added = match &texture.kind {
            TextureKindDescription::Image { path, encoding, wrap, uv_transform: coordinates } => {
                let content = match encoding {
                    PictureEncoding::Srgb => PixelMeaning::Color,
                    PictureEncoding::Linear => PixelMeaning::NonColor,
                };
                r.add_picture_texture(path, content, *wrap, texcoord_transform(coordinates))?
            }
            TextureKindDescription::Checker { colors, uv_transform: coordinates } => {
                let checker =
                    Texture::Checkerboard(Checkerboard { colors: colors.map(rgb) }, texcoord_transform(coordinates));
                r.add_texture(checker, false)
            }
            TextureKindDescription::Solid { pattern, colors, octaves, frequency, amplitude, steps } => {
                let to_object = Transform::new(TransformStep::composed_matrix(steps))
                    .map_err(|e| r.error_at(texture.span, &e.to_string(), SINGULAR_REMEDY))?;
                let solid = SolidTexture {
                    kind: match pattern {
                        SolidPatternDescription::Noise => SolidPattern::Noise,
                        SolidPatternDescription::Marble => SolidPattern::Marble,
                        SolidPatternDescription::Wood => SolidPattern::Wood,
                    },
                    colors: colors.map(rgb),
                    octaves: *octaves,
                    frequency: *frequency,
                    amplitude: *amplitude,
                    object_to_pattern: *to_object.inverse(),
                };
                r.add_texture(Texture::Solid(solid), false)
            }
        };
        r.textures.insert(&texture.name, added);
    }
    Ok(())
}

fn texcoord_transform(coordinates: &TexcoordTransformDescription) -> UvTransform {
    let TexcoordTransformDescription { scale, rotation_degrees: rotate, offset } = *coordinates;
    UvTransform::new(scale, rotate.to_radians(), offset)
}
