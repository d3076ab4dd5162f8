//! Tests of resolved media: coefficients, density grids, bodies and the ambient medium.

use super::{CAMERA, resolve_error, resolve_in_folder, resolve_scene_text};
use crate::format::grid::{self, DensityGridData, GridEncoding};
use crate::format::{SourceText, parse, resolve};
use crate::medium::{Medium, PhaseFunction};
use crate::scene::{Body, Material, Scene};
use glam::{DVec3, Vec3, dvec3, vec3};
use std::path::Path;

const BALL: &str = "Group { MaterialIndex 0 Sphere { center 7 0 0 radius 1 } }";

/// Returns the text of a scene with these media and materials.
///
/// The only object is a ball of the first material, whose center is not the origin.
fn scene_text_with_media(media: &str, materials: &str) -> String {
    format!("Media {{ {media} }}\nMaterials {{ {materials} }} {BALL}")
}

fn body_of_material(scene: &Scene, material: usize) -> Body {
    *scene.materials()[material].enclosed_body().unwrap()
}

/// Returns the medium inside bodies of the first material.
fn medium_of_first_material(scene: &Scene) -> &Medium {
    &scene.media()[body_of_material(scene, 0).medium.unwrap() as usize]
}

fn density_of_first_material(scene: &Scene, p: DVec3) -> f32 {
    medium_of_first_material(scene).density_at((p - scene.origin()).as_vec3())
}

#[test]
fn coefficients_and_phase_functions_are_resolved() {
    let of = |fields: &str| {
        resolve_scene_text(&scene_text_with_media(&format!("Medium a {{ {fields} }}"), "Clear { medium a }"))
    };
    let found = of("absorption 1 2 3 scattering 4 5 6 emission 7 8 9");
    let medium = medium_of_first_material(&found);
    assert_eq!((medium.absorption, medium.scattering), (vec3(1.0, 2.0, 3.0), vec3(4.0, 5.0, 6.0)));
    assert_eq!((medium.emission, medium.phase), (vec3(7.0, 8.0, 9.0), PhaseFunction::Isotropic));
    assert!(medium.is_homogeneous());
    let found = of("extinction 8 8 8 albedo 1 .75 0 anisotropy -.25");
    let medium = medium_of_first_material(&found);
    assert_eq!((medium.absorption, medium.scattering), (vec3(0.0, 2.0, 8.0), vec3(8.0, 6.0, 0.0)));
    assert_eq!(medium.phase, PhaseFunction::HenyeyGreenstein(-0.25));
    assert_eq!(medium_of_first_material(&of("phase rayleigh")).phase, PhaseFunction::Rayleigh);
    // An anisotropy g that is nearly 1 must stay below 1 in single precision.
    for g in [".9999999", "-.9999999"] {
        assert!(medium_of_first_material(&of(&format!("anisotropy {g}"))).phase.mean_cosine().abs() < 1.0);
    }
    assert!(medium_of_first_material(&of("")).is_empty());
}

#[test]
fn media_fill_bodies_and_regions() {
    let media = "Medium a { absorption 1 1 1 } Medium b { scattering 1 1 1 }";
    let found = resolve_scene_text(&scene_text_with_media(
        media,
        "Dielectric { medium b priority 3 roughness .5 } Clear { medium a priority 7 } Clear { }",
    ));
    let glass = Body { medium: Some(1), priority: 3, ..Body::new(1.5) };
    assert_eq!(found.materials()[0], Material::rough_boundary(glass, 0.5));
    assert_eq!(body_of_material(&found, 1), Body { priority: 7, ..Body::null_interface_with_medium(0) });
    assert_eq!(body_of_material(&found, 2), Body { medium: None, ..Body::null_interface_with_medium(0) });
    assert_eq!(found.ambient_medium(), None);
    let found = resolve_scene_text(
        "Background { medium fog } Media { Medium no { } Medium fog { scattering 1 1 1 } } Group { }",
    );
    assert_eq!(found.ambient_medium(), Some(1));
}

#[test]
fn body_absorption_adds_to_a_homogeneous_medium() {
    let media = "Medium milk { scattering 9 9 9 absorption 1 2 3 anisotropy .5 }";
    let found = resolve_scene_text(&scene_text_with_media(
        media,
        "Dielectric { medium milk absorption .5 0 1 } Dielectric { medium milk absorption 0 0 0 }",
    ));
    let medium = medium_of_first_material(&found);
    assert_eq!((medium.absorption, medium.scattering), (vec3(1.5, 2.0, 4.0), Vec3::splat(9.0)));
    assert_eq!(
        (medium.phase, body_of_material(&found, 0).absorption),
        (PhaseFunction::HenyeyGreenstein(0.5), Vec3::ZERO)
    );
    let plain = &found.media()[body_of_material(&found, 1).medium.unwrap() as usize];
    assert_eq!(plain.absorption, vec3(1.0, 2.0, 3.0), "the medium itself stays as it is");

    let cloud = "Cloud c { scattering 1 1 1 resolution 4 min 0 0 0 max 1 1 1 }";
    let error = resolve_error(&scene_text_with_media(cloud, "Dielectric { tint .5 1 1 medium c }"));
    assert_eq!((error.line(), error.offending_text()), (3, "c"), "{error}");
    assert!(error.message().contains("absorbs") && error.remedy().contains("`tint`"), "{error}");
    resolve_scene_text(&scene_text_with_media(cloud, "Dielectric { medium c absorption 0 0 0 }"));
}

/// A grid of 2 × 1 × 1 cells gives densities inside its box, interpolated between cell centers.
#[test]
fn density_grids_fill_their_box() {
    let folder = tempfile::tempdir().unwrap();
    let values = DensityGridData { cell_counts: [2, 1, 1], densities: vec![1.0, 3.0] };
    grid::write(&folder.path().join("two.grid"), &values, GridEncoding::F32).unwrap();
    let of = |fields: &str| {
        let media = format!("Medium a {{ scattering 1 1 1 grid two.grid {fields} }}");
        resolve_in_folder(folder.path(), &scene_text_with_media(&media, "Clear { medium a }"))
    };
    let at = |scene: &Scene, x: f64, y: f64, z: f64| density_of_first_material(scene, dvec3(x, y, z));
    let found = of("min -4 0 0 max 4 1 1 densityScale 2").unwrap();
    assert!(!medium_of_first_material(&found).is_homogeneous());
    let row = [-4.5, -3.0, -2.0, 0.0, 2.0, 3.0, 4.5].map(|x| at(&found, x, 0.5, 0.5));
    assert_eq!(row, [0.0, 2.0, 2.0, 4.0, 6.0, 6.0, 0.0]);
    assert_eq!((at(&found, 0.0, 1.5, 0.5), at(&found, 0.0, 0.5, -0.5)), (0.0, 0.0));
    // A quarter turn about y takes x to −z. Then the grid moves.
    let turned = of("min -4 0 0 max 4 1 1 Transform { Translate 10 0 0 YRotate 90 }").unwrap();
    let is_nearly_equal = |a: f32, b: f32| assert!((a - b).abs() < 1e-5, "{a} {b}");
    is_nearly_equal(at(&turned, 10.5, 0.5, 2.0), 1.0);
    is_nearly_equal(at(&turned, 10.5, 0.5, -2.0), 3.0);
    is_nearly_equal(at(&turned, 9.5, 0.5, 2.0), 0.0);

    let error = of("min -4 0 0 max 4 1 1 densityScale 1e12").unwrap_err();
    assert_eq!((error.line(), error.offending_text()), (2, "two.grid"), "{error}");
    assert!(error.message().contains("as dense as") && error.remedy().contains("`densityScale`"), "{error}");
    let error = of("min 0 0 0 max 1 1 1e-320").unwrap_err();
    assert_eq!((error.line(), error.offending_text()), (2, "Medium"), "{error}");
    assert!(error.message().contains("cannot be placed") && error.remedy().contains("extent"), "{error}");
}

#[test]
fn unreadable_grids_are_reported_at_their_path() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.grid"), "caustica-grid 1\nsize 1 1 1\ntype text\n\n-1").unwrap();
    let of = |file: &str| {
        let media = format!("Medium a {{ grid {file} min 0 0 0 max 1 1 1 }}");
        resolve_in_folder(folder.path(), &scene_text_with_media(&media, "Clear { medium a }")).unwrap_err()
    };
    let missing = of("no.grid");
    assert_eq!((missing.line(), missing.offending_text()), (2, "no.grid"), "{missing}");
    assert!(
        missing.message().contains("the grid `no.grid` does not exist") && missing.remedy().contains("put the file")
    );
    let bad = of("bad.grid");
    assert_eq!((bad.line(), bad.offending_text()), (2, "bad.grid"), "{bad}");
    assert!(bad.message().contains("cell (0, 0, 0)") && bad.remedy().contains("repair the grid"), "{bad}");
}

#[test]
fn clouds_fill_the_inscribed_ellipsoid() {
    let of = |fields: &str| {
        let cloud = format!("Cloud c {{ scattering 1 1 1 min -2 -1 -1 max 2 1 1 resolution 32 {fields} }}");
        resolve_scene_text(&scene_text_with_media(&cloud, "Clear { medium c }"))
    };
    let mean = |scene: &Scene, size: f64| {
        let points =
            (0..1000).map(|i| dvec3(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)) / 4.5 - 1.0);
        points.map(|p| density_of_first_material(scene, p * dvec3(2.0, 1.0, 1.0) * size)).sum::<f32>() / 1000.0
    };
    let [full, thin, other] = ["cover 1 softness 0", "cover .3 softness 0", "cover 1 softness 0 seed 1"].map(of);
    assert!(mean(&full, 0.5) > 0.2 && mean(&thin, 0.5) < mean(&full, 0.5));
    assert_ne!(mean(&full, 0.5), mean(&other, 0.5));
    // A corner of the box is outside the ellipsoid, as are all points outside the box.
    assert_eq!(
        [
            density_of_first_material(&full, dvec3(1.7, 0.8, 0.8)),
            density_of_first_material(&full, dvec3(0.0, 1.1, 0.0))
        ],
        [0.0; 2]
    );
    assert!(of("cover 0").media()[0].is_empty());
}

#[test]
fn invalid_ambient_media_are_refused() {
    let of = |media: &str, lights: &str| {
        format!("Background {{ medium a }} Media {{ {media} }}\nLights {{ {lights} }} Group {{ }}")
    };
    let cloud = resolve_error(&of("Cloud a { scattering 1 1 1 resolution 4 min 0 0 0 max 1 1 1 }", ""));
    assert_eq!((cloud.line(), cloud.offending_text()), (2, "a"), "{cloud}");
    assert!(cloud.message().contains("not the same everywhere") && cloud.remedy().contains("`Clear {"), "{cloud}");
    let bright = resolve_error(&of("Medium a { absorption 1 0 1 emission 1 1 1 }", ""));
    assert_eq!((bright.line(), bright.offending_text()), (2, "a"), "{bright}");
    assert!(bright.message().contains("infinitely bright") && bright.remedy().contains("absorb"), "{bright}");
    resolve_scene_text(&of("Medium a { absorption 1 0 1 emission 1 0 1 }", ""));

    let sun = "DirectionalLight { direction 0 -1 0 irradiance 1 1 1 }";
    let (sky, lamp) = ("EnvironmentLight { radiance 1 1 1 }", "PointLight { position 0 5 0 power 1 1 1 }");
    for (fog, light) in [("absorption 1 0 0", sun), ("scattering 0 0 1", sky)] {
        let error = resolve_error(&of(&format!("Medium a {{ {fog} }}"), &format!("{lamp} {light}")));
        assert_eq!((error.line(), error.offending_text()), (3, light.split(' ').next().unwrap()), "{error}");
        assert!(error.message().contains("light from infinity") && error.remedy().contains("`Clear {"), "{error}");
        resolve_scene_text(&of("Medium a { }", light));
        resolve_scene_text(&of(&format!("Medium a {{ {fog} }}"), lamp));
    }
    let error = resolve_error(&of("Medium a { absorption 1 1 1 }", &format!("Moving {{ XRotate 9 {sun} }}")));
    assert_eq!((error.line(), error.offending_text()), (3, "DirectionalLight"), "{error}");
}

#[test]
fn clear_objects_cannot_emit() {
    let of = |emission: &str| {
        let ball = format!("Sphere {{ center 0 0 0 radius 1 emission {emission} }}");
        format!("Materials {{ Clear {{ }} Mirror {{ }} }}\nGroup {{ MaterialIndex 0 {ball} MaterialIndex 1 {ball} }}")
    };
    let error = resolve_error(&of("1 0 0"));
    assert_eq!((error.line(), error.column(), error.offending_text()), (3, 25, "Sphere"), "{error}");
    assert!(error.message().contains("no surface") && error.remedy().contains("`emission` to its medium"), "{error}");
    resolve_scene_text(&of("0 0 0"));
}

#[test]
fn unknown_medium_names_are_refused() {
    // The parser refuses unknown names of media. But a description may be changed after parsing.
    let text = format!("{CAMERA}{}", scene_text_with_media("Medium a { }", "Clear { medium a }"));
    let mut description = parse("a.txt", &text).unwrap();
    description.media.pop();
    let error = resolve(&description, &SourceText::new("a.txt", &text), Path::new("")).unwrap_err();
    assert_eq!((error.line(), error.offending_text()), (3, "a"));
    assert!(error.message().contains("no medium is called `a`") && error.remedy().contains("define it in Media"));
}
