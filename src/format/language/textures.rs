//! Schemas, parsing and writing of texture blocks.

use std::fmt;

use glam::DVec3;

use super::super::description::{
    PictureEncoding, SolidPatternDescription, Spanned, TexcoordTransformDescription, TextureDescription,
    TextureKindDescription, WrapMode,
};
use super::super::error::SceneError;
use super::fields::{BlockFields, parse_block_by_keyword};
use super::lexer::Token;
use super::names::parse_unique_block_name;
use super::parser::Parser;
use super::schema::{
    BlockParser, BlockSchema, FieldKind, FieldRange, FieldSchema, block_keywords, block_schema, field_schema,
};
use super::transforms::write_transform_field;
use super::writer::SceneWriter;

/// Texture blocks of the scene language, each with the function that converts its fields.
pub(super) static TEXTURES: &[BlockParser<ParseTexture>] = &[
    BlockParser { block: &IMAGE, parse: parse_image_texture },
    BlockParser { block: &CHECKER, parse: parse_checker_texture },
    BlockParser { block: &NOISE, parse: |f| parse_solid_pattern(f, SolidPatternDescription::Noise) },
    BlockParser { block: &MARBLE, parse: |f| parse_solid_pattern(f, SolidPatternDescription::Marble) },
    BlockParser { block: &WOOD, parse: |f| parse_solid_pattern(f, SolidPatternDescription::Wood) },
];

/// Function that converts the parsed fields of a texture block to a texture.
type ParseTexture = fn(&BlockFields<'_>) -> Result<TextureKindDescription, SceneError>;

static COORDINATE_FIELDS: &[FieldSchema] = &[
    field_schema("scale", FieldKind::Pair, "factors of u and v")
        .with_range(FieldRange::NonZero)
        .with_default_numbers(&[1.0, 1.0]),
    field_schema("rotate", FieldKind::Number, "rotation of (u, v) after that, anticlockwise")
        .with_default_numbers(&[0.0])
        .with_unit("degrees"),
    field_schema("offset", FieldKind::Pair, "offset of (u, v) after that").with_default_numbers(&[0.0, 0.0]),
];

static COLOR_FIELDS: &[FieldSchema] = &[
    field_schema("color0", FieldKind::Color, "first color; of a checker where ⌊u⌋ + ⌊v⌋ is even")
        .with_default_numbers(&[0.0, 0.0, 0.0]),
    field_schema("color1", FieldKind::Color, "second color").with_default_numbers(&[1.0, 1.0, 1.0]),
];

// The last of 16 octaves is 32,768 times finer than the first.
static PATTERN_FIELDS: &[FieldSchema] = &[
    field_schema("octaves", FieldKind::Whole, "octaves of noise")
        .with_range(FieldRange::Within(1.0, 16.0))
        .with_default_numbers(&[4.0]),
    field_schema("frequency", FieldKind::Number, "frequency f of the first octave, of veins and of rings")
        .with_range(FieldRange::Positive)
        .with_default_numbers(&[1.0])
        .with_unit("1/length"),
    field_schema("amplitude", FieldKind::Number, "factor a of the noise")
        .with_range(FieldRange::NonNegative)
        .with_default_numbers(&[1.0]),
    field_schema("Transform", FieldKind::TransformSteps, "maps from the pattern's space to the object's")
        .with_default_description("none"),
];

static IMAGE: BlockSchema = block_schema("Image", "a picture, which covers the unit square of texture coordinates")
    .with_fields(&[
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
pub(super) fn parse_textures_block<'a>(parser: &mut Parser<'a>, block: Token<'a>) -> Result<(), SceneError> {
    parser.scope.check_precedes_materials(parser.lexer, block)?;
    parser.scope.textures.clear();
    let allowed = block_keywords(&["numTextures"], TEXTURES);
    parser.parse_list_block(block, ("numTextures", "texture"), &allowed, |parser, word| {
        let is_taken = |parser: &Parser<'a>, name: &str| parser.scope.textures.iter().any(|t| t.value.name == name);
        let name = parse_unique_block_name(parser, word, ("texture", "textures"), is_taken)?;
        let (kind, result) = match parse_texture(parser, word) {
            Ok(kind) => (kind, Ok(())),
            // A texture with errors still defines its name, so that references to it cause no more
            // errors.
            Err(error) => (placeholder_texture(), Err(error)),
        };
        parser.scope.textures.push(Spanned::new(TextureDescription { name, kind }, word.span()));
        result
    })
}

fn placeholder_texture() -> TextureKindDescription {
    TextureKindDescription::Checker { colors: [DVec3::ZERO; 2], coordinates: TexcoordTransformDescription::default() }
}

fn parse_texture<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<TextureKindDescription, SceneError> {
    let (entry, fields) = parse_block_by_keyword(parser, word, TEXTURES)?;
    (entry.parse)(&fields)
}

fn parse_image_texture(f: &BlockFields<'_>) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Image {
        path: f.value("file")?,
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
        coordinates: parse_texcoord_transform(f)?,
    })
}

fn parse_checker_texture(f: &BlockFields<'_>) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Checker { colors: parse_pattern_colors(f)?, coordinates: parse_texcoord_transform(f)? })
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
        octaves: f.value("octaves")?,
        frequency: f.value("frequency")?,
        amplitude: f.value("amplitude")?,
        steps: f.optional_value("Transform").unwrap_or_default(),
    })
}

fn parse_pattern_colors(f: &BlockFields<'_>) -> Result<[DVec3; 2], SceneError> {
    Ok([f.value("color0")?, f.value("color1")?])
}

fn parse_texcoord_transform(f: &BlockFields<'_>) -> Result<TexcoordTransformDescription, SceneError> {
    Ok(TexcoordTransformDescription {
        scale: f.value("scale")?,
        rotate: f.value("rotate")?,
        offset: f.value("offset")?,
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
        TextureKindDescription::Image { path, encoding, wrap, coordinates } => {
            out.write_name("file", path)?;
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
        TextureKindDescription::Checker { colors, coordinates } => {
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
    out.write_number("rotate", coordinates.rotate)?;
    out.write_vec2("offset", coordinates.offset)
}
