//! Textures, media and materials that a scene text has defined so far, and lookups of their names.

use std::collections::HashMap;

use super::super::description::{MaterialDescription, MediumDescription, Spanned, TextureDescription};
use super::super::error::SceneError;
use super::lexer::{Lexer, Token};
use super::suggest::nearest_word;
use super::text::clip_for_message;

/// Textures, media and materials that the text has defined up to the current position.
#[derive(Default)]
pub(super) struct ParserScope<'a> {
    /// Textures of the latest `Textures` block; each block replaces the one before.
    pub textures: Vec<Spanned<TextureDescription>>,
    /// Media of the latest `Media` block; each block replaces the one before.
    pub media: Vec<Spanned<MediumDescription>>,
    /// Materials of the latest `Materials` block; each block replaces the one before. A material
    /// index counts them from 0.
    pub materials: Vec<Spanned<MaterialDescription>>,
    /// Index into `materials` of each named material, by name.
    pub material_indices: HashMap<String, usize>,
    /// [`MixConstraints`] of each material, by material index.
    mix_constraints: Vec<MixConstraints>,
    /// True if the last `Group` refers to a material.
    pub group_uses_materials: bool,
    /// Keyword of a `Materials` block that follows a `Group` which refers to a material; `None` if
    /// there is none.
    ///
    /// Such a block is an error, because it replaces the materials that the group uses.
    pub late_materials: Option<Token<'a>>,
}

/// Properties of a material that limit its use in a mix.
#[derive(Clone, Copy, Default)]
pub(super) struct MixConstraints {
    /// Index of a `Dielectric` material: the material itself, or one that it mixes; `None` if it is
    /// no dielectric and mixes none.
    pub dielectric: Option<usize>,
    /// Nesting depth of mixes: 0 for a material that is no mix, 1 for a mix of such materials.
    pub mix_depth: u8,
}

impl ParserScope<'_> {
    /// Removes all materials from the scope, with their names.
    pub fn clear_materials(&mut self) {
        self.materials.clear();
        self.material_indices.clear();
        self.mix_constraints.clear();
    }

    /// Appends `material` to the list of materials, with its [`MixConstraints`]. The caller
    /// registers its name.
    pub fn add_material(&mut self, material: Spanned<MaterialDescription>) {
        let kind = &material.value.kind;
        let summary = match kind.mix_material_names() {
            Some([first, second]) => {
                let (a, b) = (
                    self.constraints_of_mixed_material(&first.value),
                    self.constraints_of_mixed_material(&second.value),
                );
                MixConstraints {
                    dielectric: a.dielectric.or(b.dielectric),
                    mix_depth: a.mix_depth.max(b.mix_depth) + 1,
                }
            }
            None => MixConstraints { dielectric: kind.is_dielectric().then_some(self.materials.len()), mix_depth: 0 },
        };
        self.mix_constraints.push(summary);
        self.materials.push(material);
    }

    /// Returns the [`MixConstraints`] of the material called `name`; for an unknown name, mix depth
    /// 0 and no dielectric.
    pub fn constraints_of_mixed_material(&self, name: &str) -> MixConstraints {
        self.material_indices.get(name).and_then(|&index| self.mix_constraints.get(index)).copied().unwrap_or_default()
    }

    /// Fails if materials are already defined. `block` holds textures or media, which must precede
    /// the `Materials` that use them.
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
        let names = || self.textures.iter().map(|texture| texture.value.name.as_str());
        let help = "write numbers, or define it ahead of the Materials: `Textures { Checker name { … } }`";
        check_name_exists(lexer, "texture", name, names, help.to_owned())
    }

    /// Fails if no medium is called `name`.
    ///
    /// The help text says to define the medium at `position`, a phrase such as "in the file".
    pub fn check_medium_exists(
        &self,
        lexer: Lexer<'_>,
        name: &Spanned<String>,
        position: &str,
    ) -> Result<(), SceneError> {
        let names = || self.media.iter().map(|medium| medium.value.name.as_str());
        let help = if self.media.is_empty() {
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
