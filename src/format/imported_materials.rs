//! Materials of an imported scene, in the order of their conversion.

use super::description::{
    GroupItem, MaterialDescription, MaterialKindDescription, MixDescription, NormalPerturbationDescription,
    ObjectGroup, Span, Spanned, ThinDielectricDescription,
};
use super::textured_value::TexturedValue;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// Materials that an importer has converted so far, each with a unique name.
#[derive(Default)]
pub(super) struct ImportedMaterials {
    /// Materials of the imported scene. The materials of a mix are listed before it.
    pub descriptions: Vec<Spanned<MaterialDescription>>,
    /// Names in use. Each maps to the next number to try for a material that wants the same name.
    next_numbers: HashMap<String, u32>,
    transparent_material_name: Option<String>,
}

impl ImportedMaterials {
    /// Reserves and returns a material name that is not in use: `wanted`, or `wanted` with a
    /// number.
    ///
    /// Control characters and quotes become spaces.
    pub fn unique_name(&mut self, wanted: &str) -> String {
        let clean: String = wanted.chars().map(|c| if c.is_control() || c == '"' { ' ' } else { c }).collect();
        let clean = clean.trim();
        let base = if clean.is_empty() { "material" } else { clean };
        let mut number = self.next_numbers.get(base).copied().unwrap_or(1);
        let numbered = |number: u32| if number == 1 { base.to_owned() } else { format!("{base} {number}") };
        while self.next_numbers.contains_key(&numbered(number)) {
            number += 1;
        }
        let name = numbered(number);
        self.next_numbers.insert(name.clone(), 2);
        self.next_numbers.insert(base.to_owned(), number + 1);
        name
    }

    /// Adds a material without emission and without a medium.
    pub fn push_surface(
        &mut self,
        name: String,
        kind: MaterialKindDescription,
        normal_perturbation: Option<NormalPerturbationDescription>,
    ) {
        self.push(MaterialDescription { name: Some(name), kind, emission: None, normal_perturbation, medium: None });
    }

    /// Adds a material.
    pub fn push(&mut self, material: MaterialDescription) {
        self.descriptions.push(Spanned::new(material, Span::default()));
    }

    /// Returns the name of a material that transmits all light unchanged. Adds it at its first use.
    pub fn transparent_material_name(&mut self) -> String {
        if let Some(name) = &self.transparent_material_name {
            return name.clone();
        }
        let name = self.unique_name("clear");
        let kind =
            MaterialKindDescription::Thin(ThinDielectricDescription { eta: 1.0, transmittance: DVec3::ONE.into() });
        self.push_surface(name.clone(), kind, None);
        self.transparent_material_name = Some(name.clone());
        name
    }

    /// Keeps only the materials that entries of `objects` name, and the materials of their mixes.
    ///
    /// Nested groups are not searched. Returns the names of the textures that the kept materials
    /// use.
    pub fn remove_unused(&mut self, objects: &ObjectGroup) -> HashSet<String> {
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
        self.descriptions.iter().flat_map(|m| m.texture_names()).map(|name| name.value.clone()).collect()
    }
}

/// Returns a mix of the materials named `first` and `second`, in which `second` has the weight
/// `second_probability`.
pub(super) fn mix_of(first: String, second: String, second_probability: TexturedValue<f64>) -> MaterialKindDescription {
    let part = |name: String| Spanned::new(name, Span::default());
    MaterialKindDescription::Mix(MixDescription { first: part(first), second: part(second), second_probability })
}
