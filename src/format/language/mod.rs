//! The scene language: parses text to a [`SceneDescription`], and writes a description as text.
//!
//! The files of this folder know blocks and fields, but no kinds of lights, materials or shapes.
//! Each part of a scene has a file or folder of its own beside this one, such as
//! [`lights`](super::lights). It holds the schemas of the part's blocks and the functions that
//! parse and write them. Files that the text names are opened later, by
//! [`resolve`](super::resolve()).

pub(super) mod curves;
pub(super) mod field_table;
pub(super) mod field_value;
pub(super) mod fields;
pub(super) mod lexer;
pub(super) mod names;
mod objects;
pub(super) mod parser;
pub(super) mod schema;
pub(super) mod scope;
mod suggest;
#[cfg(test)]
mod tests;
pub(super) mod text;
pub(super) mod transforms;
pub(super) mod writer;

use std::fmt::{self, Display, Formatter};

use glam::DVec3;

use super::camera::{CAMERA_BLOCK_PARSERS, CameraDescription, parse_camera, parse_moving_camera, write_camera};
use super::description::{ObjectGroup, SceneDescription};
use super::error::{SceneError, SourceText};
use super::lights::{LIGHT_BLOCK_PARSERS, LightDescription, parse_lights_block, write_light};
use super::materials::{MATERIAL_BLOCK_PARSERS, MaterialDescription, parse_materials_block, write_material};
use super::media::{MEDIUM_BLOCK_PARSERS, MediumDescription, parse_media_block, write_medium};
use super::shapes::SHAPE_BLOCK_PARSERS;
use super::span::{Span, Spanned};
use super::textures::{TEXTURE_BLOCK_PARSERS, TextureDescription, parse_textures_block, write_texture};
use fields::parse_block_fields;
use lexer::Token;
use objects::{parse_group, write_group};
use parser::Parser;
use schema::{BlockSchema, FieldKind, block_keywords, block_schema, block_schemas, field_schema, find_block};
pub(super) use suggest::nearest_word;
use writer::SceneWriter;

static BACKGROUND: BlockSchema = block_schema("Background", "what lies behind all objects")
    .with_own_fields(&[
        field_schema("color", FieldKind::Color, "radiance of rays that leave the scene")
            .with_default_numbers(&[0.5, 0.5, 0.5])
            .with_unit("W/(m² sr)")
            .mark_as_mit_6837_syntax(),
        field_schema("medium", FieldKind::Name, "medium that fills the space outside all bodies").make_optional("none"),
    ])
    .mark_as_mit_6837_syntax();

/// Keywords of top-level blocks of scene text, except cameras and `Background`.
const FILE_BLOCK_KEYWORDS: [&str; 6] = ["Moving", "Lights", "Textures", "Media", "Materials", "Group"];

/// Returns the sections of the language reference, each with its name and its blocks' schemas.
fn reference_sections() -> [(&'static str, Vec<&'static BlockSchema>); 7] {
    [
        ("cameras", block_schemas(CAMERA_BLOCK_PARSERS)),
        ("background", vec![&BACKGROUND]),
        ("lights", block_schemas(LIGHT_BLOCK_PARSERS)),
        ("textures", block_schemas(TEXTURE_BLOCK_PARSERS)),
        ("media", block_schemas(MEDIUM_BLOCK_PARSERS)),
        ("materials", block_schemas(MATERIAL_BLOCK_PARSERS)),
        ("shapes", block_schemas(SHAPE_BLOCK_PARSERS)),
    ]
}

/// Iterates over the schemas of all blocks.
#[cfg(test)]
pub(super) fn all_block_schemas() -> impl Iterator<Item = &'static BlockSchema> {
    reference_sections().into_iter().flat_map(|(_, blocks)| blocks)
}

/// Returns the Markdown `page` with its tables of the scene language replaced by up-to-date ones.
///
/// A table stands between the lines `<!-- reference: NAME -->` and `<!-- end of reference -->`.
/// NAME is one of cameras, background, lights, textures, media, materials and shapes.
#[must_use]
pub fn update_reference_tables(page: &str) -> String {
    const END: &str = "<!-- end of reference -->";
    let mut page = page.to_owned();
    for (name, blocks) in reference_sections() {
        let start = format!("<!-- reference: {name} -->\n");
        let Some(from) = page.find(&start).map(|at| at + start.len()) else { continue };
        let Some(len) = page[from..].find(END) else { continue };
        page.replace_range(from..from + len, &format!("\n{}\n", schema::reference_markdown(&blocks)));
    }
    page
}

/// Parses the `text` of a scene. Error messages print `name` as the name of the file.
///
/// # Errors
/// Up to 20 errors as one [`SceneError`], each with its position and remedy.
pub fn parse(name: &str, text: &str) -> Result<SceneDescription, SceneError> {
    let mut parser = Parser::new(name, text);
    let (description, last_error) = match parse_all_blocks(&mut parser) {
        Ok(description) => (Some(description), None),
        Err(error) => (None, Some(error)),
    };
    match (parser.into_joined_error(last_error), description) {
        (None, Some(description)) => Ok(description),
        (Some(error), _) => Err(error),
        (None, None) => unreachable!("a scene is read, or has an error"),
    }
}

/// Parses a scene text given as `bytes`. Error messages print `name` as the name of the file.
///
/// # Errors
/// The errors of [`parse`], or an error if the bytes are not UTF-8.
pub fn parse_scene_bytes(name: &str, bytes: &[u8]) -> Result<SceneDescription, SceneError> {
    let error = match std::str::from_utf8(bytes) {
        Ok(text) => return parse(name, text),
        Err(error) => error,
    };
    // Replacing invalid bytes does not move the first of them.
    let source = SourceText::new(name, &String::from_utf8_lossy(bytes));
    let at = error.valid_up_to();
    let message = format!("the byte {:#04x} at offset {at} is not UTF-8", bytes[at]);
    let help = match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "the file looks like UTF-16: save it as UTF-8",
        _ => "save the file as UTF-8 text",
    };
    Err(SceneError::error_at_span(&source, Span { start: at, len: 3 }, message, "not text", help))
}

/// Content of the top-level blocks that were parsed so far.
#[derive(Default)]
struct SceneFileBlocks {
    camera: Option<Spanned<CameraDescription>>,
    /// Radiance of the background \[W/(m² sr)], and the name of the medium outside all bodies, if
    /// one is set. `None` if no `Background` block was parsed.
    background: Option<(DVec3, Option<Spanned<String>>)>,
    lights: Vec<Spanned<LightDescription>>,
    textures: Vec<Spanned<TextureDescription>>,
    media: Vec<Spanned<MediumDescription>>,
    materials: Vec<Spanned<MaterialDescription>>,
    root: Option<ObjectGroup>,
}

/// Parses all blocks of a scene text, and returns the scene description.
fn parse_all_blocks(parser: &mut Parser<'_>) -> Result<SceneDescription, SceneError> {
    let allowed =
        [&block_keywords(&[], CAMERA_BLOCK_PARSERS)[..], &[BACKGROUND.keyword], &FILE_BLOCK_KEYWORDS].concat();
    let mut blocks = SceneFileBlocks::default();
    loop {
        let word = parser.lexer.peek_token();
        if word.is_empty() {
            break;
        }
        parser.lexer.consume_token(word);
        parser.parse_entry_with_recovery(&allowed, |parser| parse_file_block(parser, word, &allowed, &mut blocks))?;
    }
    if let Some(block) = parser.scope.late_materials_keyword {
        let message = "these `Materials` replace those that the `Group` before them uses".to_owned();
        let help = "put all materials into one block before the Group".to_owned();
        return Err(parser.lexer.error_at(block.span(), message, "too late", help));
    }
    let SceneFileBlocks { camera, background, lights, textures, media, materials, root } = blocks;
    let (background, ambient_medium) = background.unwrap_or((DVec3::splat(0.5), None));
    if let Some(name) = &ambient_medium {
        parser.scope.check_medium_exists(parser.lexer, name, "in the file")?;
    }
    // Errors in blocks are reported before missing blocks, because an error may be the reason why
    // a block is missing.
    if let Some(error) = parser.errors.pop() {
        return Err(error);
    }
    let camera = camera.ok_or_else(|| {
        let help = "add `PerspectiveCamera { center 0 0 10 direction 0 0 -1 up 0 1 0 angle 30 }`";
        SceneError::error_for_whole_file(&parser.lexer.source_text(), "the file has no camera", help)
    })?;
    let root = root.ok_or_else(|| {
        let help = "add `Group { … }` with the objects of the scene";
        SceneError::error_for_whole_file(&parser.lexer.source_text(), "the file has no Group", help)
    })?;
    Ok(SceneDescription { camera, background, ambient_medium, lights, textures, media, materials, root })
}

/// Parses a top-level block, and stores its content in `blocks`. The caller has read its keyword
/// `word`.
///
/// The content replaces that of an earlier block of the same kind.
fn parse_file_block<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
    allowed: &[&str],
    blocks: &mut SceneFileBlocks,
) -> Result<(), SceneError> {
    match word.text {
        "Moving" => blocks.camera = Some(parse_moving_camera(parser, word)?),
        "Background" => {
            let f = parse_block_fields(parser, word, &BACKGROUND)?;
            blocks.background = Some((f.value_or_default("color")?, f.optional_value("medium")));
        }
        "Lights" => blocks.lights = parse_lights_block(parser, word)?,
        "Textures" => blocks.textures = parse_textures_block(parser, word)?,
        "Media" => blocks.media = parse_media_block(parser, word)?,
        "Materials" => blocks.materials = parse_materials_block(parser, word)?,
        "Group" => {
            (parser.scope.group_uses_materials, parser.scope.late_materials_keyword) = (false, None);
            blocks.root = Some(parse_group(parser, word)?);
        }
        text if find_block(CAMERA_BLOCK_PARSERS, text).is_some() => {
            blocks.camera = Some(Spanned::new(parse_camera(parser, word)?, word.span()));
        }
        _ => return Err(parser.unexpected_word_error(word, allowed)),
    }
    Ok(())
}

impl Display for SceneDescription {
    /// Writes the scene as text in a canonical form, which parses to an equal description.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let out = &mut SceneWriter::new(f);
        write_camera(out, &self.camera)?;
        out.begin_schema_block(&BACKGROUND)?;
        out.write_vec3("color", self.background)?;
        self.ambient_medium.as_ref().map_or(Ok(()), |medium| out.write_name_field("medium", medium))?;
        out.end_block()?;
        write_list_block(out, "Lights", "numLights", &self.lights, write_light)?;
        write_list_block(out, "Textures", "numTextures", &self.textures, write_texture)?;
        write_list_block(out, "Media", "numMedia", &self.media, write_medium)?;
        write_list_block(out, "Materials", "numMaterials", &self.materials, write_material)?;
        write_group(out, &self.root)
    }
}

/// Writes a list block such as `Lights`: the number of its entries, then the entries.
///
/// `count` is the keyword before the number. An empty `list` writes nothing.
fn write_list_block<T>(
    out: &mut SceneWriter<'_, '_>,
    keyword: &str,
    count: &str,
    list: &[Spanned<T>],
    write: fn(&mut SceneWriter<'_, '_>, &T) -> fmt::Result,
) -> fmt::Result {
    if list.is_empty() {
        return Ok(());
    }
    out.begin_block(keyword)?;
    out.write_line(format_args!("{count} {}", list.len()))?;
    list.iter().try_for_each(|entry| write(out, entry))?;
    out.end_block()
}
