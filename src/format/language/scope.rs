//! Names that a scene text has defined so far.

use std::collections::HashMap;

use super::super::description::{MaterialDescription, MediumDescription, Spanned, TextureDescription};
use super::super::error::SceneError;
use super::lexer::{Lexer, Token};
use super::suggest::nearest;
use super::text::clip;

/// Textures, media and materials of the blocks read so far.
#[derive(Default)]
pub(super) struct Scope<'a> {
    /// Textures of the last `Textures` block.
    pub textures: Vec<Spanned<TextureDescription>>,
    /// Media of the last `Media` block.
    pub media: Vec<Spanned<MediumDescription>>,
    /// Materials of the last `Materials` block, by index.
    pub materials: Vec<Spanned<MaterialDescription>>,
    /// Indices of the named materials.
    pub names: HashMap<String, usize>,
    /// Content of each material, by index.
    pub contents: Vec<Contents>,
    /// True if the last `Group` refers to a material.
    pub group_uses_materials: bool,
    /// A `Materials` block that replaces those which the last `Group` refers to.
    pub late_materials: Option<Token<'a>>,
}

/// Components of a material, through all nested mixes.
#[derive(Clone, Copy, Default)]
pub(super) struct Contents {
    /// Index of its `Dielectric`, if it has one.
    pub dielectric: Option<usize>,
    /// Depth of nested mixes; 0 for a material that is no mix.
    pub mixes: u8,
}

impl Scope<'_> {
    /// Forgets all materials.
    pub fn clear_materials(&mut self) {
        self.materials.clear();
        self.names.clear();
        self.contents.clear();
    }

    /// Appends a material.
    pub fn add_material(&mut self, material: Spanned<MaterialDescription>) {
        let kind = &material.value.kind;
        let contents = match kind.mix_parts() {
            Some([first, second]) => {
                let (a, b) = (self.contents(&first.value), self.contents(&second.value));
                Contents { dielectric: a.dielectric.or(b.dielectric), mixes: a.mixes.max(b.mixes) + 1 }
            }
            None => Contents { dielectric: kind.is_dielectric().then_some(self.materials.len()), mixes: 0 },
        };
        self.contents.push(contents);
        self.materials.push(material);
    }

    /// Returns the contents of the material of that name.
    pub fn contents(&self, name: &str) -> Contents {
        self.names.get(name).and_then(|&index| self.contents.get(index)).copied().unwrap_or_default()
    }

    /// Refuses the name of a texture that is not defined.
    pub fn check_texture(&self, lexer: Lexer<'_>, name: &Spanned<String>) -> Result<(), SceneError> {
        let names = || self.textures.iter().map(|texture| texture.value.name.as_str());
        let help = "write numbers, or define it ahead of the Materials: `Textures { Checker name { … } }`";
        check_name(lexer, "texture", name, names, help.to_owned())
    }

    /// Refuses the name of a medium that is not defined; `position` says where to define it.
    pub fn check_medium(&self, lexer: Lexer<'_>, name: &Spanned<String>, position: &str) -> Result<(), SceneError> {
        let names = || self.media.iter().map(|medium| medium.value.name.as_str());
        let help = match self.media.is_empty() {
            true => format!("define it {position}: `Media {{ Medium name {{ … }} }}`"),
            false => {
                let listed: Vec<String> = names().take(8).map(clip).collect();
                format!("known are {}; define it with them", listed.join(", "))
            }
        };
        check_name(lexer, "medium", name, names, help)
    }

    /// Refuses the name of a material that is not defined.
    pub fn check_material(&self, lexer: Lexer<'_>, name: &Spanned<String>, help: &str) -> Result<(), SceneError> {
        if self.names.contains_key(&name.value) {
            return Ok(());
        }
        let names = || self.materials.iter().filter_map(|material| material.name.as_deref());
        check_name(lexer, "material", name, names, help.to_owned())
    }
}

/// Refuses `name` unless it is one of `names`; suggests the nearest, else gives `help`.
fn check_name<'n, I: Iterator<Item = &'n str>>(
    lexer: Lexer<'_>,
    what: &str,
    name: &Spanned<String>,
    names: impl Fn() -> I,
    help: String,
) -> Result<(), SceneError> {
    if names().any(|known| known == name.value) {
        return Ok(());
    }
    let message = format!("no {what} is called `{}`", clip(&name.value));
    let help = nearest(&name.value, names()).map_or(help, |nearest| format!("did you mean `{}`?", clip(nearest)));
    Err(lexer.error(name.span, message, "unknown name", help))
}
