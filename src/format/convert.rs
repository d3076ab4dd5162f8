//! Converts a scene of any format to a text in Caustica's scene language. Embedded meshes, pictures
//! and grids become separate files.

use super::description::{
    DensityDescription, GroupItem, ObjectDescription, ObjectGroup, SceneDescription, Spanned, TextureKindDescription,
};
use super::file::SceneFile;
use super::grid::DensityGridData;
use super::mesh::TriangleMesh;
use super::resolve::candidate_file_paths;
use crate::image::Image;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene as text in the scene language, with the meshes, pictures and grids to write beside it.
#[derive(Clone, Debug)]
pub struct ConvertedScene {
    /// Text in the scene language.
    pub text: String,
    /// Embedded meshes, each with the path of the PLY file to write.
    pub meshes: Vec<(PathBuf, Arc<TriangleMesh>)>,
    /// Embedded pictures, each with the path of the OpenEXR file to write.
    pub pictures: Vec<(PathBuf, Arc<Image>)>,
    /// Embedded density grids, each with the path of the grid file to write.
    pub grids: Vec<(PathBuf, Arc<DensityGridData>)>,
    /// Paths of existing files that the text refers to, such as meshes and pictures. Files still to
    /// be written are not included.
    pub existing_file_paths: Vec<PathBuf>,
}

impl ConvertedScene {
    /// Converts `scene` to a text that is to be saved as the file `output`. Writes no file.
    ///
    /// Names of mesh, picture and grid files begin with the file stem of `output`. Paths of
    /// existing files become absolute if `output` is not in the folder of the scene, because
    /// relative paths would then lead nowhere.
    #[must_use]
    pub fn new(scene: &SceneFile, output: &Path) -> Self {
        let mut description = scene.description.clone();
        let folder = output.parent().unwrap_or(Path::new(""));
        let stem = output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut names: BTreeMap<String, String> = BTreeMap::new();
        let (mut meshes, mut pictures, mut grids) = (Vec::new(), Vec::new(), Vec::new());
        let mut existing_file_paths = Vec::new();
        for (i, (path, mesh)) in scene.assets.meshes.iter().enumerate() {
            let name = format!("{stem}-mesh{i}.ply");
            meshes.push((folder.join(&name), Arc::clone(mesh)));
            names.insert(path.clone(), name);
        }
        for (i, (path, picture)) in scene.assets.pictures.iter().enumerate() {
            let name = format!("{stem}-picture{i}.exr");
            pictures.push((folder.join(&name), Arc::clone(picture)));
            names.insert(path.clone(), name);
        }
        for (i, (path, grid)) in scene.assets.grids.iter().enumerate() {
            let name = format!("{stem}-grid{i}.grid");
            grids.push((folder.join(&name), Arc::clone(grid)));
            names.insert(path.clone(), name);
        }
        let same_folder = canonical_path(folder) == canonical_path(scene.folder());
        visit_file_paths(&mut description, &mut |path| {
            if let Some(name) = names.get(path.as_str()) {
                path.clone_from(name);
                return;
            }
            let Some(file) = candidate_file_paths(scene.folder(), Path::new(path.as_str())).find(|file| file.is_file())
            else {
                return;
            };
            if !same_folder && let Some(absolute) = canonical_path(&file).as_deref().and_then(Path::to_str) {
                absolute.clone_into(path);
            }
            existing_file_paths.push(file);
        });
        Self { text: description.to_string(), meshes, pictures, grids, existing_file_paths }
    }
}

/// Returns the absolute path of a file or folder, in which symbolic links are replaced by their
/// targets. Returns `None` if the file or folder does not exist.
fn canonical_path(path: &Path) -> Option<PathBuf> {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    path.canonicalize().ok()
}

/// Calls `visit` for each path of a mesh, picture, light profile or grid in the description.
fn visit_file_paths(description: &mut SceneDescription, visit: &mut impl FnMut(&mut String)) {
    for light in &mut description.lights {
        if let Some(path) = light.value.file_path_mut() {
            visit(path);
        }
    }
    let textures: Vec<String> = description.textures.iter().map(|texture| texture.name.clone()).collect();
    for texture in &mut description.textures {
        match &mut texture.value.kind {
            TextureKindDescription::Image { path, .. } => visit(&mut path.value),
            TextureKindDescription::Checker { .. } | TextureKindDescription::Solid { .. } => {}
        }
    }
    for medium in &mut description.media {
        match &mut medium.value.density {
            DensityDescription::Grid { path, .. } => visit(&mut path.value),
            DensityDescription::Homogeneous | DensityDescription::Cloud { .. } => {}
        }
    }
    // A texture field of a material holds the name of a texture or the path of a picture. Only
    // paths are visited.
    let mut visit_path = |name: &mut Spanned<String>| {
        if !textures.contains(&name.value) {
            visit(&mut name.value);
        }
    };
    for material in &mut description.materials {
        material.value.texture_names_or_paths_mut().for_each(&mut visit_path);
    }
    visit_group_paths(&mut description.root, visit);
}

fn visit_group_paths(group: &mut ObjectGroup, visit: &mut impl FnMut(&mut String)) {
    for item in &mut group.items {
        match item {
            GroupItem::Object(object) => visit_object_paths(&mut object.value, visit),
            GroupItem::MaterialIndex(_) | GroupItem::MaterialName(_) => {}
        }
    }
}

fn visit_object_paths(object: &mut ObjectDescription, visit: &mut impl FnMut(&mut String)) {
    match object {
        ObjectDescription::Group(group) => visit_group_paths(group, visit),
        ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => {
            visit_object_paths(&mut object.value, visit)
        }
        ObjectDescription::Shape { shape, .. } => {
            if let Some(path) = shape.file_path_mut() {
                visit(path);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::parse;
    use glam::DVec3;

    #[test]
    fn assets_become_files_and_paths_stay_valid() {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("in"), folder.path().join("out"));
        std::fs::create_dir(&input).unwrap();
        std::fs::create_dir(&output).unwrap();
        std::fs::write(input.join("b.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let text = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 angle 30 }
            Group { TriangleMesh { file a } Transform { Scale 2 2 2 TriangleMesh { file b.obj } } }";
        std::fs::write(input.join("scene.txt"), text).unwrap();
        let mut scene = SceneFile::read(&input.join("scene.txt")).unwrap();
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].to_vec();
        let mesh = TriangleMesh { positions: corners, triangles: vec![[0, 1, 2]], ..TriangleMesh::default() };
        scene.assets.meshes.insert("a".to_owned(), Arc::new(mesh));
        assert_eq!(scene.resolve().unwrap().triangle_count(), 2);
        let converted = ConvertedScene::new(&scene, &output.join("new.txt"));
        assert_eq!(converted.meshes[0].0, output.join("new-mesh0.ply"));
        assert!(converted.text.contains("file new-mesh0.ply"), "{}", converted.text);
        assert!(converted.text.contains(input.canonicalize().unwrap().join("b.obj").to_str().unwrap()));
        let beside = ConvertedScene::new(&scene, &input.join("new.txt"));
        assert!(beside.text.contains("obj_file b.obj") && parse("new.txt", &beside.text).is_ok());
    }
}
