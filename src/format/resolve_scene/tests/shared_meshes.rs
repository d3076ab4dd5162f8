//! Tests that an edited scene reuses the unchanged meshes of its earlier version, and reads only
//! changed meshes again.

use super::*;
use crate::format::SceneFile;
use crate::format::mesh;
use crate::format::mesh::TriangleMesh;
use crate::integrate::{Algorithm, Settings, SilentMonitor};
use std::collections::BTreeSet;
use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// Monitor that lists the files that a scene names, and counts the mesh files that are parsed.
#[derive(Default)]
struct FileMonitor {
    named: Mutex<BTreeSet<String>>,
    parsed: AtomicUsize,
}

impl MeshReadMonitor for FileMonitor {
    fn on_input_file_found(&self, path: &Path) {
        self.named.lock().unwrap().insert(path.file_name().unwrap().to_string_lossy().into_owned());
    }
    fn on_read_start(&self, _: &Path, _: u64) {
        self.parsed.fetch_add(1, Ordering::Relaxed);
    }
    fn on_bytes_parsed(&self, _: u64) {}
    fn on_read_end(&self, _: &Path, _: &TriangleMesh) {}
}

const TETRAHEDRON: &str = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";

/// Returns a scene of a mesh at rest, a moving one, and one with smooth normals and its own
/// materials. `reflectance` is that of the scene's material.
fn scene_of_meshes(reflectance: &str) -> String {
    format!(
        "PerspectiveCamera {{ center 0 0 5 direction 0 0 -1 angle 40 width 16 height 12 }}
        Lights {{ PointLight {{ position 1 2 4 color 9 9 9 }} }}
        Materials {{ Diffuse a {{ reflectance {reflectance} }} }}
        Group {{ TriangleMesh {{ file a.obj }}
        Moving {{ Translate .5 0 0 TriangleMesh {{ file a.obj }} }}
        Transform {{ Translate 0 -1 0 TriangleMesh {{ file b.obj materials file smoothAngle 80 }} }} }}"
    )
}

/// A folder with the meshes of [`scene_of_meshes`].
fn folder_of_meshes() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.obj"), TETRAHEDRON).unwrap();
    let split = TETRAHEDRON.replace("f 2 3", "usemtl red\nf 2 3");
    fs::write(folder.path().join("b.obj"), format!("mtllib b.mtl\n{split}")).unwrap();
    fs::write(folder.path().join("b.mtl"), "newmtl red\nKd .9 .1 .1\nillum 1\n").unwrap();
    folder
}

/// Builds the scene of `file`, reusing meshes of `earlier`. Returns the scene with the number of
/// mesh files parsed.
fn resolve_after(earlier: Option<&ResolvedScene>, file: &SceneFile) -> (ResolvedScene, usize) {
    let monitor = FileMonitor::default();
    let resolved = file.resolve_incrementally(earlier, &monitor, MemoryLimit::Unbounded).unwrap();
    (resolved, monitor.parsed.into_inner())
}

#[test]
fn material_libraries_and_unchanged_meshes_are_reported() {
    let folder = folder_of_meshes();
    let file = SceneFile::from_text("a.txt", &scene_of_meshes(".5 .5 .5"), folder.path()).unwrap();
    let first = resolve_after(None, &file).0;
    for earlier in [None, Some(&first)] {
        let monitor = FileMonitor::default();
        file.resolve_incrementally(earlier, &monitor, MemoryLimit::Unbounded).unwrap();
        assert_eq!(monitor.named.into_inner().unwrap(), ["a.obj", "b.mtl", "b.obj"].map(str::to_owned).into());
    }
}

/// Returns the bits of a picture of the scene.
fn picture_bits(scene: &Scene) -> Vec<u32> {
    let settings = Settings { unaimed_paths: 100, aimed_paths: 100, ..Settings::default() };
    let image = Algorithm::Path.prepare(scene, settings).render_pass(0, &SilentMonitor).image;
    image.iter().flat_map(|pixel| pixel.to_array().map(f32::to_bits)).collect()
}

#[test]
fn later_versions_parse_changed_meshes_only() {
    let folder = folder_of_meshes();
    let file = |text: &str| SceneFile::from_text("a.txt", text, folder.path()).unwrap();
    let (first, parsed) = resolve_after(None, &file(&scene_of_meshes(".5 .5 .5")));
    assert_eq!(parsed, 2);

    // Edit a material of the scene, and a material in the MTL file of a mesh.
    let edited = file(&scene_of_meshes(".2 .7 .2"));
    fs::write(folder.path().join("b.mtl"), "newmtl red\nKd .1 .1 .9\nillum 1\n").unwrap();
    let (second, parsed) = resolve_after(Some(&first), &edited);
    assert_eq!(parsed, 0);
    let (shared, fresh) = (picture_bits(&second.scene), picture_bits(&edited.resolve().unwrap()));
    assert!(shared == fresh && shared != picture_bits(&first.scene));

    // Edit the file of one mesh.
    fs::write(folder.path().join("a.obj"), TETRAHEDRON.replace("v 0 0 1", "v 0 0 1.5")).unwrap();
    let (third, parsed) = resolve_after(Some(&second), &edited);
    assert_eq!(parsed, 1);
    let (changed, fresh) = (picture_bits(&third.scene), picture_bits(&edited.resolve().unwrap()));
    assert!(changed == fresh && changed != shared);

    // With other mesh options, the mesh is read again. A mesh that the scene no longer uses is
    // dropped.
    let other_options = format!("{CAMERA}Group {{ TriangleMesh {{ file a.obj smoothAngle 9 }} }}");
    let (fourth, parsed) = resolve_after(Some(&third), &file(&other_options));
    assert_eq!((parsed, format!("{:?}", fourth.meshes).matches("obj").count()), (1, 1));
}

#[test]
fn embedded_meshes_are_compared_bit_by_bit() {
    let mesh = mesh::decode(Path::new("a.obj"), TETRAHEDRON.into(), &(), None).unwrap().mesh;
    let text = "Group { Moving { Translate .5 0 0 TriangleMesh { file inner } } Sphere { center 3 0 0 radius 1 } }";
    let file_with = |mesh: TriangleMesh| {
        let mut file = SceneFile::from_text("a.txt", &format!("{CAMERA}{text}"), Path::new("")).unwrap();
        file.assets.meshes.insert("inner".to_owned(), Arc::new(mesh));
        file
    };
    let first = resolve_after(None, &file_with(mesh.clone())).0;
    let only = |scene: &ResolvedScene| scene.meshes.expect_single_part();
    let same = resolve_after(Some(&first), &file_with(mesh.clone())).0;
    assert!(Arc::ptr_eq(&only(&same), &only(&first)) && only(&first).has_bvh());
    // 0 and −0 are equal as numbers, but not in their bits, so the mesh is not reused.
    let mut negated = mesh;
    negated.positions[0].z = -0.0;
    let other = resolve_after(Some(&first), &file_with(negated)).0;
    assert!(!Arc::ptr_eq(&only(&other), &only(&first)));
}
