//! From text to description: recursive descent, one file a part of the language.
//!
//! What the text alone shows to be wrong is refused here, at its place; nothing is looked up but materials.

mod camera;
mod fields;
mod lights;
mod maps;
mod materials;
mod media;
mod objects;
mod refraction;
mod suggest;
mod surfaces;
#[cfg(test)]
mod tests;
mod textures;

use std::collections::HashMap;

use glam::DVec3;

use super::description::{Description, Material, Medium, Span, Spanned, Texture};
use super::error::{SceneError, Source};
use super::lexer::{Lexer, Token};
use camera::CAMERAS;
use fields::Kind;
use materials::Reach;
pub(super) use materials::is_identifier;
pub(super) use suggest::nearest;

/// The blocks of a file.
const BLOCKS: [&str; 10] = [
    "PerspectiveCamera",
    "OrthographicCamera",
    "EnvironmentCamera",
    "Moving",
    "Background",
    "Lights",
    "Textures",
    "Media",
    "Materials",
    "Group",
];

/// Reads `text` as a scene; errors call it `name`.
///
/// # Errors
/// The first thing that is wrong, with its place and the remedy.
pub fn parse(name: &str, text: &str) -> Result<Description, SceneError> {
    Parser {
        lexer: Lexer::new(name, text),
        open: Vec::new(),
        depth: 0,
        textures: Vec::new(),
        media: Vec::new(),
        materials: Vec::new(),
        names: HashMap::new(),
        reach: Vec::new(),
        indexed: false,
        late: None,
    }
    .file()
}

/// Reads a file's `bytes` as a scene; errors call it `name`.
///
/// # Errors
/// Where the bytes are not UTF-8, and as [`parse`].
pub fn parse_bytes(name: &str, bytes: &[u8]) -> Result<Description, SceneError> {
    let error = match std::str::from_utf8(bytes) {
        Ok(text) => return parse(name, text),
        Err(error) => error,
    };
    // Repairing what follows leaves the place of the first bad byte as it is.
    let source = Source::new(name, &String::from_utf8_lossy(bytes));
    let at = error.valid_up_to();
    let message = format!("the byte {:#04x} at offset {at} is not UTF-8", bytes[at]);
    let help = match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "the file looks like UTF-16: save it as UTF-8",
        _ => "save the file as UTF-8 text",
    };
    Err(SceneError::at(&source, Span { start: at, len: 3 }, message, "not text", help))
}

struct Parser<'a> {
    lexer: Lexer<'a>,
    /// Keywords of the blocks around the place that is read.
    open: Vec<Token<'a>>,
    /// Groups and transforms around the place that is read.
    depth: usize,
    /// Of the last `Textures` block so far.
    textures: Vec<Spanned<Texture>>,
    /// Of the last `Media` block so far.
    media: Vec<Spanned<Medium>>,
    /// Of the last `Materials` block so far, by index and by name.
    materials: Vec<Spanned<Material>>,
    names: HashMap<String, usize>,
    /// For each material what light may find behind it.
    reach: Vec<Reach>,
    /// Whether the last `Group` so far names a material.
    indexed: bool,
    /// A `Materials` block that replaced those that the last `Group` so far names.
    late: Option<Token<'a>>,
}

impl<'a> Parser<'a> {
    fn file(mut self) -> Result<Description, SceneError> {
        let mut camera = None;
        let mut background = (DVec3::splat(0.5), None);
        let mut lights = Vec::new();
        let mut root = None;
        loop {
            let word = self.lexer.peek();
            if word.is_end() {
                break;
            }
            self.lexer.take(word);
            // A block that comes again replaces the one before, as in the course.
            match word.text {
                "Moving" => camera = Some(self.moving_camera(word)?),
                text if CAMERAS.contains(&text) => camera = Some(Spanned::new(self.camera(word)?, word.span())),
                "Background" => background = self.background(word)?,
                "Lights" => lights = self.lights(word)?,
                "Textures" => self.textures(word)?,
                "Media" => self.media(word)?,
                "Materials" => self.materials(word)?,
                "Group" => {
                    (self.indexed, self.late) = (false, None);
                    root = Some(self.group(word)?);
                }
                _ => return Err(self.unexpected(word, &BLOCKS)),
            }
        }
        if let Some(block) = self.late {
            let message = "these `Materials` replace those that the `Group` before them uses".to_owned();
            let help = "put all materials into one block before the Group".to_owned();
            return Err(self.lexer.error(block.span(), message, "too late", help));
        }
        let (background, filling) = background;
        if let Some(name) = &filling {
            self.check_medium(name, "in the file")?;
        }
        let camera = camera.ok_or_else(|| {
            let help = "add `PerspectiveCamera { center 0 0 10 direction 0 0 -1 up 0 1 0 angle 30 }`";
            SceneError::of_file(&self.lexer.source(), "the file has no camera", help)
        })?;
        let root = root.ok_or_else(|| {
            let help = "add `Group { … }` with the objects of the scene";
            SceneError::of_file(&self.lexer.source(), "the file has no Group", help)
        })?;
        let Self { textures, media, materials, .. } = self;
        Ok(Description { camera, background, filling, lights, textures, media, materials, root })
    }

    /// Its colour, and the name of the medium that fills the scene.
    fn background(&mut self, block: Token<'a>) -> Result<(DVec3, Option<Spanned<String>>), SceneError> {
        let f = self.fields(block, &[("color", Kind::Vector), ("medium", Kind::Name)])?;
        let color = f.get("color").map_or(Ok(DVec3::splat(0.5)), |color| color.colour())?;
        Ok((color, f.get("medium").map(|medium| medium.text())))
    }

    /// Reads the `{` after a block's keyword.
    fn open(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
        self.open.push(keyword);
        self.punctuation("{")
    }

    fn punctuation(&mut self, mark: &str) -> Result<(), SceneError> {
        let token = self.lexer.peek();
        if token.text == mark {
            self.lexer.take(token);
            return Ok(());
        }
        if token.is_end() {
            return Err(self.unclosed());
        }
        let block = self.block_name();
        let message = format!("expected `{mark}` in {block}, found `{}`", clip(token.text));
        Err(self.lexer.error(token.span(), message, "here", format!("put `{mark}` before it")))
    }

    /// The next word of the innermost block, or none at its `}`.
    fn word(&mut self) -> Result<Option<Token<'a>>, SceneError> {
        let token = self.lexer.peek();
        if token.is_end() {
            return Err(self.unclosed());
        }
        self.lexer.take(token);
        if token.text == "}" {
            self.open.pop();
            return Ok(None);
        }
        Ok(Some(token))
    }

    /// The `N` numbers of the field `owner`.
    fn numbers<const N: usize>(&mut self, owner: Token<'a>) -> Result<Spanned<[f64; N]>, SceneError> {
        let mut values = [0.0; N];
        let mut span: Option<Span> = None;
        for value in &mut values {
            let token = self.lexer.number();
            if token.is_end() {
                return Err(self.no_number(owner, N, "number"));
            }
            // The prefix is a number by construction; what overflows becomes infinite.
            *value = token.text.parse().unwrap_or(f64::NAN);
            if !value.is_finite() {
                let message = format!("`{}` is too large for a number", clip(token.text));
                let help = "numbers reach up to 1.7e308".to_owned();
                return Err(self.lexer.error(token.span(), message, "too large", help));
            }
            let start = span.map_or(token.start, |s| s.start);
            span = Some(Span { start, len: token.start + token.text.len() - start });
        }
        Ok(Spanned::new(values, span.unwrap_or_default()))
    }

    /// The whole number of the field `owner`.
    fn integer(&mut self, owner: Token<'a>) -> Result<Spanned<u32>, SceneError> {
        let fraction = { self.lexer }.number();
        let token = self.lexer.integer();
        if token.is_end() {
            return Err(self.no_number(owner, 1, "whole number"));
        }
        let name = owner.text;
        let help = format!("write a whole number: `{name} 1`");
        if token.text.len() < fraction.text.len() {
            let message = format!("`{name}` wants a whole number, found `{}`", clip(fraction.text));
            return Err(self.lexer.error(fraction.span(), message, "not whole", help));
        }
        match token.text.parse() {
            Ok(value) => Ok(Spanned::new(value, token.span())),
            Err(_) => {
                let message = format!("`{name}` lies outside 0 … {}", u32::MAX);
                Err(self.lexer.error(token.span(), message, "out of range", help))
            }
        }
    }

    fn no_number(&mut self, owner: Token<'a>, wanted: usize, kind: &str) -> SceneError {
        let token = self.lexer.peek();
        if token.is_end() {
            return self.unclosed();
        }
        let (name, found) = (owner.text, clip(token.text));
        let bare = token.text.trim_start_matches(['+', '-']).to_ascii_lowercase();
        if ["nan", "inf", "infinity"].contains(&bare.as_str()) {
            let message = format!("`{found}` is not a finite number");
            return self.lexer.error(token.span(), message, "not finite", format!("give `{name}` a finite value"));
        }
        let message = match wanted {
            1 => format!("`{name}` wants a {kind}, found `{found}`"),
            n => format!("`{name}` wants {n} numbers, found `{found}`"),
        };
        let help = match wanted {
            _ if token.text.starts_with(',') => "part numbers by spaces, not by commas".to_owned(),
            1 => format!("write a {kind}: `{name} 1`"),
            3 => format!("write three numbers: `{name} 0 0 1`"),
            n => format!("write {n} numbers, parted by spaces"),
        };
        self.lexer.error(token.span(), message, &format!("a {kind} belongs here"), help)
    }

    /// Reads the number of a count, which [`check_count`](Self::check_count) later compares with what came.
    fn count(&mut self, word: Token<'a>, count: &mut Option<Spanned<u32>>) -> Result<(), SceneError> {
        if count.is_some() {
            return Err(self.twice(word));
        }
        *count = Some(self.integer(word)?);
        Ok(())
    }

    fn check_count(&self, name: &str, count: Option<Spanned<u32>>, found: usize, what: &str) -> Result<(), SceneError> {
        match count {
            Some(count) if count.value as usize != found => {
                let follow = if found == 1 { " follows" } else { "s follow" };
                let message = format!("`{name}` is {}, but {found} {what}{follow}", count.value);
                let help = format!("write `{name} {found}`, or leave the count out");
                Err(self.lexer.error(count.span, message, "does not match", help))
            }
            _ => Ok(()),
        }
    }

    fn twice(&self, word: Token<'a>) -> SceneError {
        let message = format!("`{}` is given twice in {}", word.text, self.block_name());
        self.lexer.error(word.span(), message, "the second", "keep one of them".to_owned())
    }

    /// The file ends inside a block.
    fn unclosed(&self) -> SceneError {
        let block = self.open.last().copied().unwrap_or(Token { text: "", start: 0 });
        let message = format!("the file ends inside `{}`", block.text);
        self.lexer.error(block.span(), message, "opened here", "close it with `}`".to_owned())
    }

    fn block_name(&self) -> String {
        self.open.last().map_or("the file".to_owned(), |block| format!("`{}`", block.text))
    }

    fn unexpected(&self, word: Token<'a>, allowed: &[&str]) -> SceneError {
        let block = self.block_name();
        let help = if let Some(nearest) = suggest::nearest(word.text, allowed.iter().copied()) {
            format!("did you mean `{nearest}`?")
        } else if self.open.is_empty() && word.text == "}" {
            "it closes nothing: remove it, or look for one too many before it".to_owned()
        } else {
            let or = if self.open.is_empty() { "" } else { "; or is a `}` missing before it?" };
            format!("{block} may hold {}{or}", allowed.join(", "))
        };
        self.lexer.error(word.span(), format!("unexpected `{}` in {block}", clip(word.text)), "not known here", help)
    }
}

/// Whether `v` can be normalised: its squared length neither vanishes nor overflows.
fn has_direction(v: DVec3) -> bool {
    v.length_squared().is_normal()
}

/// The start of a text that may be too long to show, or hold what a terminal should not see.
fn clip(text: &str) -> String {
    let start: String = text.chars().take(40).collect();
    let more = if start.len() < text.len() { "…" } else { "" };
    let words: Vec<&str> = start.split_whitespace().collect();
    words.join(" ").replace(char::is_control, "\u{fffd}") + more
}
