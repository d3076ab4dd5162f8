//! Tests of the pbrt importer: values, hostile files and errors.

use super::decode;
use crate::format::description::{
    DirectionOrTarget, EnvironmentRadiance, GroupItem, LightDescription, MaterialKindDescription, MetalDescription,
    ObjectDescription, PointLightStrength, ProjectionDescription, ShapeDescription, TexturedValue,
};
use crate::format::import::{ImportOptions, ImportedScene, SceneReadError};
use crate::stats::MemoryLimit;
use glam::DVec3;
use std::path::Path;

fn import(text: &str) -> Result<ImportedScene, SceneReadError> {
    let options = ImportOptions { memory: MemoryLimit::Limit(1 << 28), ..ImportOptions::default() };
    decode(Path::new("/nowhere/test.pbrt"), text.as_bytes(), &options)
}

fn imported(text: &str) -> ImportedScene {
    import(text).unwrap_or_else(|e| panic!("{e}"))
}

fn messages(scene: &ImportedScene) -> String {
    scene.notes.iter().map(|note| format!("{}\n", note.message)).collect()
}

/// Returns the material of the only shape in a scene with the directives `text`.
fn material(text: &str) -> MaterialKindDescription {
    let scene = imported(&format!("WorldBegin {text} Shape \"sphere\""));
    scene.description.materials.last().unwrap().kind.clone()
}

#[test]
fn the_camera_has_the_view_and_handedness_of_pbrt() {
    let head = "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100";
    let scene = imported(&format!(
        "{head} LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" [ 90 ] \"float lensradius\" 2 \
         \"float focaldistance\" [3] WorldBegin LightSource \"point\" \"point3 from\" [1 2 3]"
    ));
    let camera = &scene.description.camera;
    let DirectionOrTarget::Direction(view) = camera.aim else { panic!() };
    // pbrt's right is +x; ours is view × up. The scene is mirrored along z.
    assert!(view.cross(camera.up).abs_diff_eq(DVec3::X, 1e-12));
    assert!(camera.center.abs_diff_eq(DVec3::new(0.0, 0.0, 5.0), 1e-12) && view.abs_diff_eq(DVec3::NEG_Z, 1e-12));
    assert_eq!((camera.width, camera.height), (200, 100));
    let ProjectionDescription::Perspective { angle, lens } = camera.projection else { panic!() };
    // The field of view is that of the shorter side.
    assert!((angle - 90.0).abs() < 1e-9 && lens.is_some());
    let LightDescription::Point { position, .. } = scene.description.lights[0].value else { panic!() };
    assert_eq!(position, DVec3::new(1.0, 2.0, -3.0));
    // A scene that mirrors itself is not mirrored again.
    let scene = imported(
        "Scale -1 1 1 LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" WorldBegin \
         LightSource \"point\" \"point3 from\" [1 2 3]",
    );
    let camera = &scene.description.camera;
    let DirectionOrTarget::Direction(view) = camera.aim else { panic!() };
    assert!(view.cross(camera.up).abs_diff_eq(DVec3::NEG_X, 1e-12), "{view}");
    let LightDescription::Point { position, .. } = scene.description.lights[0].value else { panic!() };
    assert_eq!(position, DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn lights_have_the_strength_of_the_file() {
    let scene = imported(
        "WorldBegin LightSource \"point\" \"rgb I\" [1 2 3] \"float scale\" 2 \
         LightSource \"infinite\" \"rgb L\" [.5 .5 .5] LightSource \"infinite\" \"float scale\" .25 \
         LightSource \"spot\" \"spectrum I\" [400 9 700 9] \
         AreaLightSource \"diffuse\" \"blackbody L\" 6500 \"float scale\" [ 3 ] Shape \"disk\"",
    );
    let lights: Vec<_> = scene.description.lights.iter().map(|light| light.value.clone()).collect();
    let LightDescription::Point { strength, .. } = lights[0] else { panic!() };
    assert_eq!(strength, PointLightStrength::Intensity(DVec3::new(2.0, 4.0, 6.0)));
    // Light spectra have luminance 1, whatever their values.
    let LightDescription::Spot { strength: PointLightStrength::Intensity(intensity), .. } = lights[1] else { panic!() };
    let luminance = |c: DVec3| c.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    assert!((luminance(intensity) - 1.0).abs() < 1e-9);
    let LightDescription::Environment(EnvironmentRadiance::Constant(sky)) = lights[2] else { panic!() };
    assert_eq!(sky, DVec3::splat(0.75));
    let GroupItem::Object(object) = &scene.description.root.items[1] else { panic!() };
    let ObjectDescription::Transform { object, .. } = &object.value else { panic!() };
    let ObjectDescription::Shape { emission: Some(radiance), shape } = &object.value else { panic!() };
    assert!((luminance(*radiance) - 3.0).abs() < 1e-9 && (radiance - 3.0).abs().max_element() < 0.2);
    assert!(matches!(shape, ShapeDescription::Disc { .. }));
}

#[test]
fn materials_of_both_versions_are_read() {
    let diffuse = material("Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]");
    assert_eq!(diffuse, MaterialKindDescription::Diffuse { reflectance: DVec3::new(0.1, 0.2, 0.3).into() });
    assert_eq!(material("Material \"matte\" \"color Kd\" [.1 .2 .3]"), diffuse);
    let MaterialKindDescription::Conductor { metal, roughness } = material(
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \"float roughness\" .09",
    ) else {
        panic!()
    };
    let MetalDescription::Index { eta, k } = metal else { panic!() };
    let (gold_eta, gold_k) = crate::bsdf::metal_refractive_index("gold").unwrap();
    assert_eq!((eta, k), (gold_eta.as_dvec3(), gold_k.as_dvec3()));
    // α is the square root of the roughness.
    let TexturedValue::Plain(alpha) = roughness else { panic!() };
    assert!((alpha - 0.3).abs() < 1e-12);
    let MaterialKindDescription::Dielectric { roughness, .. } =
        material("Material \"dielectric\" \"float roughness\" .09 \"bool remaproughness\" false")
    else {
        panic!()
    };
    assert_eq!(roughness, TexturedValue::Plain(0.09));
    assert!(import("WorldBegin Material \"measured\" Shape \"sphere\"").unwrap_err().to_string().contains("measured"));
}

#[test]
fn textures_become_constants_or_textures() {
    let scaled = material(
        "Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [.2 .4 .8] \
         Texture \"b\" \"spectrum\" \"scale\" \"texture tex\" \"a\" \"float scale\" .5 \
         Material \"diffuse\" \"texture reflectance\" \"b\"",
    );
    assert_eq!(scaled, MaterialKindDescription::Diffuse { reflectance: DVec3::new(0.1, 0.2, 0.4).into() });
    let checker = "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"float uscale\" 4 \
         Material \"diffuse\" \"texture reflectance\" \"c\"";
    let MaterialKindDescription::Diffuse { reflectance: TexturedValue::Texture(_) } = material(checker) else {
        panic!()
    };
}

#[test]
fn blocks_restore_the_state_and_instances_repeat_objects() {
    let scene = imported(
        "WorldBegin ObjectBegin \"o\" Shape \"sphere\" Shape \"disk\" ObjectEnd \
         AttributeBegin Translate 1 0 0 ObjectInstance \"o\" AttributeEnd ObjectInstance \"o\"",
    );
    assert_eq!(scene.description.root.items.len(), 2);
    let text = scene.description.to_string();
    assert_eq!(text.matches("Sphere").count(), 2, "{text}");
    assert!(messages(&scene).contains("no light"));
    assert!(import("WorldBegin AttributeEnd").is_err());
    assert!(import("WorldBegin ObjectInstance \"missing\"").is_err());
}

#[test]
fn motion_between_active_transforms_is_kept() {
    let scene = imported(
        "WorldBegin ActiveTransform EndTime Translate 0 2 0 Rotate 90 0 0 1 ActiveTransform All Shape \"sphere\"",
    );
    let text = scene.description.to_string();
    assert!(text.contains("Moving") && messages(&scene).contains("no light"), "{text}");
}

/// Each text is refused with its line and a remedy, without a panic.
#[test]
fn defects_are_refused_with_their_line() {
    let defects = [
        "Frobnicate",
        "\"value\"",
        "Translate 1 2",
        "Scale 0 1 1",
        "LookAt 0 0 0 0 0 0 0 1 0",
        "Shape",
        "Shape \"sphere\" \"float\" 1",
        "Shape \"sphere\" \"float radius\" [",
        "Shape \"sphere\" \"float radius\" [ nan ]",
        "Shape \"sphere\" \"float radius\" -1",
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
        "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1]",
        "Shape \"loopsubdiv\" \"integer levels\" 30 \"point3 P\" [0 0 0 1 0 0 0 1 0]",
        "Shape \"plymesh\" \"string filename\" \"missing.ply\"",
        "Include \"missing.pbrt\"",
        "LightSource \"point\" \"rgb I\" [1 2]",
        "LightSource \"point\" \"blackbody I\" [0]",
        "LightSource \"spot\" \"float coneangle\" 200",
        "CoordSysTransform \"camera\"",
        "Material \"diffuse\" \"texture reflectance\" \"missing\" Shape \"sphere\"",
        "NamedMaterial \"missing\" Shape \"sphere\"",
        "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"m\" \"m\"] NamedMaterial \"m\" Shape \"sphere\"",
        "ObjectBegin \"o\" ObjectBegin \"p\"",
        "ObjectBegin \"o\"",
        "Film \"rgb\" \"integer xresolution\" 0",
        "Camera \"perspective\" \"float fov\" 180 WorldBegin",
        "Camera \"realistic\" WorldBegin",
    ];
    for defect in defects {
        let error = import(&format!("\n{defect}")).err().unwrap_or_else(|| panic!("{defect} is accepted"));
        assert!(error.to_string().contains("line 2") || defect.starts_with("Obj"), "{defect}: {error}");
    }
}

#[test]
fn deep_and_large_scenes_are_refused() {
    let deep = "AttributeBegin ".repeat(20_000);
    assert!(import(&deep).unwrap_err().to_string().contains("too deep"));
    // Nested objects that stand for 2⁴⁰ spheres.
    let mut text = "WorldBegin ObjectBegin \"0\" Shape \"sphere\" ObjectEnd ".to_owned();
    for i in 0..40 {
        let next = i + 1;
        text += &format!("ObjectBegin \"{next}\" ObjectInstance \"{i}\" ObjectInstance \"{i}\" ObjectEnd ");
    }
    assert!(matches!(import(&text), Err(SceneReadError::Memory { .. })));
}

#[test]
fn files_include_each_other_but_not_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("a.pbrt", "WorldBegin Include \"b.pbrt\"");
    write("b.pbrt", "Shape \"sphere\"");
    write("loop.pbrt", "Include \"loop.pbrt\"");
    write("many.pbrt", &"Include \"loop2.pbrt\" ".repeat(100));
    write("loop2.pbrt", &"Include \"many.pbrt\" ".repeat(100));
    let read = |name: &str| {
        let path = folder.path().join(name);
        decode(&path, &std::fs::read(&path).unwrap(), &ImportOptions::default())
    };
    assert_eq!(read("a.pbrt").unwrap().description.root.items.len(), 2);
    for name in ["loop.pbrt", "many.pbrt"] {
        assert!(read(name).unwrap_err().to_string().contains("include each other"));
    }
    let outside = tempfile::tempdir().unwrap();
    std::fs::write(outside.path().join("c.pbrt"), "Shape \"sphere\"").unwrap();
    write("d.pbrt", &format!("Include \"{}\"", outside.path().join("c.pbrt").display()));
    assert!(read("d.pbrt").unwrap_err().to_string().contains("outside"));
}
