//! Materials that a pbrt file defines, and the materials of the imported scene.

mod converter;
mod glasses;

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::graphics_state::MaterialReference;
use super::parameters::{Parameter, Parameters};
use super::textures::PbrtTextures;
use crate::format::description::{MaterialDescription, Spanned, TexturedValue};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_materials::ImportedMixLimits;
use converter::PbrtMaterialConverter;
use std::collections::HashMap;
use std::rc::Rc;

/// A material as the pbrt file defines it.
#[derive(Clone)]
struct FileMaterial {
    kind: String,
    parameters: Rc<Parameters>,
    /// Numbers of the two materials of a mix; `None` for one that is defined later.
    mix_parts: [Option<usize>; 2],
}

/// Material of the imported scene.
#[derive(Clone)]
pub(super) struct PbrtImportedMaterial {
    /// Name of the material.
    pub name: String,
    /// True if a texture of the material, or of a part of a mix, is a function of texture
    /// coordinates.
    pub needs_texcoords: bool,
}

/// Materials that the pbrt file defines, and the materials of the imported scene that shapes use.
pub(super) struct PbrtMaterials {
    /// All materials of the file, by number.
    numbered: Vec<Option<FileMaterial>>,
    /// Numbers of the materials with names.
    named: HashMap<String, usize>,
    /// Each name that was defined, in order, with the number that it had before.
    replaced_names: Vec<(String, Option<usize>)>,
    /// Materials of the imported scene. A key combines pbrt's material, the medium inside and the
    /// opacity.
    converted: HashMap<String, PbrtImportedMaterial>,
    /// Materials of the imported scene.
    pub descriptions: Vec<Spanned<MaterialDescription>>,
    /// Properties of these materials that limit their use in mixes.
    mix_limits: ImportedMixLimits,
}

/// Conditions of a shape under which its material is converted.
pub(super) struct PbrtMaterialUse<'a> {
    /// Name of the medium inside the shape; `None` for vacuum.
    pub medium: Option<&'a str>,
    /// Opacity parameter of the shape; `None` for an opaque shape.
    pub alpha: Option<&'a Parameter>,
    /// Position of the shape.
    pub place: &'a PbrtSourceLocation,
}

impl PbrtMaterials {
    /// Returns the table of materials before the first directive.
    ///
    /// It holds only pbrt's default material, with the number 0.
    pub fn new() -> Self {
        Self {
            numbered: vec![None],
            named: HashMap::new(),
            replaced_names: Vec::new(),
            converted: HashMap::new(),
            descriptions: Vec::new(),
            mix_limits: ImportedMixLimits::default(),
        }
    }

    /// Adds a material of a `Material` directive, and returns its number.
    pub fn add_numbered(&mut self, kind: &str, parameters: Parameters) -> usize {
        let number = |name: String| self.named.get(&name).copied();
        let mix_parts = if kind == "mix" { mix_part_names(&parameters).map(|names| names.map(number)) } else { None };
        let mix_parts = mix_parts.unwrap_or_default();
        self.numbered.push(Some(FileMaterial { kind: kind.to_owned(), parameters: Rc::new(parameters), mix_parts }));
        self.numbered.len() - 1
    }

    /// Adds a material of a `MakeNamedMaterial` directive.
    ///
    /// In a scene of pbrt-v3, it replaces an earlier one with this name, until the end of the
    /// attribute block. In pbrt-v4, a second definition is an error.
    pub fn add_named(&mut self, name: &str, parameters: Parameters, is_v3: bool) -> ReadResult<()> {
        if !is_v3 && self.named.contains_key(name) {
            let message = format!("the material `{name}` is defined twice");
            return Err(parameters.place.error(message, "give each material its own name"));
        }
        let kind = parameters.text("type").unwrap_or("diffuse").to_owned();
        let number = self.add_numbered(&kind, parameters);
        let replaced = self.named.insert(name.to_owned(), number);
        if is_v3 {
            self.replaced_names.push((name.to_owned(), replaced));
        }
        Ok(())
    }

    /// Returns the number of definitions of names so far, for [`Self::restore_names`].
    pub fn named_definition_count(&self) -> usize {
        self.replaced_names.len()
    }

    /// Undoes the definitions of names after the first `count`. Materials keep their numbers.
    pub fn restore_names(&mut self, count: usize) {
        for (name, replaced) in self.replaced_names.drain(count.min(self.replaced_names.len())..).rev() {
            match replaced {
                Some(number) => self.named.insert(name, number),
                None => self.named.remove(&name),
            };
        }
    }

    /// Returns a reference to the material `name`, which may be defined later.
    pub fn reference(&self, name: String, place: PbrtSourceLocation) -> MaterialReference {
        match self.named.get(&name) {
            Some(number) => MaterialReference::Numbered(*number),
            None => MaterialReference::Named(name.into(), place),
        }
    }

    /// Returns a shape's material in the imported scene. Converts it at its first use.
    pub fn imported_material(
        &mut self,
        material: &MaterialReference,
        wanted: &PbrtMaterialUse<'_>,
        textures: &mut PbrtTextures,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<PbrtImportedMaterial> {
        let PbrtMaterialUse { medium, alpha, place } = *wanted;
        let opacity = alpha.map_or(String::new(), |alpha| format!("{:?} {:?}", alpha.numbers, alpha.texts));
        let number = self.number(material)?;
        let key = format!("{number}|{medium:?}|{opacity}");
        if let Some(converted) = self.converted.get(&key) {
            return Ok(converted.clone());
        }
        let mut converter = PbrtMaterialConverter { materials: self, textures, files, notes, medium };
        let mut name = converter.convert_material(&MaterialReference::Numbered(number), 0)?;
        if let Some(parameter) = alpha {
            let value = converter.textures.parameter_value(parameter, false, place, files)?;
            let (amount, mean) = converter.textured_scalar_and_mean(&value, &|alpha| alpha.clamp(0.0, 1.0))?;
            if amount != TexturedValue::Constant(1.0) && mean < 1.0 {
                name = converter.mix_with_transparent(&name, amount)?;
            }
        }
        let needs_texcoords = self.needs_texcoords(&name, textures);
        let converted = PbrtImportedMaterial { name, needs_texcoords };
        self.converted.insert(key, converted.clone());
        Ok(converted)
    }

    /// Returns the number of a material. Fails if no material has the name.
    fn number(&self, material: &MaterialReference) -> ReadResult<usize> {
        match material {
            MaterialReference::Numbered(number) => Ok(*number),
            MaterialReference::Named(name, place) => self.named.get(&**name).copied().ok_or_else(|| {
                place.error(format!("no material is called `{name}`"), "define it with `MakeNamedMaterial`")
            }),
        }
    }

    /// True if the imported material `name`, or a part of it if it is a mix, has a texture that is
    /// a function of texture coordinates.
    fn needs_texcoords(&self, name: &str, textures: &PbrtTextures) -> bool {
        let material = self.descriptions.iter().rev().find(|material| material.name.as_deref() == Some(name));
        material.is_some_and(|material| {
            material.texture_names().iter().any(|name| textures.needs_texcoords(name))
                || material
                    .kind
                    .mix_material_names()
                    .is_some_and(|parts| parts.iter().any(|part| self.needs_texcoords(part, textures)))
        })
    }

    /// True if the imported material `name` is a dielectric or a null interface, so that a medium
    /// can fill its shape.
    pub fn can_contain_medium(&self, name: &str) -> bool {
        let material = self.descriptions.iter().find(|material| material.name.as_deref() == Some(name));
        material.is_some_and(|material| material.kind.is_dielectric() || material.kind.is_null_interface())
    }
}

/// Returns the names of the two materials of a mix; the amount is the share of the second. `None`
/// if the parameters do not name two.
fn mix_part_names(parameters: &Parameters) -> Option<[String; 2]> {
    let listed = parameters.find("materials").map_or(&[][..], |list| &list.texts);
    match (listed, parameters.text("namedmaterial1"), parameters.text("namedmaterial2")) {
        ([first, second, ..], _, _) => Some([first.clone(), second.clone()]),
        // In pbrt-v3, the amount is the share of the first material.
        (_, Some(first), Some(second)) => Some([second.to_owned(), first.to_owned()]),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
