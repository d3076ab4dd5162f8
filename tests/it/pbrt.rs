//! Scenes of pbrt: conversion to Caustica's scene language.
//!
//! Scenes by other people may not be distributed, so they are outside the repository: see
//! [`crate::support::world_data_folder`].

use crate::support::{project_path, world_data_folder};
use caustica::format::grid::{self, GridEncoding};
use caustica::format::mesh::MeshFormat;
use caustica::format::{ConvertedScene, SceneFile, parse};
use caustica::image::{self, WriteOptions};
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use glam::Vec3;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the pbrt files in a folder and its subfolders that are whole scenes.
fn scenes_below(folder: &Path) -> Vec<PathBuf> {
    let mut scenes = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() && entry.file_name().is_some_and(|name| name != "geometry") {
            scenes.extend(scenes_below(&entry));
        } else if entry.extension().is_some_and(|e| e == "pbrt") {
            scenes.push(entry);
        }
    }
    scenes.sort();
    scenes
}

/// Renders one pass of a small picture of a scene that was read.
fn small_picture(mut file: SceneFile) -> Vec<Vec3> {
    (file.description.camera.value.width, file.description.camera.value.height) = (24, 18);
    let scene = file.resolve().unwrap_or_else(|e| panic!("{e}"));
    Algorithm::Path.prepare(&scene, Settings::default()).render_pass(0, &SilentMonitor).image
}

/// Fails if a scene renders other bits after conversion, or if it is refused without a place and a
/// reason.
fn check_conversion(scenes: impl IntoIterator<Item = PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let mut rendered = 0;
    for scene in scenes {
        let file = match SceneFile::read(&scene) {
            Ok(file) => file,
            Err(error) => {
                assert!(error.to_string().contains("line "), "{}: {error}", scene.display());
                continue;
            }
        };
        let printed = file.description.to_string();
        let again = parse("printed.txt", &printed).unwrap_or_else(|e| panic!("{}: {e}", scene.display()));
        assert!(again == file.description, "{}", scene.display());
        let output = folder.path().join("converted.txt");
        let converted = ConvertedScene::new(&file, &output);
        fs::write(&output, converted.text).unwrap();
        converted.meshes.iter().for_each(|(path, mesh)| mesh.write(path, MeshFormat::PlyBinary, &[]).unwrap());
        converted.grids.iter().for_each(|(path, values)| grid::write(path, values, GridEncoding::F32).unwrap());
        for (path, picture) in &converted.pictures {
            image::write(path, picture, &WriteOptions::default()).unwrap();
        }
        let imported = small_picture(file);
        assert!(imported.iter().all(|pixel| pixel.is_finite()));
        assert!(small_picture(SceneFile::read(&output).unwrap()) == imported, "{}", scene.display());
        rendered += 1;
    }
    assert!(rendered > 0);
}

#[test]
#[ignore = "long: conversions of many scenes"]
fn pbrt_scenes_convert_to_the_same_bits() {
    check_conversion(["cell", "smoke"].map(|name| project_path(&format!("tests/data/pbrt/{name}.pbrt"))));
    if let Some(folder) = world_data_folder("pbrt-v3") {
        check_conversion(scenes_below(&folder));
    }
}

#[test]
#[ignore = "long: reads large scenes"]
fn pbrt_v4_scenes_convert_to_the_same_bits() {
    if let Some(folder) = world_data_folder("pbrt-v4") {
        check_conversion(scenes_below(&folder));
    }
}
