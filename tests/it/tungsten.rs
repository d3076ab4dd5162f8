//! Scenes of Tungsten: conversion to Caustica's scene language.
//!
//! Scenes by other people may not be distributed, so they are outside the repository: see
//! [`crate::support::world_data_folder`].

use crate::support::{project_path, world_data_folder};
use caustica::format::mesh::MeshFormat;
use caustica::format::{ConvertedScene, SceneFile, parse};
use caustica::image::{self, WriteOptions};
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use glam::Vec3;
use std::fs;
use std::path::{Path, PathBuf};

/// Scenes below the folder of Tungsten's scenes. Beside each scene stand parts of its messages, one
/// for each message.
const SCENES: [(&str, &[&str]); 4] = [
    ("cornell-box/scene.json", &["they stand for `--integrator path --max-bounces 63 --filter tent`"]),
    ("materialtest/materialtest.json", &["Beckmann", "coats absorb", "clear coats of index 1.5", "stand for"]),
    ("volumetric-caustic/scene.json", &["a medium behind flat surfaces", "--integrator hybrid --max-bounces 5"]),
    ("water-caustic/scene.json", &["they stand for `--integrator sppm --max-bounces 7 --filter tent`"]),
];

/// Renders one pass of a small picture of a scene that was read.
fn small_picture(mut file: SceneFile) -> Vec<Vec3> {
    (file.description.camera.value.width, file.description.camera.value.height) = (32, 18);
    let scene = file.resolve().unwrap_or_else(|error| panic!("{error}"));
    Algorithm::Path.prepare(&scene, Settings::default()).render_pass(0, &SilentMonitor).image
}

/// Fails if a scene renders other bits after conversion to scene text.
fn check_conversion(path: &Path) {
    let folder = tempfile::tempdir().unwrap();
    let file = SceneFile::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let printed = file.description.to_string();
    let again = parse("printed.txt", &printed).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(again == file.description, "{}: {printed}", path.display());
    let output = folder.path().join("converted.txt");
    let converted = ConvertedScene::new(&file, &output);
    fs::write(&output, converted.text).unwrap();
    converted.meshes.iter().for_each(|(path, mesh)| mesh.write(path, MeshFormat::PlyBinary, &[]).unwrap());
    for (path, picture) in &converted.pictures {
        image::write(path, picture, &WriteOptions::default()).unwrap();
    }
    let imported = small_picture(file);
    assert!(imported.iter().all(|pixel| pixel.is_finite()) && imported.iter().any(|pixel| *pixel != Vec3::ZERO));
    assert!(small_picture(SceneFile::read(&output).unwrap()) == imported, "{}", path.display());
}

/// Returns the scene files; empty if the data may be absent.
fn world_scenes() -> Vec<(PathBuf, &'static [&'static str])> {
    let Some(folder) = world_data_folder("tungsten") else { return Vec::new() };
    SCENES.iter().map(|(name, messages)| (folder.join(name), *messages)).collect()
}

#[test]
fn a_tungsten_scene_converts_to_the_same_bits() {
    check_conversion(&project_path("tests/data/tungsten/room.json"));
}

/// The red wall is on the left, as in all Cornell boxes.
#[test]
fn pictures_are_not_mirrored() {
    let picture = small_picture(SceneFile::read(&project_path("tests/data/tungsten/room.json")).unwrap());
    let column_color = |column: usize| (4..14).map(|row| picture[row * 32 + column]).sum::<Vec3>();
    let (left, right) = (column_color(4), column_color(27));
    assert!(left.x > 2.0 * left.y && right.y > 2.0 * right.x, "{left} {right}");
}

#[test]
fn tungsten_scenes_cause_the_expected_messages() {
    for (path, parts) in world_scenes() {
        let notes = SceneFile::read(&path).unwrap_or_else(|error| panic!("{error}")).notes;
        let has_note = |part: &str| notes.iter().any(|note| note.message.contains(part));
        assert!(parts.iter().all(|part| has_note(part)), "{}: {notes:?}", path.display());
        assert_eq!(notes.len(), parts.len(), "{}: {notes:?}", path.display());
    }
}

#[test]
#[ignore = "long: conversions of large scenes"]
fn tungsten_scenes_convert_to_the_same_bits() {
    world_scenes().iter().for_each(|(path, _)| check_conversion(path));
}
