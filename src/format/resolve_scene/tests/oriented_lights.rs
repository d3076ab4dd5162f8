//! Tests of projectors and goniometric lights in scenes.

use super::*;
use crate::image::{self, Image, WriteOptions};

/// Returns a folder with a white picture, a black picture and two profiles.
fn folder_of_light_files() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("white.exr", 1.0), ("black.exr", 0.0)] {
        let pixels = Image::from_pixels(2, 2, vec![Vec3::splat(value); 4]).unwrap();
        image::write(&folder.path().join(name), &pixels, &WriteOptions::default()).unwrap();
    }
    std::fs::write(folder.path().join("lamp.txt"), "# angle intensity\n0 1\n90 1 # edge\n180 1\n").unwrap();
    std::fs::write(folder.path().join("bad.txt"), "0 1\n0 2\n").unwrap();
    folder
}

/// Resolves a scene of a ball and `light`; returns the error of parsing or resolving it, if any.
fn resolve_scene_with_light(light: &str) -> Result<Scene, SceneError> {
    let ball = "Materials { Diffuse { reflectance 1 1 1 } } Group { Sphere { center 0 0 0 radius 1 } }";
    let text = format!("Lights {{ {light} }} {ball}");
    parse("a.txt", &format!("{CAMERA}{text}"))?;
    resolve_in_folder(folder_of_light_files().path(), &text)
}

#[test]
fn oriented_lights_have_their_power_and_axis() {
    let projector = "ProjectorLight { position 0 4 0 lookAt 0 0 0 angle 40 file white.exr power 6 6 6 }";
    let goniometric = "GoniometricLight { position 0 4 0 direction 0 -1 0 profile lamp.txt power 6 6 6 }";
    let map = "GoniometricLight { position 0 4 0 direction 1 0 0 file white.exr power 6 6 6 }";
    for text in [projector, goniometric, map] {
        let scene = resolve_scene_with_light(text).unwrap();
        let light = &scene.lights()[0];
        assert!((light.power(scene.photon_domain()).x - 6.0).abs() < 1e-4, "{text}");
        let below = light.position().unwrap() - Vec3::Y * 3.0;
        assert!(light.sample_li(below, glam::Vec2::ZERO).is_some(), "{text}");
        let above = light.position().unwrap() + Vec3::Y * 3.0;
        let is_projector = matches!(light, Light::Projector(_));
        assert_eq!(light.sample_li(above, glam::Vec2::ZERO).is_none(), is_projector, "{text}");
    }
}

#[test]
fn invalid_oriented_lights_are_errors() {
    for (light, message) in [
        ("ProjectorLight { position 0 4 0 direction 0 -1 0 angle 40 file black.exr power 1 1 1 }", "black"),
        ("GoniometricLight { position 0 4 0 direction 0 -1 0 profile bad.txt power 1 1 1 }", "table of angles"),
        ("GoniometricLight { position 0 4 0 direction 0 -1 0 up 0 1 0 file white.exr power 1 1 1 }", "parallel"),
        ("GoniometricLight { position 0 4 0 direction 0 -1 0 up 1e-15 1 0 file white.exr power 1 1 1 }", "parallel"),
    ] {
        let error = resolve_scene_with_light(light).unwrap_err();
        let said = [error.message(), error.remedy()];
        assert!(said.iter().any(|text| text.contains(message)), "{error}: {said:?}");
    }
}
