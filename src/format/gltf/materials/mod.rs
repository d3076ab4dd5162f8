//! Materials of a scene that is imported from a glTF file, each converted at its first use.

mod converter;

use super::context::{FileContext, ReadResult};
use super::textures::GltfTextures;
use crate::format::description::{
    EmissionDescription, GroupItem, MaterialDescription, MaterialKindDescription, NormalPerturbationDescription,
    ObjectGroup, Span, Spanned, ThinDielectricDescription,
};
use crate::format::import_notes::ImportNotes;
use converter::GltfMaterialConverter;
use glam::{DVec3, DVec4};
use std::collections::{HashMap, HashSet};

/// A material of the imported scene, with the properties that objects depend on.
#[derive(Clone, Debug)]
pub(super) struct GltfImportedMaterial {
    /// Name of the material in the imported scene.
    pub name: String,
    /// Index of the texture coordinates that its textures use (`TEXCOORD_0`, …); `None` without
    /// textures.
    pub texcoord_set: Option<u32>,
    /// True if the surface is fully transparent.
    pub is_invisible: bool,
    /// True if the surface emits light.
    pub emits: bool,
}

/// Materials of the imported scene so far, with their textures.
pub(super) struct GltfMaterials<'a> {
    /// Textures of the materials, and embedded pictures.
    pub textures: GltfTextures<'a>,
    /// Materials of the imported scene. The materials of a mix are listed before it.
    pub descriptions: Vec<Spanned<MaterialDescription>>,
    names: HashSet<String>,
    transparent_material_name: Option<String>,
    converted: HashMap<(Option<usize>, [u64; 4]), GltfImportedMaterial>,
}

impl<'a> GltfMaterials<'a> {
    /// Returns an empty table of materials, whose textures are collected in `pictures`.
    pub fn new(pictures: GltfTextures<'a>) -> Self {
        let (names, used) = (HashSet::new(), HashMap::new());
        Self { textures: pictures, descriptions: Vec::new(), names, transparent_material_name: None, converted: used }
    }

    /// Returns the material of the imported scene for `material` of the file. Converts it at its
    /// first use.
    ///
    /// `vertex_color` multiplies the base color and alpha; `None` stands for white.
    pub fn imported_material(
        &mut self,
        context: &FileContext<'a>,
        material: &gltf::Material<'_>,
        vertex_color: Option<DVec4>,
        notes: &mut ImportNotes,
    ) -> ReadResult<GltfImportedMaterial> {
        let vertex_color = vertex_color.unwrap_or(DVec4::ONE);
        let key = (material.index(), vertex_color.to_array().map(f64::to_bits));
        if let Some(known) = self.converted.get(&key) {
            return Ok(known.clone());
        }
        let number = material.index().map_or_else(|| "default".to_owned(), |i| format!("material {i}"));
        let name = self.unique_name(material.name().unwrap_or(&number));
        let mut converter =
            GltfMaterialConverter { materials: self, notes, context, name, texcoord_set: None, normal: None };
        let imported = converter.convert_material(material, vertex_color)?;
        self.converted.insert(key, imported.clone());
        Ok(imported)
    }

    /// Reserves and returns a material name that is not in use: `wanted`, or `wanted` with a
    /// number.
    ///
    /// Control characters become spaces.
    fn unique_name(&mut self, wanted: &str) -> String {
        let clean: String = wanted.chars().map(|c| if c.is_control() || c == '"' { ' ' } else { c }).collect();
        let clean = clean.trim();
        let base = if clean.is_empty() { "material" } else { clean };
        let numbered = (2..).map(|i| format!("{base} {i}"));
        let mut candidates = std::iter::once(base.to_owned()).chain(numbered);
        let name = candidates.find(|name| !self.names.contains(name)).unwrap_or_default();
        self.names.insert(name.clone());
        name
    }

    /// Keeps only the materials that an object uses, directly or through a mix, and their textures
    /// and pictures.
    pub fn remove_unused(&mut self, objects: &ObjectGroup) {
        let named = |item: &GroupItem| match item {
            GroupItem::MaterialName(name) => Some(name.value.clone()),
            GroupItem::MaterialIndex(_) | GroupItem::Object(_) => None,
        };
        let mut used: HashSet<String> = objects.items.iter().filter_map(named).collect();
        // The materials of a mix are listed before it, so one backward pass finds all.
        for material in self.descriptions.iter().rev() {
            if material.name.as_ref().is_some_and(|name| used.contains(name)) {
                used.extend(material.kind.mix_material_names().into_iter().flatten().map(|part| part.value.clone()));
            }
        }
        self.descriptions.retain(|material| material.name.as_ref().is_some_and(|name| used.contains(name)));
        let textures: HashSet<String> =
            self.descriptions.iter().flat_map(|m| m.texture_names()).map(|name| name.value.clone()).collect();
        self.textures.keep_textures(&textures);
    }

    fn push_material(
        &mut self,
        name: String,
        kind: MaterialKindDescription,
        emission: Option<EmissionDescription>,
        normal_perturbation: Option<NormalPerturbationDescription>,
    ) {
        let material = MaterialDescription { name: Some(name), kind, emission, normal_perturbation, medium: None };
        self.descriptions.push(Spanned::new(material, Span::default()));
    }

    /// Returns the name of a material that transmits all light unchanged. Adds it at its first use.
    fn transparent_material_name(&mut self) -> String {
        if let Some(name) = &self.transparent_material_name {
            return name.clone();
        }
        let name = self.unique_name("clear");
        let kind =
            MaterialKindDescription::Thin(ThinDielectricDescription { eta: 1.0, transmittance: DVec3::ONE.into() });
        self.push_material(name.clone(), kind, None, None);
        self.transparent_material_name = Some(name.clone());
        name
    }
}
