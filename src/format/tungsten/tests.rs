//! Tests of the importer of Tungsten scenes.

mod lights;
mod materials;
mod primitives;

use super::decode;
use super::wo3::tests::triangle_file;
use crate::format::description::{
    ApertureDescription, CameraDescription, DirectionOrTarget, FocusDescription, GroupItem, LensDescription,
    MaterialDescription, ObjectDescription, ProjectionDescription,
};
use crate::format::import::{ImportOptions, ImportedScene};
use crate::format::transform_step::TransformStep;
use crate::stats::MemoryLimit;
use glam::{DAffine3, DVec3};
use std::path::Path;

/// Returns the text of a scene with the primitives `primitives` and the further members `rest`.
fn scene_json(primitives: &str, rest: &str) -> String {
    format!("{{\"primitives\": [{primitives}]{}{rest}}}", if rest.is_empty() { "" } else { ", " })
}

fn import_scene(primitives: &str, rest: &str) -> ImportedScene {
    import_in_folder(Path::new("/nowhere"), primitives, rest)
}

fn import_in_folder(folder: &Path, primitives: &str, rest: &str) -> ImportedScene {
    let text = scene_json(primitives, rest);
    let result = decode(&folder.join("a.json"), text.as_bytes(), &ImportOptions::default());
    result.unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn import_error(text: &str) -> String {
    decode(Path::new("/nowhere/a.json"), text.as_bytes(), &ImportOptions::default()).unwrap_err().to_string()
}

#[track_caller]
fn assert_import_error(primitives: &str, rest: &str, part: &str) {
    let error = import_error(&scene_json(primitives, rest));
    assert!(error.contains(part), "{error}");
}

/// Returns all objects with their transforms.
fn placed_objects(scene: &ImportedScene) -> Vec<(DAffine3, ObjectDescription)> {
    let items = scene.description.root.items.iter();
    let object = |item: &GroupItem| match item {
        GroupItem::Object(object) => Some(match &object.value {
            ObjectDescription::Transform { steps, object } => {
                (TransformStep::composed_matrix(steps), object.value.clone())
            }
            other => (DAffine3::IDENTITY, other.clone()),
        }),
        GroupItem::MaterialIndex(_) | GroupItem::MaterialName(_) => None,
    };
    items.filter_map(object).collect()
}

/// Returns the material of a sphere with the BSDF `bsdf`.
fn sphere_material(bsdf: &str) -> MaterialDescription {
    let scene = import_scene(&format!("{{\"type\": \"sphere\", \"bsdf\": {bsdf}}}"), "");
    scene.description.materials.last().unwrap().value.clone()
}

fn has_note(scene: &ImportedScene, part: &str) -> bool {
    scene.notes.iter().any(|note| note.message.contains(part))
}

fn camera_of(camera: &str) -> CameraDescription {
    import_scene("", &format!("\"camera\": {camera}")).description.camera.value
}

fn is_near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-12
}

#[test]
fn the_field_of_view_is_horizontal() {
    let camera = camera_of(
        r#"{"type": "pinhole", "fov": 90, "resolution": [200, 100],
        "transform": {"position": [0, 1, 5], "look_at": [0, 1, 0], "up": [0, 2, 0.5]}}"#,
    );
    assert_eq!((camera.center, camera.width, camera.height), (DVec3::new(0.0, 1.0, 5.0), 200, 100));
    let DirectionOrTarget::Direction(direction) = camera.aim else { panic!() };
    assert!(is_near(direction, DVec3::NEG_Z) && is_near(camera.up, DVec3::Y), "{camera:?}");
    let ProjectionDescription::Perspective { vertical_fov_degrees, lens: None } = camera.projection else { panic!() };
    assert!((vertical_fov_degrees - 2.0 * libm::atan(0.5).to_degrees()).abs() < 1e-12);
}

#[test]
fn a_lens_focuses_on_its_pivot() {
    let scene = import_scene(
        r#"{"name": "ball", "type": "sphere", "transform": {"position": [0, 0, 7]}}"#,
        r#""camera": {"type": "thinlens", "aperture_size": 0.25, "focus_distance": 2, "focus_pivot": "ball",
        "aperture": {"type": "blade", "blades": 5}}"#,
    );
    let ProjectionDescription::Perspective { lens, .. } = scene.description.camera.value.projection else { panic!() };
    let (aperture, focus) = (ApertureDescription::Radius(0.25), FocusDescription::Distance(7.0));
    assert_eq!(lens, Some(LensDescription { aperture, focus, blades: 5 }));
}

#[test]
fn other_cameras_and_members_are_noted() {
    let scene = import_scene(
        r#"{"type": "sphere", "colour": 1, "bsdf": {"type": "lambert", "shine": 2}}"#,
        r#""camera": {"type": "cubemap", "shutter": 1}, "bsdfs": [{"name": "unused", "type": "lambert", "odd": 3}]"#,
    );
    assert_eq!(scene.description.camera.value.projection, ProjectionDescription::Panorama);
    for part in ["cameras of kind `cubemap`", "`colour` is ignored (1×: primitives[0])", "`shine` is", "`shutter` is"]
    {
        assert!(has_note(&scene, part), "{part}: {:?}", scene.notes);
    }
    assert!(!has_note(&scene, "odd"), "{:?}", scene.notes);
}

#[test]
fn settings_become_flags() {
    let flags = |integrator: &str| {
        let rest = format!("\"integrator\": {integrator}, \"renderer\": {{\"spp\": 9}}");
        import_scene("", &rest).notes.into_iter().find(|note| note.message.contains("settings")).unwrap().message
    };
    let progressive = flags(r#"{"type": "progressive_photon_map", "max_bounces": 8, "alpha": 0.3}"#);
    assert!(progressive.ends_with("`--integrator sppm --max-bounces 7`"), "{progressive}");
    assert!(flags(r#"{"type": "path_tracer"}"#).ends_with("`--integrator path`"));
}

#[test]
fn damaged_files_are_refused_with_a_place() {
    for (text, part) in [
        ("{", "JSON: EOF"),
        ("[1]", "the JSON is no scene"),
        ("{\"a\": 1}", "the JSON is no scene"),
        ("{\"primitives\": 1}", "`primitives` is not a list"),
        ("{\"primitives\": [1]}", "`primitives[0]` is not an object"),
    ] {
        let error = import_error(text);
        assert!(error.contains(part), "{error}");
    }
    assert_import_error("{}", "", "primitives[0]: this object has no `type`");
    assert_import_error(r#"{"type": "sphere", "bsdf": "glass"}"#, "", "primitives[0]: no BSDF is called `glass`");
    assert_import_error(r#"{"type": "sphere", "bsdf": 3}"#, "", "`bsdf` is no BSDF");
    assert_import_error(r#"{"type": "sphere", "transform": [1, 2]}"#, "", "`transform` is no matrix");
    assert_import_error(r#"{"name": "a", "type": "mesh"}"#, "", "primitives[0] `a`: this mesh has no file");
    assert_import_error("", r#""camera": {"type": "pinhole", "fov": 180}"#, "between 0 and 180");
    assert_import_error("", r#""camera": {"type": "pinhole", "resolution": [0, 5]}"#, "`resolution` is not");
    let deep = format!("{{\"primitives\": {}", "[".repeat(200_000));
    assert!(import_error(&deep).contains("recursion limit"));
}

#[test]
fn memory_is_checked_before_it_is_taken() {
    let options = ImportOptions { memory_limit: MemoryLimit::ProcessBytes(1), ..ImportOptions::default() };
    let text = scene_json("", "");
    let error = decode(Path::new("/nowhere/a.json"), text.as_bytes(), &options).unwrap_err();
    assert!(error.to_string().contains("of memory"), "{error}");
}

#[test]
fn files_outside_the_folder_need_permission() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("a.wo3"), triangle_file([3, 1], [0, 1, 2, 0])).unwrap();
    let text = scene_json(r#"{"type": "mesh", "file": "../a.wo3"}"#, "");
    let import = |options: &ImportOptions| decode(&inner.join("a.json"), text.as_bytes(), options);
    let error = import(&ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("outside the folder"), "{error}");
    let trusting = ImportOptions { allows_outside_files: true, ..ImportOptions::default() };
    assert_eq!(import(&trusting).unwrap().assets.meshes.len(), 1);
}
