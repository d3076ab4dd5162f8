//! Materials of a scene that is imported from Tungsten. Each BSDF is converted at its first use.

mod converter;
mod nested;

use super::context::ImportContext;
use super::object::{ReadResult, TungstenObject};
use super::textures::TungstenTextures;
use crate::format::description::{
    DiffuseDescription, EmissionDescription, MaterialDescription, MaterialKindDescription, NullInterfaceDescription,
    Span, Spanned,
};
use crate::format::imported_files;
use crate::format::imported_materials::ImportedMaterials;
use converter::TungstenMaterialConverter;
use glam::DVec3;
use serde_json::{Map, Value};
use std::collections::HashMap;

/// Estimated memory of each material \[bytes], in the scene description and in the built scene
/// together.
const MEMORY_PER_MATERIAL: u64 = 2_000;

/// Address of the members of a JSON object, which identifies the object.
type ObjectKey = *const Map<String, Value>;

/// A material of the imported scene, with the properties that primitives depend on.
#[derive(Clone, Debug)]
pub(super) struct ImportedMaterial {
    /// Name of the material in the imported scene.
    pub name: String,
    /// True if the material is a null interface: light passes unchanged.
    pub is_null: bool,
    /// True if the surface with this material can bound a medium.
    pub bounds_medium: bool,
    /// True if the material uses a texture, or if it is a mix, whose two materials may use
    /// textures.
    pub may_be_textured: bool,
}

/// Properties of a primitive on which its converted material depends.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MaterialInputs {
    /// Name of the medium behind the surface; `None` for vacuum.
    pub medium: Option<String>,
    /// Emission texture: its name, and the factor from its values to radiance. `None` if the
    /// primitive emits constant radiance or nothing.
    pub emission_texture: Option<(Spanned<String>, f64)>,
}

/// Materials of the imported scene so far, with tables that find materials for reuse.
#[derive(Default)]
pub(super) struct TungstenMaterials {
    /// Materials of the imported scene.
    pub list: ImportedMaterials,
    /// Converted BSDFs.
    kinds: HashMap<ObjectKey, MaterialKindDescription>,
    /// Names of the materials that are parts of mixes.
    mix_component_names: HashMap<ObjectKey, String>,
    /// Materials of primitives. A key holds the BSDF of the primitive (`None` for a primitive
    /// without one) and the primitive's [`MaterialInputs`] as text.
    converted: HashMap<(Option<ObjectKey>, String), ImportedMaterial>,
}

impl TungstenMaterials {
    /// Returns the material of a primitive. Converts the primitive's BSDF, unless the same BSDF was
    /// converted for equal `inputs` before.
    ///
    /// A primitive without a BSDF is diffuse and white. A null interface with an emission texture
    /// becomes a black surface that emits light.
    pub fn imported_material<'a>(
        &mut self,
        context: &ImportContext<'a>,
        textures: &mut TungstenTextures,
        bsdf: Option<&TungstenObject<'a>>,
        inputs: &MaterialInputs,
    ) -> ReadResult<ImportedMaterial> {
        let key = (bsdf.map(TungstenObject::key), format!("{inputs:?}"));
        if let Some(known) = self.converted.get(&key) {
            return Ok(known.clone());
        }
        let name = self.list.unique_name(bsdf.map_or("", TungstenObject::name));
        let mut converter = TungstenMaterialConverter { materials: self, textures, context, name: &name };
        let mut kind = match bsdf {
            Some(bsdf) => converter.convert_bsdf(bsdf, 0)?,
            None => diffuse_description(DVec3::ONE),
        };
        let emission =
            inputs.emission_texture.clone().map(|(name, scale)| EmissionDescription::Texture { name, scale });
        if kind.is_null_interface() && emission.is_some() {
            kind = diffuse_description(DVec3::ZERO);
        }
        let is_null = kind.is_null_interface();
        let bounds_medium = is_null || kind.is_dielectric();
        let medium = inputs.medium.clone().filter(|_| bounds_medium).map(|name| Spanned::new(name, Span::default()));
        let description =
            MaterialDescription { name: Some(name.clone()), kind, emission, normal_perturbation: None, medium };
        let may_be_textured =
            !description.texture_names().is_empty() || description.kind.mix_material_names().is_some();
        self.push(context, description)?;
        let imported = ImportedMaterial { name, is_null, bounds_medium, may_be_textured };
        self.converted.insert(key, imported.clone());
        Ok(imported)
    }

    /// Returns the name of a new null interface that bounds `medium`.
    pub fn add_null_interface(&mut self, context: &ImportContext<'_>, medium: &str) -> ReadResult<String> {
        let name = self.list.unique_name("boundary");
        self.push(
            context,
            MaterialDescription {
                name: Some(name.clone()),
                kind: null_interface(),
                emission: None,
                normal_perturbation: None,
                medium: Some(Spanned::new(medium.to_owned(), Span::default())),
            },
        )?;
        Ok(name)
    }

    /// Returns the name of a new material that reflects and transmits nothing.
    pub fn add_black_material(&mut self, context: &ImportContext<'_>) -> ReadResult<String> {
        let name = self.list.unique_name("black");
        let kind = diffuse_description(DVec3::ZERO);
        let name_of_material = Some(name.clone());
        self.push(
            context,
            MaterialDescription {
                name: name_of_material,
                kind,
                emission: None,
                normal_perturbation: None,
                medium: None,
            },
        )?;
        Ok(name)
    }

    fn push(&mut self, context: &ImportContext<'_>, material: MaterialDescription) -> ReadResult<()> {
        self.list.push(material);
        let needed = MEMORY_PER_MATERIAL * self.list.descriptions.len() as u64;
        imported_files::check_memory(context.files.path, needed, context.files.free_memory())
    }
}

/// Returns a diffuse material of the given reflectance.
fn diffuse_description(reflectance: DVec3) -> MaterialKindDescription {
    MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: reflectance.into() })
}

fn null_interface() -> MaterialKindDescription {
    MaterialKindDescription::NullInterface(NullInterfaceDescription { priority: 0 })
}
