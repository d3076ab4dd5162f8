//! Names of textures, media and materials that a scene text has defined so far.

use std::collections::HashMap;

use super::lexer::{Lexer, Token};
use super::suggest::nearest_word;
use super::text::clip_for_message;
use crate::format::error::SceneError;
use crate::format::span::Spanned;

/// Names of the textures, media and materials that the text has defined up to the current position.
#[derive(Default)]
pub(in crate::format) struct ParserScope<'a> {
    /// Names of the textures of the latest `Textures` block; each block replaces the one before.
    pub texture_names: Vec<String>,
    /// Names of the media of the latest `Media` block; each block replaces the one before.
    pub medium_names: Vec<String>,
    /// Materials of the latest `Materials` block; each block replaces the one before. Scene text
    /// can refer to them by their indices in this list.
    pub materials: Vec<DefinedMaterial>,
    /// Index into `materials` of each named material, by name.
    pub material_indices: HashMap<String, usize>,
    /// True if the `Group` that was parsed last refers to a material.
    pub group_uses_materials: bool,
    /// Keyword of a `Materials` block after a `Group` in which a material is used; `None` if no
    /// such block was parsed.
    ///
    /// Such a block is an error, because it replaces the materials that the group uses.
    pub late_materials_keyword: Option<Token<'a>>,
}

/// A material that the text has defined: its name, and properties that limit its use in a mix.
pub(in crate::format) struct DefinedMaterial {
    /// Name of the material; `None` if objects can refer to it only by its index.
    pub name: Option<String>,
    /// True if the material is a null interface, a boundary that light crosses unchanged.
    pub is_null_interface: bool,
    /// Properties that limit the material's use in a mix.
    pub mix_constraints: MixConstraints,
}

/// Properties of a material that limit its use in a mix.
#[derive(Clone, Copy, Default)]
pub(in crate::format) struct MixConstraints {
    /// Index into [`ParserScope::materials`] of the dielectric in this material: the material
    /// itself or, if it is a mix, one of its components. `None` if there is no dielectric.
    pub dielectric_material_index: Option<usize>,
    /// Nesting depth of mixes: 0 for a material that is no mix, 1 for a mix of such materials.
    pub mix_depth: u8,
}

impl ParserScope<'_> {
    /// Removes all materials from the scope, with their names.
    pub fn clear_materials(&mut self) {
        self.materials.clear();
        self.material_indices.clear();
    }

    /// Returns the defined material called `name`; `None` if there is none yet.
    pub fn material_by_name(&self, name: &str) -> Option<&DefinedMaterial> {
        self.material_indices.get(name).and_then(|&index| self.materials.get(index))
    }

    /// Returns the [`MixConstraints`] of the material called `name`. An unknown name counts as a
    /// material that is no mix and contains no dielectric.
    pub fn mix_constraints(&self, name: &str) -> MixConstraints {
        self.material_by_name(name).map(|material| material.mix_constraints).unwrap_or_default()
    }

    /// Fails if a `Materials` block was parsed before `block`, a `Textures` or `Media` block.
    /// Materials can use only textures and media that precede them.
    pub fn check_precedes_materials(&self, lexer: Lexer<'_>, block: Token<'_>) -> Result<(), SceneError> {
        if self.materials.is_empty() {
            return Ok(());
        }
        let message = format!("`{}` stand behind the `Materials` that may use them", block.text);
        let help = format!("put the {} ahead of the Materials", block.text);
        Err(lexer.error_at(block.span(), message, "too late", help))
    }

    /// Fails if no texture is called `name`.
    pub fn check_texture_exists(&self, lexer: Lexer<'_>, name: &Spanned<String>) -> Result<(), SceneError> {
        let names = || self.texture_names.iter().map(String::as_str);
        let help = "write numbers, or define it ahead of the Materials: `Textures { Checker name { … } }`";
        check_name_exists(lexer, "texture", name, names, help.to_owned())
    }

    /// Fails if no medium is called `name`.
    ///
    /// If the text has defined no medium, the help text says to define it at `position`, a phrase
    /// such as "in the file".
    pub fn check_medium_exists(
        &self,
        lexer: Lexer<'_>,
        name: &Spanned<String>,
        position: &str,
    ) -> Result<(), SceneError> {
        let names = || self.medium_names.iter().map(String::as_str);
        let help = if self.medium_names.is_empty() {
            format!("define it {position}: `Media {{ Medium name {{ … }} }}`")
        } else {
            let listed: Vec<String> = names().take(8).map(clip_for_message).collect();
            format!("known are {}; define it with them", listed.join(", "))
        };
        check_name_exists(lexer, "medium", name, names, help)
    }

    /// Fails if no material is called `name`.
    ///
    /// The error suggests the most similar name. If no name is similar, its help text is `help`.
    pub fn check_material_exists(
        &self,
        lexer: Lexer<'_>,
        name: &Spanned<String>,
        help: &str,
    ) -> Result<(), SceneError> {
        if self.material_indices.contains_key(&name.value) {
            return Ok(());
        }
        let names = || self.materials.iter().filter_map(|material| material.name.as_deref());
        check_name_exists(lexer, "material", name, names, help.to_owned())
    }
}

/// Fails if `names` do not contain `name`. Error messages call the named thing `what`, such as
/// "texture".
///
/// The error suggests the most similar name. If no name is similar, its help text is `help`.
fn check_name_exists<'n, I: Iterator<Item = &'n str>>(
    lexer: Lexer<'_>,
    what: &str,
    name: &Spanned<String>,
    names: impl Fn() -> I,
    help: String,
) -> Result<(), SceneError> {
    if names().any(|known| known == name.value) {
        return Ok(());
    }
    let message = format!("no {what} is called `{}`", clip_for_message(&name.value));
    let help = nearest_word(&name.value, names())
        .map_or(help, |nearest| format!("did you mean `{}`?", clip_for_message(nearest)));
    Err(lexer.error_at(name.span, message, "unknown name", help))
}
