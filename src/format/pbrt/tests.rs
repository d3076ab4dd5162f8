//! Tests of the pbrt importer: values, hostile files and errors.

use super::decode;
use crate::format::description::{
    ConductorDescription, DielectricDescription, DiffuseDescription, DiffuseTransmissionDescription, DirectionOrTarget,
    EnvironmentRadiance, GroupItem, LightDescription, MaterialKindDescription, MetalDescription, ObjectDescription,
    PointLightDescription, PointLightStrength, ProjectionDescription, ShapeDescription, SpotLightDescription,
    TexturedValue, TransformStep,
};
use crate::format::import::{ImportOptions, ImportedScene, SceneReadError};
use crate::stats::MemoryLimit;
use glam::{DAffine3, DVec3, Vec3};
use std::path::Path;

pub(super) fn try_import_text(text: &str) -> Result<ImportedScene, SceneReadError> {
    let options = ImportOptions { memory_limit: MemoryLimit::ProcessBytes(1 << 28), ..ImportOptions::default() };
    decode(Path::new("/nowhere/test.pbrt"), text.as_bytes(), &options)
}

pub(super) fn import_text(text: &str) -> ImportedScene {
    try_import_text(text).unwrap_or_else(|e| panic!("{e}"))
}

pub(super) fn note_messages(scene: &ImportedScene) -> String {
    scene.notes.iter().map(|note| format!("{}\n", note.message)).collect()
}

/// Returns the material of the only shape in a scene with the directives `text`.
fn sphere_material(text: &str) -> MaterialKindDescription {
    let scene = import_text(&format!("WorldBegin {text} Shape \"sphere\""));
    scene.description.materials.last().unwrap().kind.clone()
}

#[test]
fn the_camera_has_the_view_and_handedness_of_pbrt() {
    let head = "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100";
    let scene = import_text(&format!(
        "{head} LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" [ 90 ] \"float lensradius\" 2 \
         \"float focaldistance\" [3] WorldBegin LightSource \"point\" \"point3 from\" [1 2 3]"
    ));
    let camera = &scene.description.camera;
    let DirectionOrTarget::Direction(view) = camera.aim else { panic!() };
    // The right of the picture is +x in pbrt, and view × up in Caustica. The scene is mirrored
    // along z.
    assert!(view.cross(camera.up).abs_diff_eq(DVec3::X, 1e-12));
    assert!(camera.center.abs_diff_eq(DVec3::new(0.0, 0.0, 5.0), 1e-12) && view.abs_diff_eq(DVec3::NEG_Z, 1e-12));
    assert_eq!((camera.width, camera.height), (200, 100));
    let ProjectionDescription::Perspective { vertical_fov_degrees: angle, lens } = camera.projection else { panic!() };
    // `fov` is the angle of the shorter side, here the height.
    assert!((angle - 90.0).abs() < 1e-9 && lens.is_some());
    let LightDescription::Point(PointLightDescription { position, .. }) = scene.description.lights[0].value else {
        panic!()
    };
    assert_eq!(position, DVec3::new(1.0, 2.0, -3.0));
    // A scene whose camera transform mirrors is not mirrored again.
    let scene = import_text(
        "Scale -1 1 1 LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" WorldBegin \
         LightSource \"point\" \"point3 from\" [1 2 3]",
    );
    let camera = &scene.description.camera;
    let DirectionOrTarget::Direction(view) = camera.aim else { panic!() };
    assert!(view.cross(camera.up).abs_diff_eq(DVec3::NEG_X, 1e-12), "{view}");
    let LightDescription::Point(PointLightDescription { position, .. }) = scene.description.lights[0].value else {
        panic!()
    };
    assert_eq!(position, DVec3::new(1.0, 2.0, 3.0));
}

#[test]
fn lights_have_the_strength_of_the_file() {
    let scene = import_text(
        "WorldBegin LightSource \"point\" \"rgb I\" [1 2 3] \"float scale\" 2 \
         LightSource \"infinite\" \"rgb L\" [.5 .5 .5] LightSource \"infinite\" \"float scale\" .25 \
         LightSource \"spot\" \"spectrum I\" [400 9 700 9] \
         AreaLightSource \"diffuse\" \"blackbody L\" 6500 \"float scale\" [ 3 ] Shape \"disk\"",
    );
    let lights: Vec<_> = scene.description.lights.iter().map(|light| light.value.clone()).collect();
    let LightDescription::Point(PointLightDescription { strength, .. }) = lights[0] else { panic!() };
    assert_eq!(strength, PointLightStrength::Intensity(DVec3::new(2.0, 4.0, 6.0)));
    // pbrt-v4 scales the spectrum of a light to luminance 1, whatever its values.
    let LightDescription::Spot(SpotLightDescription { strength: PointLightStrength::Intensity(intensity), .. }) =
        lights[1]
    else {
        panic!()
    };
    let luminance = |c: DVec3| c.dot(DVec3::new(0.2126, 0.7152, 0.0722));
    assert!((luminance(intensity) - 1.0).abs() < 1e-9);
    let LightDescription::Environment(EnvironmentRadiance::Constant(sky)) = lights[2] else { panic!() };
    assert_eq!(sky, DVec3::splat(0.75));
    let GroupItem::Object(object) = &scene.description.root.items[1] else { panic!() };
    let ObjectDescription::Transform { object, .. } = &object.value else { panic!() };
    let ObjectDescription::Shape { emission: Some(radiance), shape } = &object.value else { panic!() };
    assert!((luminance(*radiance) - 3.0).abs() < 1e-9 && (radiance - 3.0).abs().max_element() < 0.2);
    assert!(matches!(shape, ShapeDescription::Disc(_)));
}

#[test]
fn materials_of_both_versions_are_read() {
    let diffuse = sphere_material("Material \"diffuse\" \"rgb reflectance\" [.1 .2 .3]");
    assert_eq!(
        diffuse,
        MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: DVec3::new(0.1, 0.2, 0.3).into() })
    );
    assert_eq!(sphere_material("Material \"matte\" \"color Kd\" [.1 .2 .3]"), diffuse);
    let MaterialKindDescription::Conductor(ConductorDescription { metal, roughness, .. }) = sphere_material(
        "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \"float roughness\" .09",
    ) else {
        panic!()
    };
    let MetalDescription::Index { eta, k } = metal else { panic!() };
    let (gold_eta, gold_k) = crate::bsdf::metal_refractive_index("gold").unwrap();
    assert_eq!((eta, k), (gold_eta.as_dvec3(), gold_k.as_dvec3()));
    let reflectance = |material: &str| match sphere_material(material) {
        MaterialKindDescription::Conductor(ConductorDescription {
            metal: MetalDescription::Reflectance(reflectance),
            ..
        }) => reflectance,
        other => panic!("{other:?}"),
    };
    assert_eq!(reflectance("Material \"conductor\" \"rgb reflectance\" [.9 .5 1]"), DVec3::new(0.9, 0.5, 1.0).into());
    let checks = "Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [.2 .2 .2] \"rgb tex2\" [.7 .7 .7]";
    let textured = reflectance(&format!("{checks} Material \"conductor\" \"texture reflectance\" \"t\""));
    assert!(textured.texture_name().is_some(), "{textured:?}");
    // α is the square root of the roughness.
    let TexturedValue::Constant(alpha) = roughness else { panic!() };
    assert!((alpha - 0.3).abs() < 1e-12);
    let MaterialKindDescription::Dielectric(DielectricDescription { roughness, .. }) =
        sphere_material("Material \"dielectric\" \"float roughness\" .09 \"bool remaproughness\" false")
    else {
        panic!()
    };
    assert_eq!(roughness, TexturedValue::Constant(0.09));
    assert!(
        try_import_text("WorldBegin Material \"measured\" Shape \"sphere\"")
            .unwrap_err()
            .to_string()
            .contains("measured")
    );
}

#[test]
fn diffuse_transmission_has_reflectance_and_transmittance() {
    let sheet = |reflectance: DVec3, transmittance: DVec3| {
        MaterialKindDescription::DiffuseTransmission(DiffuseTransmissionDescription {
            reflectance: reflectance.into(),
            transmittance: transmittance.into(),
        })
    };
    let found = sphere_material(
        "Material \"diffusetransmission\" \"rgb reflectance\" [.2 .4 .5]
         \"rgb transmittance\" [.8 .6 .4] \"float scale\" .5",
    );
    assert_eq!(found, sheet(DVec3::new(0.1, 0.2, 0.25), DVec3::new(0.4, 0.3, 0.2)));
    assert_eq!(sphere_material("Material \"diffusetransmission\""), sheet(DVec3::splat(0.25), DVec3::splat(0.25)));
    let found = sphere_material(
        "Material \"translucent\" \"rgb Kd\" [.4 .8 1] \"rgb reflect\" [.25 .25 .25]
         \"rgb transmit\" [.5 .25 .75]",
    );
    assert_eq!(found, sheet(DVec3::new(0.1, 0.2, 0.25), DVec3::new(0.2, 0.2, 0.75)));
    assert!(note_messages(&import_text("WorldBegin Material \"translucent\" Shape \"sphere\"")).contains("Ks"));
}

#[test]
fn disney_materials_are_principled() {
    let found = sphere_material(
        "Material \"disney\" \"rgb color\" [.1 .2 .3] \"float metallic\" .25 \"float roughness\" .5
         \"float eta\" 1.4 \"float clearcoat\" .8 \"float clearcoatgloss\" 0",
    );
    let MaterialKindDescription::Principled(principled) = found else { panic!() };
    assert_eq!(principled.base_color, DVec3::new(0.1, 0.2, 0.3).into());
    assert_eq!([principled.metallic, principled.roughness], [0.25, 0.25].map(TexturedValue::Constant));
    assert_eq!([principled.transmission, principled.clearcoat], [0.0, 0.2].map(TexturedValue::Constant));
    assert_eq!([principled.eta, principled.clearcoat_roughness], [1.4, 0.1]);
    let sheen = import_text("WorldBegin Material \"disney\" \"float sheen\" 1 Shape \"sphere\"");
    assert!(note_messages(&sheen).contains("`sheen`"));
}

#[test]
fn textures_become_constants_or_textures() {
    let scaled = sphere_material(
        "Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [.2 .4 .8] \
         Texture \"b\" \"spectrum\" \"scale\" \"texture tex\" \"a\" \"float scale\" .5 \
         Material \"diffuse\" \"texture reflectance\" \"b\"",
    );
    assert_eq!(
        scaled,
        MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: DVec3::new(0.1, 0.2, 0.4).into() })
    );
    let checker = "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [1 0 0] \"float uscale\" 4 \
         Material \"diffuse\" \"texture reflectance\" \"c\"";
    let MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: TexturedValue::Texture(_) }) =
        sphere_material(checker)
    else {
        panic!()
    };
}

/// A texture may have a factor above 1. Only the product is clamped to \[0, 1].
#[test]
fn texture_factors_may_be_above_one() {
    let kind = sphere_material(
        "Texture \"dim\" \"spectrum\" \"constant\" \"rgb value\" [.25 .5 .1] \
         Texture \"lit\" \"spectrum\" \"scale\" \"texture tex\" \"dim\" \"rgb scale\" [2 2 2] \
         Material \"diffuse\" \"texture reflectance\" \"lit\"",
    );
    let MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }) = kind else { panic!("{kind:?}") };
    assert_eq!(reflectance, TexturedValue::Constant(DVec3::new(0.5, 1.0, 0.2)));
}

/// Materials that use only the mean roughness also get the geometric mean of both directions.
#[test]
fn anisotropic_roughness_becomes_the_geometric_mean() {
    let kind = sphere_material(
        "Material \"coateddiffuse\" \"float uroughness\" .04 \"float vroughness\" .16 \
         \"bool remaproughness\" false",
    );
    let MaterialKindDescription::CoatedDiffuse(coated) = kind else { panic!("{kind:?}") };
    let TexturedValue::Constant(roughness) = coated.roughness else { panic!("{coated:?}") };
    assert!((roughness - 0.08).abs() < 1e-12, "{roughness}");
}

#[test]
fn blocks_restore_the_state_and_instances_copy_objects() {
    let scene = import_text(
        "WorldBegin ObjectBegin \"o\" Shape \"sphere\" Shape \"disk\" ObjectEnd \
         AttributeBegin Translate 1 0 0 ObjectInstance \"o\" AttributeEnd ObjectInstance \"o\"",
    );
    assert_eq!(scene.description.root.items.len(), 2);
    let text = scene.description.to_string();
    assert_eq!(text.matches("Sphere").count(), 2, "{text}");
    assert!(note_messages(&scene).contains("no light"));
    assert!(try_import_text("WorldBegin AttributeEnd").is_err());
    assert!(try_import_text("WorldBegin ObjectInstance \"missing\"").is_err());
}

#[test]
fn motion_between_active_transforms_is_kept() {
    let scene = import_text(
        "WorldBegin ActiveTransform EndTime Translate 0 2 0 Rotate 90 0 0 1 ActiveTransform All Shape \"sphere\"",
    );
    let text = scene.description.to_string();
    assert!(text.contains("Moving") && note_messages(&scene).contains("no light"), "{text}");
}

#[test]
fn moving_cameras_turn_about_themselves() {
    let scene = import_text(
        "ActiveTransform EndTime Rotate -30 0 1 0 Translate 0 0 2 ActiveTransform All LookAt 1 0 0 1 0 5 0 1 0 \
         Camera \"perspective\" WorldBegin",
    );
    let camera = &scene.description.camera;
    assert!(camera.center.abs_diff_eq(DVec3::X, 1e-12));
    // The file moves the world relative to the camera, and the importer mirrors it along z.
    let at_end = TransformStep::composed_matrix(&camera.motion);
    let about = DAffine3::from_translation(camera.center);
    let moved = about * at_end * about.inverse();
    let file = DAffine3::from_rotation_y(-30_f64.to_radians()) * DAffine3::from_translation(2.0 * DVec3::Z);
    let look_at = DAffine3::from_translation(DVec3::NEG_X);
    let mirror = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let expected = mirror * (file * look_at).inverse() * look_at * mirror;
    assert!(moved.abs_diff_eq(expected, 1e-12), "{moved} {expected}");
}

#[test]
fn centered_crops_narrow_the_view() {
    let view = |film: &str| {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 {film} Camera \"perspective\" WorldBegin"
        );
        let scene = import_text(&text);
        let camera = &scene.description.camera;
        let ProjectionDescription::Perspective { vertical_fov_degrees: angle, .. } = camera.projection else {
            panic!()
        };
        ((camera.width, camera.height), libm::tan((0.5 * angle).to_radians()), note_messages(&scene))
    };
    let (whole, tangent, _) = view("");
    assert_eq!((whole, (tangent - 1.0).abs() < 1e-9), ((200, 100), true));
    for crop in ["\"float cropwindow\" [.25 .75 .2 .8]", "\"integer pixelbounds\" [50 150 20 80]"] {
        let (size, tangent, notes) = view(crop);
        assert!(size == (100, 60) && (tangent - 0.6).abs() < 1e-9, "{size:?} {tangent}");
        assert!(!notes.contains("crop"));
    }
    let (size, _, notes) = view("\"float cropwindow\" [0 .5 0 1]");
    assert!(size == (200, 100) && notes.contains("crop windows off the center"));
}

#[test]
fn settings_of_the_file_become_flags() {
    let scene = import_text(
        "Integrator \"sppm\" \"integer maxdepth\" 7 \"float radius\" .05 PixelFilter \"triangle\" \
         Sampler \"halton\" \"integer pixelsamples\" 16 WorldBegin",
    );
    let flags = "--integrator sppm --max-bounces 6 --radius 0.05 --filter tent --spp 16";
    assert!(note_messages(&scene).contains(flags), "{}", note_messages(&scene));
    let scene = import_text("Integrator \"path\" Integrator \"unknown\" WorldBegin");
    assert!(!note_messages(&scene).contains("settings"));
}

#[test]
fn parts_of_quadrics_become_meshes() {
    let scene = import_text(
        "WorldBegin Shape \"sphere\" \"float phimax\" 90 Shape \"disk\" \"float innerradius\" .5 \
         Shape \"cone\" Shape \"sphere\" \"float zmin\" -1 Shape \"cylinder\"",
    );
    assert_eq!(scene.assets.meshes.len(), 3);
    assert!(note_messages(&scene).contains("parts of spheres"), "{}", note_messages(&scene));
}

#[test]
fn sheets_between_media_are_noted() {
    let media = "WorldBegin MakeNamedMedium \"fog\" MediumInterface \"\" \"fog\"";
    let sheet = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
    let notes =
        |text: &str| note_messages(&import_text(&format!("{media} {text}"))).contains("sheets do not separate media");
    assert!(notes(sheet) && notes("Shape \"disk\"") && !notes("Shape \"sphere\""));
    assert!(!notes(&format!("MediumInterface \"fog\" \"fog\" {sheet}")));
    assert!(!notes(&format!("Material \"interface\" MediumInterface \"fog\" \"\" {sheet}")));
}

#[test]
fn pictures_in_tga_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    // The picture is uncompressed. It has 2 × 1 pixels of 24 bits as blue, green, red; the top row
    // is first.
    let mut file = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 24, 0x20];
    file.extend([255, 0, 0, 0, 0, 255]);
    std::fs::write(folder.path().join("a.TGA"), &file).unwrap();
    let text = "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.TGA\" \
         Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"";
    let read = || decode(&folder.path().join("a.pbrt"), text.as_bytes(), &ImportOptions::default());
    let picture = read().unwrap().assets.pictures.into_values().next().unwrap();
    assert_eq!(picture.pixels(), [Vec3::Z, Vec3::X]);
    std::fs::write(folder.path().join("a.TGA"), &file[..20]).unwrap();
    assert!(read().unwrap_err().to_string().contains("line 1"));
}

/// Each malformed text gives an error with its line and a help text, without a panic.
#[test]
fn malformed_files_are_refused_with_their_line() {
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
        "Shape \"sphere\" \"float zmin\" .5 \"float zmax\" .5",
        "Shape \"paraboloid\" \"float zmin\" -1",
        "Shape \"hyperboloid\" \"point3 p1\" [1 1 1]",
        "Shape \"cone\" \"float radius\" 0",
        "LightSource \"projection\"",
        "LightSource \"projection\" \"float fov\" 0 \"string filename\" \"a.png\"",
        "LightSource \"goniometric\" \"string filename\" \"missing.exr\"",
        "MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"m.nvdb\"",
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\"",
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [1]",
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 1.5 \"float density\" [1]",
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"float density\" [-1]",
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"float density\" [1] \"point3 p1\" [1 0 1]",
        "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\"",
        "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" \"rgb sigma_a\" [1 1]",
    ];
    for defect in defects {
        let error = try_import_text(&format!("\n{defect}")).err().unwrap_or_else(|| panic!("{defect} is accepted"));
        assert!(error.to_string().contains("line 2") || defect.starts_with("Obj"), "{defect}: {error}");
    }
}

#[test]
fn too_deep_and_too_large_scenes_are_refused() {
    let deep = "AttributeBegin ".repeat(20_000);
    assert!(try_import_text(&deep).unwrap_err().to_string().contains("too deep"));
    // Nested objects that stand for 2⁴⁰ spheres.
    let mut text = "WorldBegin ObjectBegin \"0\" Shape \"sphere\" ObjectEnd ".to_owned();
    for i in 0..40 {
        let next = i + 1;
        text += &format!("ObjectBegin \"{next}\" ObjectInstance \"{i}\" ObjectInstance \"{i}\" ObjectEnd ");
    }
    assert!(matches!(try_import_text(&text), Err(SceneReadError::OutOfMemory { .. })));
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
