//! The scene language: from text to description and back.
//!
//! Each part of the language has one file: tables of its blocks, the functions that read them, and
//! those that print them. Errors that the text alone shows are reported here, with their position.
//! Files are looked up later, by [`resolve`](super::resolve).

mod camera;
mod curves;
mod fields;
mod lexer;
mod lights;
mod maps;
mod materials;
mod media;
mod names;
mod objects;
mod reader;
mod refraction;
mod schema;
mod scope;
mod shapes;
mod suggest;
#[cfg(test)]
mod tests;
mod text;
mod textures;
mod writer;

use std::fmt::{self, Display, Formatter};

use glam::DVec3;

use super::description::{CameraDescription, Group, LightDescription, SceneDescription, Span, Spanned};
use super::error::{SceneError, SourceText};
use camera::{CAMERAS, camera, moving_camera, write_camera};
use fields::fields;
use lexer::Token;
use lights::{LIGHTS, lights, write_light};
use materials::{MATERIALS, materials, write_material};
use media::{MEDIA, media, write_medium};
use objects::{group, write_group};
use reader::Parser;
use schema::{Block, Kind, Range, blocks, field, find, keywords};
use shapes::SHAPES;
pub(super) use suggest::nearest;
use textures::{TEXTURES, textures, write_texture};
use writer::Writer;

static BACKGROUND: Block = Block {
    keyword: "Background",
    aliases: &[],
    fields: &[
        field("color", Kind::Color, Range::NonNegative, "radiance of rays that leave the scene")
            .or(&[0.5, 0.5, 0.5])
            .unit("W/(m² sr)")
            .course(),
        field("medium", Kind::Name, Range::Any, "medium that fills the space outside all bodies").absent("none"),
    ],
    shared: &[],
    help: "what lies behind all objects",
    course: true,
};

/// Blocks of a file besides cameras and `Background`.
const BLOCKS: [&str; 6] = ["Moving", "Lights", "Textures", "Media", "Materials", "Group"];

/// Tables that the reference documents, with the names of their sections.
fn sections() -> [(&'static str, Vec<&'static Block>); 7] {
    [
        ("cameras", blocks(&CAMERAS)),
        ("background", vec![&BACKGROUND]),
        ("lights", blocks(&LIGHTS)),
        ("textures", blocks(&TEXTURES)),
        ("media", blocks(&MEDIA)),
        ("materials", blocks(&MATERIALS)),
        ("shapes", blocks(&SHAPES)),
    ]
}

/// Iterates over all blocks that have a table.
#[cfg(test)]
fn all_blocks() -> impl Iterator<Item = &'static Block> {
    sections().into_iter().flat_map(|(_, blocks)| blocks)
}

/// Returns `page` with its reference tables replaced by those of the language.
///
/// A table stands between the lines `<!-- reference: NAME -->` and `<!-- end of reference -->`;
/// NAME is one of cameras, background, lights, textures, media, materials and shapes. Other text
/// stays.
#[must_use]
pub fn with_reference(page: &str) -> String {
    const END: &str = "<!-- end of reference -->";
    let mut page = page.to_owned();
    for (name, blocks) in sections() {
        let start = format!("<!-- reference: {name} -->\n");
        let Some(from) = page.find(&start).map(|at| at + start.len()) else { continue };
        let Some(len) = page[from..].find(END) else { continue };
        page.replace_range(from..from + len, &format!("\n{}\n", schema::reference(&blocks)));
    }
    page
}

/// Reads `text` as a scene; errors call it `name`.
///
/// # Errors
/// Up to 20 errors as one [`SceneError`], each with its position and remedy.
pub fn parse(name: &str, text: &str) -> Result<SceneDescription, SceneError> {
    let mut parser = Parser::new(name, text);
    let result = file(&mut parser);
    let (description, last) = match result {
        Ok(description) => (Some(description), None),
        Err(error) => (None, Some(error)),
    };
    match (parser.all_errors(last), description) {
        (None, Some(description)) => Ok(description),
        (Some(error), _) => Err(error),
        (None, None) => unreachable!("a scene is read, or has an error"),
    }
}

/// Reads a file's `bytes` as a scene; errors call it `name`.
///
/// # Errors
/// As for [`parse`], and if the bytes are not UTF-8.
pub fn parse_bytes(name: &str, bytes: &[u8]) -> Result<SceneDescription, SceneError> {
    let error = match std::str::from_utf8(bytes) {
        Ok(text) => return parse(name, text),
        Err(error) => error,
    };
    // The lossy conversion does not move the first bad byte.
    let source = SourceText::new(name, &String::from_utf8_lossy(bytes));
    let at = error.valid_up_to();
    let message = format!("the byte {:#04x} at offset {at} is not UTF-8", bytes[at]);
    let help = match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "the file looks like UTF-16: save it as UTF-8",
        _ => "save the file as UTF-8 text",
    };
    Err(SceneError::at(&source, Span { start: at, len: 3 }, message, "not text", help))
}

/// Blocks of a file that are no part of the scope.
#[derive(Default)]
struct Parts {
    camera: Option<Spanned<CameraDescription>>,
    background: Option<(DVec3, Option<Spanned<String>>)>,
    lights: Vec<Spanned<LightDescription>>,
    root: Option<Group>,
}

/// Reads a whole file.
fn file(parser: &mut Parser<'_>) -> Result<SceneDescription, SceneError> {
    let allowed = [&keywords(&[], &CAMERAS)[..], &[BACKGROUND.keyword], &BLOCKS].concat();
    let mut parts = Parts::default();
    loop {
        let word = parser.lexer.peek();
        if word.is_end() {
            break;
        }
        parser.lexer.take(word);
        parser.recover(&allowed, |parser| block(parser, word, &allowed, &mut parts))?;
    }
    if let Some(block) = parser.scope.late_materials {
        let message = "these `Materials` replace those that the `Group` before them uses".to_owned();
        let help = "put all materials into one block before the Group".to_owned();
        return Err(parser.lexer.error(block.span(), message, "too late", help));
    }
    let Parts { camera, background, lights, root } = parts;
    let (background, ambient_medium) = background.unwrap_or((DVec3::splat(0.5), None));
    if let Some(name) = &ambient_medium {
        parser.scope.check_medium(parser.lexer, name, "in the file")?;
    }
    // A block may be missing because it could not be read.
    if let Some(error) = parser.errors.pop() {
        return Err(error);
    }
    let camera = camera.ok_or_else(|| {
        let help = "add `PerspectiveCamera { center 0 0 10 direction 0 0 -1 up 0 1 0 angle 30 }`";
        SceneError::of_file(&parser.lexer.source(), "the file has no camera", help)
    })?;
    let root = root.ok_or_else(|| {
        let help = "add `Group { … }` with the objects of the scene";
        SceneError::of_file(&parser.lexer.source(), "the file has no Group", help)
    })?;
    let scope = std::mem::take(&mut parser.scope);
    let (textures, media, materials) = (scope.textures, scope.media, scope.materials);
    Ok(SceneDescription { camera, background, ambient_medium, lights, textures, media, materials, root })
}

/// Reads the block that starts with `word`. It replaces an earlier one of its kind, as in MIT
/// 6.837.
fn block<'a>(parser: &mut Parser<'a>, word: Token<'a>, allowed: &[&str], parts: &mut Parts) -> Result<(), SceneError> {
    match word.text {
        "Moving" => parts.camera = Some(moving_camera(parser, word)?),
        "Background" => {
            let f = fields(parser, word, &BACKGROUND)?;
            parts.background = Some((f.vector("color")?, f.get("medium").map(|medium| medium.text())));
        }
        "Lights" => parts.lights = lights(parser, word)?,
        "Textures" => textures(parser, word)?,
        "Media" => media(parser, word)?,
        "Materials" => materials(parser, word)?,
        "Group" => {
            (parser.scope.group_uses_materials, parser.scope.late_materials) = (false, None);
            parts.root = Some(group(parser, word)?);
        }
        text if find(&CAMERAS, text).is_some() => {
            parts.camera = Some(Spanned::new(camera(parser, word)?, word.span()));
        }
        _ => return Err(parser.unexpected(word, allowed)),
    }
    Ok(())
}

impl Display for SceneDescription {
    /// Prints the scene as text in one canonical form, which reads back as an equal description.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let out = &mut Writer::new(f);
        write_camera(out, &self.camera)?;
        out.start(&BACKGROUND)?;
        out.vector("color", self.background)?;
        self.ambient_medium.as_ref().map_or(Ok(()), |medium| out.name("medium", medium))?;
        out.close()?;
        write_list(out, "Lights", "numLights", &self.lights, write_light)?;
        write_list(out, "Textures", "numTextures", &self.textures, write_texture)?;
        write_list(out, "Media", "numMedia", &self.media, write_medium)?;
        write_list(out, "Materials", "numMaterials", &self.materials, write_material)?;
        write_group(out, &self.root)
    }
}

/// Prints a list block with its count; nothing if it is empty.
fn write_list<T>(
    out: &mut Writer<'_, '_>,
    keyword: &str,
    count: &str,
    list: &[Spanned<T>],
    write: fn(&mut Writer<'_, '_>, &T) -> fmt::Result,
) -> fmt::Result {
    if list.is_empty() {
        return Ok(());
    }
    out.open(keyword)?;
    out.line(format_args!("{count} {}", list.len()))?;
    list.iter().try_for_each(|entry| write(out, entry))?;
    out.close()
}
