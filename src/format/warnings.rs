//! Warnings about a scene that is valid, but probably not as intended.

use super::SourceText;
use super::assets::EmbeddedAssets;
use super::description::{
    GroupItem, MaterialDescription, MeshDescription, ObjectDescription, ObjectGroup, SceneDescription,
    ShapeDescription, Span, Spanned,
};
use super::mesh::{self, MeshReport};
use super::resolve::candidate_file_paths;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Returns warnings about unused textures and materials, and about dielectric meshes that are open,
/// inside out or inconsistently wound.
///
/// Each warning is one line, in the order of the text. Dielectric meshes are read again. A mesh
/// that cannot be read is skipped, because resolving reports it as an error.
pub(super) fn scene_warnings(
    description: &SceneDescription,
    source: &SourceText,
    folder: &Path,
    assets: &EmbeddedAssets,
) -> Vec<String> {
    let uses = UsedSceneItems::collect_used_items(description);
    let mut found = unused_item_messages(description, &uses);
    for (path, span) in &uses.dielectric_meshes {
        let report = match assets.meshes.get(*path) {
            Some(mesh) => Some(mesh.mesh_report()),
            None => candidate_file_paths(folder, Path::new(path))
                .find(|file| file.is_file())
                .and_then(|file| mesh::load(&file, &()).ok())
                .map(|loaded| loaded.mesh.mesh_report()),
        };
        if let Some(defect) = report.as_ref().and_then(dielectric_mesh_defect) {
            let remedy = "`caustica mesh --repair` may repair it";
            found.push((*span, format!("the dielectric mesh `{path}` {defect}; {remedy}")));
        }
    }
    warning_lines(found, source)
}

/// Returns warnings about unused textures and materials, one line each, in the order of the text.
pub(super) fn unused_item_warnings(description: &SceneDescription, source: &SourceText) -> Vec<String> {
    warning_lines(unused_item_messages(description, &UsedSceneItems::collect_used_items(description)), source)
}

/// Returns one warning line for each pair of position and message, in the order of the text.
fn warning_lines(mut found: Vec<(Span, String)>, source: &SourceText) -> Vec<String> {
    found.sort_by_key(|(span, _)| span.start);
    found.into_iter().map(|(span, message)| source.warning_at_span(span, &message)).collect()
}

/// Returns messages about textures and materials that nothing refers to.
fn unused_item_messages(description: &SceneDescription, uses: &UsedSceneItems<'_>) -> Vec<(Span, String)> {
    let mut found = Vec::new();
    for texture in &description.textures {
        if !uses.textures.contains(texture.name.as_str()) {
            found.push((texture.span, format!("the texture `{}` is not used", texture.name)));
        }
    }
    for (index, material) in description.materials.iter().enumerate() {
        if !uses.is_material_used(description, index) {
            let name = material.name.as_ref().map_or(format!("number {index}"), |name| format!("`{name}`"));
            found.push((material.span, format!("the material {name} is not used")));
        }
    }
    found
}

/// Returns, as text, the first defect that keeps a mesh from bounding a dielectric body.
///
/// `None` if the mesh has no defect or no triangles.
fn dielectric_mesh_defect(report: &MeshReport) -> Option<String> {
    if report.triangles == 0 {
        return None;
    }
    if !report.is_closed {
        return Some(format!("is open at {} edges: light that enters may not leave", report.boundary_edges));
    }
    if report.inconsistent_edges > 0 {
        return Some(format!("has {} edges whose faces disagree about the outer side", report.inconsistent_edges));
    }
    let inside_out = report.volume.is_some_and(|volume| volume < 0.0);
    inside_out.then(|| "is inside out: its normals point into the body".to_owned())
}

/// Materials, textures and dielectric meshes that a scene uses.
#[derive(Default)]
struct UsedSceneItems<'a> {
    /// Indices of the materials that are assigned to objects directly. Components of an assigned
    /// `Mix` are not included.
    materials: BTreeSet<usize>,
    /// Names of the textures that any material refers to.
    textures: BTreeSet<&'a str>,
    /// Paths of the meshes that have a dielectric material of the scene text, each with the span of
    /// its first use. Meshes that take their materials from MTL files are left out.
    dielectric_meshes: BTreeMap<&'a str, Span>,
}

impl<'a> UsedSceneItems<'a> {
    fn collect_used_items(description: &'a SceneDescription) -> Self {
        let mut uses = Self::default();
        uses.collect_items_used_by_group(description, &description.root, &mut 0);
        for material in &description.materials {
            uses.textures.extend(material.texture_names().into_iter().map(|name| name.as_str()));
        }
        uses
    }

    /// Records the materials and dielectric meshes that the objects of a group use.
    ///
    /// `material` is the index of the material that the scene text has selected for the next
    /// object. Entries of the group may select another one; the function then changes `material`.
    fn collect_items_used_by_group(
        &mut self,
        description: &'a SceneDescription,
        group: &'a ObjectGroup,
        material: &mut usize,
    ) {
        for item in &group.items {
            match item {
                GroupItem::MaterialIndex(index) => *material = index.value as usize,
                GroupItem::MaterialName(name) => {
                    let named = |m: &Spanned<MaterialDescription>| m.name.as_deref() == Some(name.as_str());
                    *material = description.materials.iter().position(named).unwrap_or(*material);
                }
                GroupItem::Object(object) => self.collect_items_used_by_object(description, object, material),
            }
        }
    }

    /// Records the material and the dielectric mesh that `object` uses. For a group, records those
    /// of all its objects.
    ///
    /// `material` is the index of the material that the scene text has selected for the next
    /// object. If `object` is a group, entries of the group may select another one. The function
    /// then changes `material`.
    fn collect_items_used_by_object(
        &mut self,
        description: &'a SceneDescription,
        object: &'a Spanned<ObjectDescription>,
        material: &mut usize,
    ) {
        match &object.value {
            ObjectDescription::Group(group) => self.collect_items_used_by_group(description, group, material),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
                self.collect_items_used_by_object(description, object, material);
            }
            ObjectDescription::Shape { shape, .. } => {
                self.materials.insert(*material);
                let ShapeDescription::Mesh(MeshDescription { path, options }) = shape else { return };
                let dielectric = description.materials.get(*material).is_some_and(|m| m.kind.bounds_dielectric());
                if dielectric && !options.uses_file_materials {
                    self.dielectric_meshes.entry(path).or_insert(path.span);
                }
            }
        }
    }

    /// True if an object has the material with this `index`, or a mix that contains it.
    fn is_material_used(&self, description: &SceneDescription, index: usize) -> bool {
        let materials = &description.materials;
        let name = materials[index].name.as_deref();
        let part_of = |mix: &Spanned<MaterialDescription>| {
            mix.kind.mix_material_names().is_some_and(|parts| parts.iter().any(|part| Some(part.as_str()) == name))
        };
        // A mix refers only to materials before it, so the recursion ends.
        let in_mix =
            |(mix, _): (usize, &Spanned<MaterialDescription>)| mix > index && self.is_material_used(description, mix);
        self.materials.contains(&index)
            || materials.iter().enumerate().filter(|(_, material)| part_of(material)).any(in_mix)
    }
}

#[cfg(test)]
mod tests {
    use crate::format::SceneFile;

    #[test]
    fn unused_items_and_open_dielectrics_cause_warnings() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("open.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        std::fs::copy(folder.path().join("open.obj"), folder.path().join("pane.obj")).unwrap();
        let closed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
        let faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
        std::fs::write(folder.path().join("closed.obj"), format!("{closed}{faces}")).unwrap();
        let turned = "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
        std::fs::write(folder.path().join("turned.obj"), format!("{closed}{turned}")).unwrap();
        let text = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 angle 30 }
Textures { Checker used { } Checker idle { } }
Materials { Diffuse floor { reflectance used } Mirror part { } Mirror other { }
Mix mix { first part second floor amount .5 } Dielectric glass { } Principled pane { baseColor 1 1 1 transmission 1 } }
Group { MaterialName mix Sphere { center 0 0 0 radius 1 } MaterialName glass
TriangleMesh { file open.obj }
TriangleMesh { file closed.obj }
TriangleMesh { file turned.obj }
MaterialName pane TriangleMesh { file pane.obj } }";
        let path = folder.path().join("a.txt");
        std::fs::write(&path, text).unwrap();
        let warnings = SceneFile::read(&path).unwrap().warnings();
        let expected = [
            ":2:29: warning: the texture `idle` is not used",
            ":3:64: warning: the material `other` is not used",
            ":6:21: warning: the dielectric mesh `open.obj` is open at 3 edges",
            ":8:21: warning: the dielectric mesh `turned.obj` is inside out",
            ":9:39: warning: the dielectric mesh `pane.obj` is open at 3 edges",
        ];
        assert_eq!(warnings.len(), expected.len(), "{warnings:#?}");
        for (warning, expected) in warnings.iter().zip(expected) {
            assert!(warning.contains(expected), "{warning}");
        }
    }
}
