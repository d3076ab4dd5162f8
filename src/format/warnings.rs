//! Warnings about a scene that is valid, but probably not as intended.

use super::SourceText;
use super::description::{
    Group, GroupItem, MaterialDescription, ObjectDescription, SceneDescription, ShapeDescription, Span, Spanned,
};
use super::import::EmbeddedAssets;
use super::mesh::{self, MeshReport};
use super::resolve::candidates;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Returns warnings, one line each, in the order of the text.
///
/// Meshes of dielectrics are read again; one that cannot be read is the resolver's to report.
pub(super) fn warnings(
    description: &SceneDescription,
    source: &SourceText,
    folder: &Path,
    assets: &EmbeddedAssets,
) -> Vec<String> {
    let uses = Uses::of(description);
    let mut found = unused(description, &uses);
    for (path, span) in &uses.dielectric_meshes {
        let report = match assets.meshes.get(*path) {
            Some(mesh) => Some(mesh.mesh_report()),
            None => candidates(folder, Path::new(path))
                .find(|file| file.is_file())
                .and_then(|file| mesh::load(&file, &()).ok())
                .map(|loaded| loaded.mesh.mesh_report()),
        };
        if let Some(defect) = report.as_ref().and_then(defect) {
            let remedy = "`caustica mesh --repair` may repair it";
            found.push((*span, format!("the dielectric mesh `{path}` {defect}; {remedy}")));
        }
    }
    lines(found, source)
}

/// Returns warnings about unused textures and materials, one line each, in the order of the text.
pub(super) fn unused_item_warnings(description: &SceneDescription, source: &SourceText) -> Vec<String> {
    lines(unused(description, &Uses::of(description)), source)
}

/// Returns one line for each message, in the order of the text.
fn lines(mut found: Vec<(Span, String)>, source: &SourceText) -> Vec<String> {
    found.sort_by_key(|(span, _)| span.start);
    found.into_iter().map(|(span, message)| source.warning(span, &message)).collect()
}

/// Returns messages about textures and materials that nothing refers to.
fn unused(description: &SceneDescription, uses: &Uses<'_>) -> Vec<(Span, String)> {
    let mut found = Vec::new();
    for texture in &description.textures {
        if !uses.textures.contains(texture.name.as_str()) {
            found.push((texture.span, format!("the texture `{}` is not used", texture.name)));
        }
    }
    for (index, material) in description.materials.iter().enumerate() {
        if !uses.is_used(description, index) {
            let name = material.name.as_ref().map_or(format!("number {index}"), |name| format!("`{name}`"));
            found.push((material.span, format!("the material {name} is not used")));
        }
    }
    found
}

/// Returns what makes a mesh unfit as the boundary of a body; `None` if it is fit.
fn defect(report: &MeshReport) -> Option<String> {
    if report.triangles == 0 {
        return None;
    }
    if !report.closed {
        return Some(format!("is open at {} edges: light that enters may not leave", report.boundary_edges));
    }
    if report.inconsistent_edges > 0 {
        return Some(format!("has {} edges whose faces disagree about the outer side", report.inconsistent_edges));
    }
    let inside_out = report.volume.is_some_and(|volume| volume < 0.0);
    inside_out.then(|| "is inside out: its normals point into the body".to_owned())
}

/// Materials, textures and meshes that the objects of a scene refer to.
#[derive(Default)]
struct Uses<'a> {
    /// Indices of materials that an object has.
    materials: BTreeSet<usize>,
    /// Names of textures that a material refers to.
    textures: BTreeSet<&'a str>,
    /// Paths of meshes with a dielectric material, with the first object of each.
    dielectric_meshes: BTreeMap<&'a str, Span>,
}

impl<'a> Uses<'a> {
    /// Returns the uses of a scene.
    fn of(description: &'a SceneDescription) -> Self {
        let mut uses = Self::default();
        uses.group(description, &description.root, &mut 0);
        for material in &description.materials {
            uses.textures.extend(material.textures().into_iter().map(|name| name.as_str()));
        }
        uses
    }

    /// Collects the uses of a group; `material` is the index of the material in force.
    fn group(&mut self, description: &'a SceneDescription, group: &'a Group, material: &mut usize) {
        for item in &group.items {
            match item {
                GroupItem::MaterialIndex(index) => *material = index.value as usize,
                GroupItem::MaterialName(name) => {
                    let named = |m: &Spanned<MaterialDescription>| m.name.as_deref() == Some(name.as_str());
                    *material = description.materials.iter().position(named).unwrap_or(*material);
                }
                GroupItem::Object(object) => self.object(description, object, material),
            }
        }
    }

    /// Collects the uses of an object.
    fn object(
        &mut self,
        description: &'a SceneDescription,
        object: &'a Spanned<ObjectDescription>,
        material: &mut usize,
    ) {
        match &object.value {
            ObjectDescription::Group(group) => self.group(description, group, material),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
                self.object(description, object, material);
            }
            ObjectDescription::Shape { shape, .. } => {
                self.materials.insert(*material);
                let ShapeDescription::Mesh { path, options } = shape else { return };
                let dielectric = description.materials.get(*material).is_some_and(|m| m.kind.is_dielectric());
                if dielectric && !options.uses_file_materials {
                    self.dielectric_meshes.entry(path).or_insert(path.span);
                }
            }
        }
    }

    /// True if an object has the material, or a mix that an object has contains it.
    fn is_used(&self, description: &SceneDescription, index: usize) -> bool {
        let materials = &description.materials;
        let name = materials[index].name.as_deref();
        let part_of = |mix: &Spanned<MaterialDescription>| {
            mix.kind.parts().is_some_and(|parts| parts.iter().any(|part| Some(part.as_str()) == name))
        };
        // The parts of a mix stand before it, so the recursion ends.
        let in_mix = |(mix, _): (usize, &Spanned<MaterialDescription>)| mix > index && self.is_used(description, mix);
        self.materials.contains(&index)
            || materials.iter().enumerate().filter(|(_, material)| part_of(material)).any(in_mix)
    }
}

#[cfg(test)]
mod tests {
    use crate::format::SceneFile;

    #[test]
    fn unused_parts_and_open_dielectrics_are_warned_of() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("open.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let closed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
        let faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
        std::fs::write(folder.path().join("closed.obj"), format!("{closed}{faces}")).unwrap();
        let turned = "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
        std::fs::write(folder.path().join("turned.obj"), format!("{closed}{turned}")).unwrap();
        let text = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 angle 30 }
Textures { Checker used { } Checker idle { } }
Materials { Diffuse floor { reflectance used } Mirror part { } Mirror other { }
Mix mix { first part second floor amount .5 } Dielectric glass { } }
Group { MaterialName mix Sphere { center 0 0 0 radius 1 } MaterialName glass
TriangleMesh { file open.obj }
TriangleMesh { file closed.obj }
TriangleMesh { file turned.obj } }";
        let path = folder.path().join("a.txt");
        std::fs::write(&path, text).unwrap();
        let warnings = SceneFile::read(&path).unwrap().warnings();
        let expected = [
            ":2:29: warning: the texture `idle` is not used",
            ":3:64: warning: the material `other` is not used",
            ":6:21: warning: the dielectric mesh `open.obj` is open at 3 edges",
            ":8:21: warning: the dielectric mesh `turned.obj` is inside out",
        ];
        assert_eq!(warnings.len(), expected.len(), "{warnings:#?}");
        for (warning, expected) in warnings.iter().zip(expected) {
            assert!(warning.contains(expected), "{warning}");
        }
    }
}
