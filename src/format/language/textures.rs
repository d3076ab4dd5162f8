//! Textures.

use std::fmt;

use glam::DVec3;

use super::super::description::{
    PictureEncoding, SolidPatternDescription, Spanned, TexcoordTransformDescription, TextureDescription,
    TextureKindDescription, Wrap,
};
use super::super::error::SceneError;
use super::fields::{Fields, fields};
use super::lexer::Token;
use super::maps::write_bare_maps;
use super::names::required_name;
use super::reader::Parser;
use super::schema::{Block, Entry, Field, Kind, Range, field, find, keywords};
use super::writer::Writer;

/// The textures.
pub(super) static TEXTURES: [Entry<ReadTexture>; 5] = [
    Entry { block: &IMAGE, read: image },
    Entry { block: &CHECKER, read: checker },
    Entry { block: &NOISE, read: |f| solid(f, SolidPatternDescription::Noise) },
    Entry { block: &MARBLE, read: |f| solid(f, SolidPatternDescription::Marble) },
    Entry { block: &WOOD, read: |f| solid(f, SolidPatternDescription::Wood) },
];

/// Reader of the fields of a texture.
type ReadTexture = fn(&Fields<'_>) -> Result<TextureKindDescription, SceneError>;

static COORDINATES: [Field; 3] = [
    field("scale", Kind::Pair, Range::NonZero, "factors of u and v").or(&[1.0, 1.0]),
    field("rotate", Kind::Number, Range::Any, "rotation of (u, v) after that, anticlockwise")
        .or(&[0.0])
        .unit("degrees"),
    field("offset", Kind::Pair, Range::Any, "offset of (u, v) after that").or(&[0.0, 0.0]),
];

static COLORS: [Field; 2] = [
    field("color0", Kind::Color, Range::NonNegative, "first color; of a checker where ⌊u⌋ + ⌊v⌋ is even")
        .or(&[0.0, 0.0, 0.0]),
    field("color1", Kind::Color, Range::NonNegative, "second color").or(&[1.0, 1.0, 1.0]),
];

// The last octave is 32,768 times finer than the first.
static PATTERN: [Field; 4] = [
    field("octaves", Kind::Whole, Range::Within(1.0, 16.0), "octaves of noise").or(&[4.0]),
    field("frequency", Kind::Number, Range::Positive, "frequency f of the first octave, of veins and of rings")
        .or(&[1.0])
        .unit("1/length"),
    field("amplitude", Kind::Number, Range::NonNegative, "factor a of the noise").or(&[1.0]),
    field("Transform", Kind::Maps, Range::Any, "maps from the pattern's space to the object's").absent("none"),
];

static IMAGE: Block = Block {
    keyword: "Image",
    aliases: &[],
    fields: &[
        field("file", Kind::Name, Range::Any, "picture: PNG, OpenEXR or Radiance HDR").required(),
        field(
            "encoding",
            Kind::Word(&["srgb", "linear"]),
            Range::Any,
            "encoding of a PNG; other formats are always linear",
        )
        .or_word("srgb"),
        field("wrap", Kind::Word(&["repeat", "clamp", "mirror"]), Range::Any, "continuation beyond the edges")
            .or_word("repeat"),
    ],
    shared: &[&COORDINATES],
    help: "a picture, which covers the unit square of texture coordinates",
    course: false,
};

static CHECKER: Block = Block {
    keyword: "Checker",
    aliases: &[],
    fields: &[],
    shared: &[&COLORS, &COORDINATES],
    help: "squares of side 1 in texture coordinates",
    course: false,
};

static NOISE: Block = Block {
    keyword: "Noise",
    aliases: &[],
    fields: &[],
    shared: &[&COLORS, &PATTERN],
    help: "solid noise, t = ½ + ½ a N, clamped to 0 … 1: clouds, lumps",
    course: false,
};

static MARBLE: Block = Block {
    keyword: "Marble",
    aliases: &[],
    fields: &[],
    shared: &[&COLORS, &PATTERN],
    help: "solid veins across the x axis, t = ½ + ½ sin 2π(f x + a N)",
    course: false,
};

static WOOD: Block = Block {
    keyword: "Wood",
    aliases: &[],
    fields: &[],
    shared: &[&COLORS, &PATTERN],
    help: "solid rings about the y axis, t = ½ + ½ sin 2π(f √(x² + z²) + a N)",
    course: false,
};

/// Reads a `Textures` block.
pub(super) fn textures<'a>(parser: &mut Parser<'a>, block: Token<'a>) -> Result<(), SceneError> {
    if !parser.scope.materials.is_empty() {
        let message = "`Textures` stand behind the `Materials` that may use them".to_owned();
        let help = "put the Textures ahead of the Materials".to_owned();
        return Err(parser.lexer.error(block.span(), message, "too late", help));
    }
    parser.scope.textures.clear();
    parser.list(block, ("numTextures", "texture"), &keywords(&["numTextures"], &TEXTURES), |parser, word| {
        let taken = |parser: &Parser<'a>, name: &str| parser.scope.textures.iter().any(|t| t.value.name == name);
        let name = required_name(parser, word, ("texture", "textures"), taken)?;
        let kind = texture(parser, word);
        // A texture with errors still defines its name, so that materials can refer to it.
        let placeholder = || TextureKindDescription::Checker {
            colors: [DVec3::ZERO; 2],
            coordinates: TexcoordTransformDescription::default(),
        };
        let (kind, error) = match kind {
            Ok(kind) => (kind, Ok(())),
            Err(error) => (placeholder(), Err(error)),
        };
        parser.scope.textures.push(Spanned::new(TextureDescription { name, kind }, word.span()));
        error
    })
}

/// Reads the fields of a texture.
fn texture<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<TextureKindDescription, SceneError> {
    let Some(entry) = find(&TEXTURES, word.text) else {
        return Err(parser.unexpected(word, &keywords(&[], &TEXTURES)));
    };
    (entry.read)(&fields(parser, word, entry.block)?)
}

fn image(f: &Fields<'_>) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Image {
        path: f.require("file")?.text(),
        encoding: if f.word("encoding")? == "linear" { PictureEncoding::Linear } else { PictureEncoding::Srgb },
        wrap: match f.word("wrap")? {
            "clamp" => Wrap::Clamp,
            "mirror" => Wrap::Mirror,
            _ => Wrap::Repeat,
        },
        coordinates: coordinates(f)?,
    })
}

fn checker(f: &Fields<'_>) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Checker { colors: colors(f)?, coordinates: coordinates(f)? })
}

/// Returns a solid pattern.
fn solid(f: &Fields<'_>, pattern: SolidPatternDescription) -> Result<TextureKindDescription, SceneError> {
    Ok(TextureKindDescription::Solid {
        pattern,
        colors: colors(f)?,
        octaves: f.whole("octaves")?,
        frequency: f.number("frequency")?,
        amplitude: f.number("amplitude")?,
        maps: f.maps("Transform"),
    })
}

fn colors(f: &Fields<'_>) -> Result<[DVec3; 2], SceneError> {
    Ok([f.vector("color0")?, f.vector("color1")?])
}

fn coordinates(f: &Fields<'_>) -> Result<TexcoordTransformDescription, SceneError> {
    Ok(TexcoordTransformDescription { scale: f.pair("scale")?, rotate: f.number("rotate")?, offset: f.pair("offset")? })
}

/// Prints a texture.
pub(super) fn write_texture(out: &mut Writer<'_, '_>, texture: &TextureDescription) -> fmt::Result {
    let block = match texture.kind {
        TextureKindDescription::Image { .. } => &IMAGE,
        TextureKindDescription::Checker { .. } => &CHECKER,
        TextureKindDescription::Solid { pattern: SolidPatternDescription::Noise, .. } => &NOISE,
        TextureKindDescription::Solid { pattern: SolidPatternDescription::Marble, .. } => &MARBLE,
        TextureKindDescription::Solid { pattern: SolidPatternDescription::Wood, .. } => &WOOD,
    };
    out.start_named(block, &texture.name)?;
    match &texture.kind {
        TextureKindDescription::Image { path, encoding, wrap, coordinates } => {
            out.name("file", path)?;
            let encoding = match encoding {
                PictureEncoding::Srgb => "srgb",
                PictureEncoding::Linear => "linear",
            };
            out.field("encoding", encoding)?;
            let wrap = match wrap {
                Wrap::Repeat => "repeat",
                Wrap::Clamp => "clamp",
                Wrap::Mirror => "mirror",
            };
            out.field("wrap", wrap)?;
            write_coordinates(out, coordinates)?;
        }
        TextureKindDescription::Checker { colors, coordinates } => {
            write_colors(out, colors)?;
            write_coordinates(out, coordinates)?;
        }
        TextureKindDescription::Solid { pattern: _, colors, octaves, frequency, amplitude, maps } => {
            write_colors(out, colors)?;
            out.field("octaves", octaves)?;
            out.number("frequency", *frequency)?;
            out.number("amplitude", *amplitude)?;
            write_bare_maps(out, maps)?;
        }
    }
    out.close()
}

fn write_colors(out: &mut Writer<'_, '_>, colors: &[DVec3; 2]) -> fmt::Result {
    out.vector("color0", colors[0])?;
    out.vector("color1", colors[1])
}

fn write_coordinates(out: &mut Writer<'_, '_>, coordinates: &TexcoordTransformDescription) -> fmt::Result {
    out.pair("scale", coordinates.scale)?;
    out.number("rotate", coordinates.rotate)?;
    out.pair("offset", coordinates.offset)
}
