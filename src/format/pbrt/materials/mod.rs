//! Materials that a pbrt file defines, and the materials of the imported scene.

mod converter;

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::graphics_state::MaterialReference;
use super::parameters::{Parameter, Parameters};
use super::textures::PbrtTextures;
use crate::format::description::{MaterialDescription, Spanned, TexturedValue};
use crate::format::import_notes::ImportNotes;
use converter::PbrtMaterialConverter;
use std::collections::HashMap;
use std::rc::Rc;

/// A material as the pbrt file defines it.
#[derive(Clone)]
struct FileMaterial {
    kind: String,
    parameters: Rc<Parameters>,
}

/// Materials that the pbrt file defines, and the materials of the imported scene that shapes use.
pub(super) struct PbrtMaterials {
    numbered: Vec<Option<FileMaterial>>,
    named: HashMap<String, FileMaterial>,
    /// Names of the imported scene's materials. A key combines pbrt's material, the medium inside
    /// and the opacity.
    converted_names: HashMap<String, String>,
    /// Materials of the imported scene.
    pub descriptions: Vec<Spanned<MaterialDescription>>,
}

impl PbrtMaterials {
    /// Returns the table of materials before the first directive.
    ///
    /// It holds only pbrt's default material, with the number 0.
    pub fn new() -> Self {
        Self { numbered: vec![None], named: HashMap::new(), converted_names: HashMap::new(), descriptions: Vec::new() }
    }

    /// Adds a material of a `Material` directive, and returns its number.
    pub fn add_numbered(&mut self, kind: &str, parameters: Parameters) -> usize {
        self.numbered.push(Some(FileMaterial { kind: kind.to_owned(), parameters: Rc::new(parameters) }));
        self.numbered.len() - 1
    }

    /// Adds a material of a `MakeNamedMaterial` directive. It replaces an earlier one with this
    /// name.
    pub fn add_named(&mut self, name: &str, parameters: Parameters) {
        let kind = parameters.text("type").unwrap_or("diffuse").to_owned();
        self.named.insert(name.to_owned(), FileMaterial { kind, parameters: Rc::new(parameters) });
    }

    /// Returns the name of a shape's material in the imported scene. Converts the material at its
    /// first use.
    ///
    /// `medium` is the name of the medium inside the shape; `None` for vacuum. `alpha` is the
    /// shape's opacity parameter; `None` for an opaque shape.
    pub fn imported_material_name(
        &mut self,
        material: &MaterialReference,
        (medium, alpha): (Option<&str>, Option<&Parameter>),
        textures: &mut PbrtTextures,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<String> {
        let opacity = alpha.map_or(String::new(), |alpha| format!("{:?} {:?}", alpha.numbers, alpha.texts));
        let key = match material {
            MaterialReference::Numbered(number) => format!("{number}|{medium:?}|{opacity}"),
            MaterialReference::Named(name, _) => format!("\"{name}\"|{medium:?}|{opacity}"),
        };
        if let Some(name) = self.converted_names.get(&key) {
            return Ok(name.clone());
        }
        let mut converter = PbrtMaterialConverter { materials: self, textures, files, notes, medium };
        let mut name = converter.convert_material(material, 0)?;
        if let Some(parameter) = alpha {
            let place = PbrtSourceLocation { file: files.path.display().to_string().into(), line: 0 };
            let value = converter.textures.parameter_value(parameter, false, &place, files)?;
            let (amount, mean) = converter.textured_scalar_and_mean(&value, &|alpha| alpha.clamp(0.0, 1.0))?;
            if amount != TexturedValue::Constant(1.0) && mean < 1.0 {
                name = converter.mix_with_transparent(&name, amount)?;
            }
        }
        self.converted_names.insert(key, name.clone());
        Ok(name)
    }

    /// True if the imported material `name` is a dielectric or a null interface, so that a medium
    /// can fill its shape.
    pub fn can_contain_medium(&self, name: &str) -> bool {
        let material = self.descriptions.iter().find(|material| material.name.as_deref() == Some(name));
        material.is_some_and(|material| material.kind.is_dielectric() || material.kind.is_null_interface())
    }
}
