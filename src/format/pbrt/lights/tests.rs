//! Tests of lights of pbrt: directional patterns, power, and two-sided area lights.

use crate::format::description::{
    DirectionOrTarget, DiscDescription, GoniometricLightDescription, GroupItem, IntensityDistribution,
    LightDescription, ObjectDescription, PointLightDescription, PointLightStrength, ProjectorLightDescription,
    ShapeDescription, Spanned,
};
use crate::format::import::{ImportOptions, ImportedScene};
use crate::format::pbrt::decode;
use crate::format::pbrt::tests::{import_text, note_messages};
use crate::image::{Image, WriteOptions, srgb_decode, write};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Imports `text`, which refers to the picture `a.exr`.
///
/// The picture has the size (`width`, `height`) and gray `pixels`, row by row from the top.
fn import_with_picture((width, height): (u32, u32), pixels: &[f32], text: &str) -> ImportedScene {
    let folder = tempfile::tempdir().unwrap();
    let image = Image::from_pixels(width, height, pixels.iter().map(|p| Vec3::splat(*p)).collect()).unwrap();
    write(&folder.path().join("a.exr"), &image, &WriteOptions::default()).unwrap();
    decode(&folder.path().join("a.pbrt"), text.as_bytes(), &ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns the emitted radiance and the geometry of each shape.
fn emitting_shapes(scene: &ImportedScene) -> Vec<(DVec3, ShapeDescription)> {
    fn shape(object: &Spanned<ObjectDescription>) -> (DVec3, ShapeDescription) {
        match &object.value {
            ObjectDescription::Shape { shape, emission } => (emission.unwrap_or_default(), shape.clone()),
            ObjectDescription::Transform { object, .. } => shape(object),
            other => panic!("{other:?}"),
        }
    }
    let items = scene.description.root.items.iter();
    items.filter_map(|item| if let GroupItem::Object(object) = item { Some(shape(object)) } else { None }).collect()
}

#[test]
fn pictures_of_projectors_stay_upright() {
    let light = "LightSource \"projection\" \"string filename\" \"a.exr\" \"float fov\" 90 \"float scale\" 3";
    for (head, pixels) in [("", [1.0, 2.0, 3.0, 4.0]), ("Scale -1 1 1", [2.0, 1.0, 4.0, 3.0])] {
        let scene = import_with_picture((2, 2), &[1.0, 2.0, 3.0, 4.0], &format!("WorldBegin {head} {light}"));
        let LightDescription::Projector(ProjectorLightDescription {
            pose,
            vertical_fov_degrees: angle,
            path,
            strength,
        }) = &scene.description.lights[0].value
        else {
            panic!()
        };
        // The scene is mirrored along z: pbrt's +z becomes −z. The right of the picture is +x.
        assert_eq!((pose.aim, pose.up), (DirectionOrTarget::Direction(DVec3::NEG_Z), Some(DVec3::Y)));
        assert!((angle - 90.0).abs() < 1e-9 && *strength == PointLightStrength::Intensity(DVec3::splat(3.0)));
        let values: Vec<f32> = scene.assets.pictures[&path.value].pixels().iter().map(|pixel| pixel.x).collect();
        assert_eq!(values, pixels, "{head}");
    }
    // `fov` is the angle of the shorter side, here the width.
    let scene = import_with_picture((1, 2), &[1.0, 2.0], &format!("WorldBegin {light}"));
    let LightDescription::Projector(ProjectorLightDescription { vertical_fov_degrees: angle, .. }) =
        scene.description.lights[0].value
    else {
        panic!()
    };
    assert!((angle - 2.0 * libm::atan(2.0).to_degrees()).abs() < 1e-9);
}

/// In pbrt's map, the top is +y of the light, and the left quarter lies between +x and +z.
#[test]
fn maps_of_goniometric_lights_keep_their_directions() {
    let mut pixels = [0.0; 32];
    // Only the left quarter of the top half is bright.
    [0, 1, 8, 9].iter().for_each(|i| pixels[*i] = 1.0);
    let text = "WorldBegin LightSource \"goniometric\" \"string mapname\" \"a.exr\"";
    let scene = import_with_picture((8, 4), &pixels, text);
    let LightDescription::Goniometric(GoniometricLightDescription {
        pose,
        distribution: IntensityDistribution::MapFile(path),
        ..
    }) = &scene.description.lights[0].value
    else {
        panic!()
    };
    assert_eq!(pose.aim, DirectionOrTarget::Direction(DVec3::Z));
    let map = &scene.assets.pictures[&path.value];
    // In the converted map, the left quarter lies between −z and +x. This −z is pbrt's +z.
    for (i, pixel) in map.pixels().iter().enumerate() {
        let (x, y) = ((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5);
        let is_bright = x < 2.0 && y < 2.0;
        assert!((pixel.x > 0.4) == is_bright, "{x} {y}: {pixel}");
    }
    let plain = import_text("WorldBegin LightSource \"goniometric\" \"rgb I\" [1 2 3]");
    assert!(matches!(plain.description.lights[0].value, LightDescription::Point(_)));
}

#[test]
fn power_sets_the_flux_of_lights() {
    let scene = import_text(
        "WorldBegin LightSource \"point\" \"float power\" 10 \"rgb I\" [1 .5 0] \"float scale\" 2 \
         AreaLightSource \"diffuse\" \"float power\" 12 Scale 2 2 2 Shape \"sphere\" \
         Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]",
    );
    let LightDescription::Point(PointLightDescription { strength, .. }) = scene.description.lights[0].value else {
        panic!()
    };
    assert_eq!(strength, PointLightStrength::Power(DVec3::new(20.0, 10.0, 0.0)));
    let radiance: Vec<f64> = emitting_shapes(&scene).iter().map(|(radiance, _)| radiance.x).collect();
    for (radiance, area) in radiance.iter().zip([16.0 * PI, 2.0]) {
        assert!((radiance * PI * area - 12.0).abs() < 1e-9, "{radiance}");
    }
}

#[test]
fn two_sided_lamps_emit_on_their_back() {
    let scene = import_text(
        "WorldBegin AreaLightSource \"diffuse\" \"bool twosided\" true \"float power\" 6 Shape \"disk\" \
         Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] Shape \"sphere\"",
    );
    let lamps = emitting_shapes(&scene);
    assert_eq!(lamps.len(), 5);
    let [
        (front, ShapeDescription::Disc(DiscDescription { center, normal, .. })),
        (back, ShapeDescription::Disc(DiscDescription { center: behind, normal: other, .. })),
    ] = &lamps[..2]
    else {
        panic!()
    };
    // Both sides share the power.
    assert!(front == back && (front.x * PI * PI * 2.0 - 6.0).abs() < 1e-9);
    assert!(*normal == -*other && (behind - center).dot(*normal) < 0.0 && behind.distance(*center) < 1e-3);
    let meshes: Vec<_> = scene.assets.meshes.values().collect();
    let normal = |i: usize| {
        let [a, b, c] = meshes[i].triangles[0].map(|v| meshes[i].positions[v as usize]);
        (b - a).cross(c - a)
    };
    assert!(normal(0).dot(normal(1)) < -0.99 && meshes[0].positions != meshes[1].positions);
}

#[test]
fn projectors_of_v3_are_narrower_and_upside_down() {
    let text = "Film \"image\" WorldBegin LightSource \"projection\" \"string mapname\" \"a.exr\"";
    let scene = import_with_picture((2, 2), &[1.0, 2.0, 3.0, 4.0], text);
    let LightDescription::Projector(ProjectorLightDescription { vertical_fov_degrees: angle, path, .. }) =
        &scene.description.lights[0].value
    else {
        panic!()
    };
    assert!((angle - 45.0).abs() < 1e-9, "{angle}");
    let values: Vec<f32> = scene.assets.pictures[&path.value].pixels().iter().map(|pixel| pixel.x).collect();
    assert_eq!(values, [3.0, 4.0, 1.0, 2.0]);
}

#[test]
fn spotlights_of_v3_fall_off_by_the_fourth_power() {
    let scene = import_text("Film \"image\" WorldBegin LightSource \"spot\" \"rgb I\" [1 2 3]");
    let LightDescription::Goniometric(GoniometricLightDescription {
        pose,
        distribution: IntensityDistribution::MapFile(path),
        strength,
    }) = &scene.description.lights[0].value
    else {
        panic!()
    };
    // The scene is mirrored along z: pbrt's +z becomes −z.
    assert_eq!((pose.up, *strength), (Some(DVec3::NEG_Z), PointLightStrength::Intensity(DVec3::new(1.0, 2.0, 3.0))));
    let map = &scene.assets.pictures[&path.value];
    let cos = |degrees: f64| libm::cos(degrees.to_radians());
    let delta = (cos(27.0625) - cos(30.0)) / (cos(25.0) - cos(30.0));
    for (row, expected) in [(0, 1.0), (199, 1.0), (216, delta * delta * delta * delta), (240, 0.0)] {
        assert!((f64::from(map.pixels()[row].x) - expected).abs() < 1e-6, "{row}");
    }
}

/// In pbrt, each triangle of a mesh is a lamp of its own, and has the whole `power`.
#[test]
fn each_triangle_of_a_mesh_emits_the_power() {
    let lamp = |shape: &str| {
        let text = format!("WorldBegin AreaLightSource \"diffuse\" \"float power\" 12 Shape {shape}");
        let scene = import_text(&text);
        (PI * emitting_shapes(&scene)[0].0.x, note_messages(&scene).contains("even over their area"))
    };
    let mesh = |points: &str| {
        lamp(&format!("\"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [0 0 0 {points} 0 1 0]"))
    };
    // Areas of the two triangles: ½ and ½ in the first case, ½ and 1 in the second.
    for (points, expected, is_noted) in [("1 0 0 1 1 0", 24.0, false), ("1 0 0 2 1 0", 16.0, true)] {
        let (emittance, has_note) = mesh(points);
        assert!((emittance - expected).abs() < 1e-9 && has_note == is_noted, "{emittance} {has_note}");
    }
    let (emittance, has_note) = lamp("\"bilinearmesh\" \"point3 P\" [0 0 0 2 0 0 0 1 0 2 1 0]");
    assert!((emittance - 6.0).abs() < 1e-9 && !has_note, "{emittance}");
}

#[test]
fn opacity_of_v4_lamps_dims_their_light() {
    let lamp = |head: &str, alpha: &str| {
        let scene = import_text(&format!(
            "{head} WorldBegin Texture \"t\" \"float\" \"checkerboard\" AreaLightSource \"diffuse\" \
             \"rgb L\" [4 4 4] Shape \"disk\" {alpha}"
        ));
        (emitting_shapes(&scene)[0].0.x, note_messages(&scene))
    };
    assert_eq!(lamp("", "\"float alpha\" .25").0, 1.0);
    assert_eq!(lamp("Film \"image\"", "\"float alpha\" .25").0, 4.0);
    let (radiance, notes) = lamp("", "\"float alpha\" 0");
    assert!(radiance == 4.0 && notes.contains("lamps with opacity 0"), "{radiance} {notes}");
    let (radiance, notes) = lamp("", "\"texture alpha\" \"t\"");
    assert!(radiance == 2.0 && notes.contains("texture of opacity"), "{radiance} {notes}");
}

#[test]
fn pictures_of_v3_lights_are_not_decoded() {
    let folder = tempfile::tempdir().unwrap();
    let image = ::image::RgbImage::from_raw(1, 1, vec![51, 51, 51]).unwrap();
    image.save(folder.path().join("a.png")).unwrap();
    let value = |text: &str| {
        let scene = decode(&folder.path().join("a.pbrt"), text.as_bytes(), &ImportOptions::default()).unwrap();
        f64::from(scene.assets.pictures.values().next().unwrap().pixels()[0].x)
    };
    let old = value("Film \"image\" WorldBegin LightSource \"projection\" \"string mapname\" \"a.png\"");
    let new = value("WorldBegin LightSource \"projection\" \"string filename\" \"a.png\"");
    assert!((old - 0.2).abs() < 1e-6 && (new - srgb_decode(0.2)).abs() < 1e-6, "{old} {new}");
}
