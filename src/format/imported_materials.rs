//! List of the materials of an imported scene, with unique names and checks of mixes.

use super::description::{
    GroupItem, MaterialDescription, MaterialKindDescription, MixDescription, NormalPerturbationDescription,
    ObjectGroup, Span, Spanned, ThinDielectricDescription,
};
use super::language::scope::MixConstraints;
use super::textured_value::TexturedValue;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// Reason why the scene language forbids a mix of two materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MixDefect {
    /// One of the materials is a mix with the greatest allowed nesting depth.
    TooDeep,
    /// The mix would bound two different dielectric bodies: both materials bound such a body, each
    /// itself or through a component of a mix, and the two dielectric materials differ.
    TwoDielectrics,
}

/// Table by which an importer finds out whether the scene language allows a mix of two materials.
/// It holds the properties of each material that limit mixes, by the material's name.
#[derive(Default)]
pub(super) struct ImportedMixLimits {
    constraints: HashMap<String, MixConstraints>,
}

impl ImportedMixLimits {
    /// Adds a material under its name, which must be unique. Both materials of a mix must be added
    /// before the mix.
    pub fn add(&mut self, material: &MaterialDescription) {
        let Some(name) = &material.name else { return };
        let constraints = MixConstraints::of_material(&material.kind, self.constraints.len(), |part| self.find(part));
        self.constraints.insert(name.clone(), constraints);
    }

    /// Returns why the scene language forbids a mix of the materials with these names; `None` if it
    /// allows the mix.
    pub fn mix_defect(&self, first: &str, second: &str) -> Option<MixDefect> {
        let (first, second) = (self.find(first), self.find(second));
        if first.is_deepest_mix() || second.is_deepest_mix() {
            Some(MixDefect::TooDeep)
        } else {
            first.has_other_dielectric_than(second).then_some(MixDefect::TwoDielectrics)
        }
    }

    fn find(&self, name: &str) -> MixConstraints {
        self.constraints.get(name).copied().unwrap_or_default()
    }
}

/// Materials that an importer has converted so far, in the order of conversion.
///
/// Each material has a unique name.
#[derive(Default)]
pub(super) struct ImportedMaterials {
    /// Materials of the imported scene. The materials of a mix are listed before it.
    pub descriptions: Vec<Spanned<MaterialDescription>>,
    /// Names in use, each with a number. If another material wants the name,
    /// [`unique_name`](Self::unique_name) first tries the name with this number appended.
    next_numbers: HashMap<String, u32>,
    mix_limits: ImportedMixLimits,
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
        self.mix_limits.add(&material);
        self.descriptions.push(Spanned::new(material, Span::default()));
    }

    /// Returns why the scene language forbids a mix of the materials with these names; `None` if it
    /// allows the mix.
    pub fn mix_defect(&self, first: &str, second: &str) -> Option<MixDefect> {
        self.mix_limits.mix_defect(first, second)
    }

    /// Returns the name of a material that lets all light pass unchanged. The first call creates
    /// this material.
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

    /// Removes all materials that `objects` do not use, directly or through mixes. Returns the
    /// names of the textures that the remaining materials use.
    ///
    /// Only the entries of `objects` itself count: nested groups are not searched.
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

/// Returns a mix of the materials named `first` and `second`, in which `second` is chosen with the
/// probability `second_probability`.
pub(super) fn mix_of(first: String, second: String, second_probability: TexturedValue<f64>) -> MaterialKindDescription {
    let part = |name: String| Spanned::new(name, Span::default());
    MaterialKindDescription::Mix(MixDescription { first: part(first), second: part(second), second_probability })
}
