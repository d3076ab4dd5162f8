//! Materials that a pbrt file defines, and the materials of the imported scene.

mod converter;
mod parameter_reader;
mod refractive_index;
mod roughness;
mod surfaces;

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::graphics_state::MaterialReference;
use super::parameters::{Parameter, Parameters};
use super::textures::PbrtTextures;
use crate::format::description::{MaterialDescription, Spanned, TexturedValue};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_materials::ImportedMixLimits;
use converter::PbrtMaterialConverter;
use parameter_reader::ParameterReader;
use std::collections::HashMap;
use std::rc::Rc;

/// A material as the pbrt file defines it, not yet converted.
#[derive(Clone)]
struct FileMaterial {
    /// Type of the material in pbrt, such as `diffuse`.
    kind: String,
    parameters: Rc<Parameters>,
    /// Indices of the two materials of a mix; `None` for one that the file defines only later.
    mix_parts: [Option<usize>; 2],
}

/// A converted material, as shapes refer to it.
#[derive(Clone)]
pub(super) struct PbrtImportedMaterial {
    /// Name of the material in the imported scene.
    pub name: String,
    /// True if the material depends on texture coordinates, because of a texture of its own or of a
    /// part of a mix.
    pub needs_texcoords: bool,
}

/// Materials that the pbrt file defines, and the materials of the imported scene that shapes use.
pub(super) struct PbrtMaterials {
    /// All materials of the file. Index 0 is pbrt's default material, stored as `None`; definitions
    /// in the file have higher indices.
    numbered: Vec<Option<FileMaterial>>,
    /// Indices in `numbered` of the named materials that a directive can use at the current point
    /// of the file, by name.
    named: HashMap<String, usize>,
    /// List from which the end of a block in pbrt-v3 undoes definitions of named materials. Each
    /// definition adds an entry: the name, and the index of the material that had this name before;
    /// `None` if there was none.
    replaced_names: Vec<(String, Option<usize>)>,
    /// Converted materials. A key is a text that states the index of the material in `numbered`,
    /// the medium inside the shape, and the opacity of the shape.
    converted: HashMap<String, PbrtImportedMaterial>,
    /// Materials of the imported scene.
    pub descriptions: Vec<Spanned<MaterialDescription>>,
    /// Table that tells which two of the imported materials a mix may combine.
    mix_limits: ImportedMixLimits,
}

/// Properties of a shape on which its converted material depends.
pub(super) struct PbrtMaterialUse<'a> {
    /// Name of the medium inside the shape; `None` for vacuum.
    pub medium: Option<&'a str>,
    /// Opacity parameter of the shape; `None` for an opaque shape.
    pub alpha: Option<&'a Parameter>,
    /// Position of the `Shape` directive, for errors.
    pub place: &'a PbrtSourceLocation,
}

impl PbrtMaterials {
    /// Returns a table with only pbrt's default material, which has the index 0.
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

    /// Adds a material of a `Material` directive, and returns its index.
    pub fn add_numbered(&mut self, kind: &str, parameters: Parameters) -> usize {
        let number = |name: String| self.named.get(&name).copied();
        let mix_parts = if kind == "mix" { mix_part_names(&parameters).map(|names| names.map(number)) } else { None };
        let mix_parts = mix_parts.unwrap_or_default();
        self.numbered.push(Some(FileMaterial { kind: kind.to_owned(), parameters: Rc::new(parameters), mix_parts }));
        self.numbered.len() - 1
    }

    /// Adds the material of a `MakeNamedMaterial` directive.
    ///
    /// In pbrt-v3, the material replaces an earlier one of the same name, until the end of the
    /// attribute block. In pbrt-v4, a second definition of a name is an error.
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

    /// Returns the number of definitions of named materials that can be undone; 0 in pbrt-v4. At
    /// the end of a block, pass the number at its start to [`Self::restore_names`].
    pub fn named_definition_count(&self) -> usize {
        self.replaced_names.len()
    }

    /// Undoes definitions of named materials at the end of a block of pbrt-v3. Keeps only the first
    /// `count` definitions, those before the block.
    ///
    /// Shapes that already use an undone material keep it, because they refer to it by index.
    pub fn restore_names(&mut self, count: usize) {
        for (name, replaced) in self.replaced_names.drain(count.min(self.replaced_names.len())..).rev() {
            match replaced {
                Some(number) => self.named.insert(name, number),
                None => self.named.remove(&name),
            };
        }
    }

    /// Returns a reference to the material `name`: by index if it is already defined, else by name.
    pub fn reference(&self, name: String, place: PbrtSourceLocation) -> MaterialReference {
        match self.named.get(&name) {
            Some(number) => MaterialReference::Numbered(*number),
            None => MaterialReference::Named(name.into(), place),
        }
    }

    /// Returns the imported material of a shape that uses `material`. The first call for a
    /// combination of material, medium and opacity converts the material.
    pub fn imported_material(
        &mut self,
        material: &MaterialReference,
        shape_properties: &PbrtMaterialUse<'_>,
        textures: &mut PbrtTextures,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<PbrtImportedMaterial> {
        let PbrtMaterialUse { medium, alpha, place } = *shape_properties;
        let opacity = alpha.map_or(String::new(), |alpha| format!("{:?} {:?}", alpha.numbers, alpha.texts));
        let number = self.number(material)?;
        let key = format!("{number}|{medium:?}|{opacity}");
        if let Some(converted) = self.converted.get(&key) {
            return Ok(converted.clone());
        }
        let reader = ParameterReader { textures, files, notes };
        let mut converter = PbrtMaterialConverter { materials: self, reader, medium };
        let mut name = converter.convert_material(&MaterialReference::Numbered(number), 0)?;
        if let Some(parameter) = alpha {
            let value = converter.reader.textures.parameter_value(parameter, false, place, files)?;
            let (amount, mean) = converter.reader.textured_scalar_and_mean(&value, &|alpha| alpha.clamp(0.0, 1.0))?;
            if amount != TexturedValue::Constant(1.0) && mean < 1.0 {
                name = converter.mix_with_transparent(&name, amount)?;
            }
        }
        let needs_texcoords = self.needs_texcoords(&name, textures);
        let converted = PbrtImportedMaterial { name, needs_texcoords };
        self.converted.insert(key, converted.clone());
        Ok(converted)
    }

    /// Returns the index of a material. Fails if `material` is a name that is not defined.
    fn number(&self, material: &MaterialReference) -> ReadResult<usize> {
        match material {
            MaterialReference::Numbered(number) => Ok(*number),
            MaterialReference::Named(name, place) => self.named.get(&**name).copied().ok_or_else(|| {
                place.error(format!("no material is called `{name}`"), "define it with `MakeNamedMaterial`")
            }),
        }
    }

    /// True if a texture of the imported material `name` depends on texture coordinates. If the
    /// material is a mix, textures of its parts count too.
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

    /// True if a medium can fill shapes of the imported material `name`: it is a dielectric or a
    /// null interface.
    pub fn can_contain_medium(&self, name: &str) -> bool {
        let material = self.descriptions.iter().find(|material| material.name.as_deref() == Some(name));
        material.is_some_and(|material| material.kind.is_dielectric() || material.kind.is_null_interface())
    }
}

/// Returns the names of the two materials of a mix, so that `amount` is the weight of the second
/// one. `None` if the parameters do not name two.
///
/// The names in pbrt-v3 files are exchanged, because `amount` is the weight of the first one there.
fn mix_part_names(parameters: &Parameters) -> Option<[String; 2]> {
    let listed = parameters.find("materials").map_or(&[][..], |list| &list.texts);
    match (listed, parameters.text("namedmaterial1"), parameters.text("namedmaterial2")) {
        ([first, second, ..], _, _) => Some([first.clone(), second.clone()]),
        // In pbrt-v3, `amount` is the weight of the first material, so the two are exchanged.
        (_, Some(first), Some(second)) => Some([second.to_owned(), first.to_owned()]),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
