//! Tests of the conversion of transforms, primitives and media.

use super::{assert_import_error, has_note, import_in_folder, import_scene, is_near, placed_objects};
use crate::format::description::{
    BoxDescription, DiscDescription, MaterialKindDescription, MediumCoefficients, ObjectDescription,
    PhaseFunctionDescription, RectangleDescription, ShapeDescription,
};
use crate::format::import::{ImportOptions, ImportedScene};
use crate::format::tungsten::transforms::rotation_yxz;
use crate::format::tungsten::wo3::tests::triangle_file;
use crate::stats::MemoryLimit;
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;
use std::path::Path;

/// Returns the transform and the shape of the only object of a scene with the primitive `members`.
fn only_object(members: &str) -> (DAffine3, ShapeDescription, Option<DVec3>) {
    let objects = placed_objects(&import_scene(&format!("{{{members}}}"), ""));
    let [(transform, ObjectDescription::Shape { shape, emission })] = &objects[..] else { panic!("{objects:?}") };
    (*transform, shape.clone(), *emission)
}

/// Returns the transform of a cube with the member `transform`.
fn cube_transform(transform: &str) -> DAffine3 {
    only_object(&format!("\"type\": \"cube\", \"transform\": {transform}")).0
}

#[test]
fn rotations_apply_about_z_first_and_left_handed_about_y() {
    let turned = |angles: [f64; 3], vector: DVec3| rotation_yxz(DVec3::from(angles)) * vector;
    assert!(is_near(turned([90.0, 0.0, 0.0], DVec3::Y), DVec3::Z));
    assert!(is_near(turned([0.0, 90.0, 0.0], DVec3::Z), DVec3::NEG_X));
    assert!(is_near(turned([0.0, 0.0, 90.0], DVec3::X), DVec3::Y));
    assert!(is_near(turned([0.0, 90.0, -90.0], DVec3::Y), DVec3::Z));
    assert!(is_near(turned([90.0, 90.0, 90.0], DVec3::X), DVec3::NEG_X));
}

#[test]
fn transforms_have_all_forms_of_the_file() {
    let parts = cube_transform(r#"{"position": [1, 2, 3], "scale": [2, 4, 6], "rotation": [0, 0, 90]}"#);
    assert!(is_near(parts.transform_point3(DVec3::new(0.5, 0.5, 0.5)), DVec3::new(-1.0, 3.0, 6.0)));
    let rows = cube_transform("[2, 0, 0, 5, 0, 2, 0, 6, 0, 0, 2, 7, 0, 0, 0, 1]");
    assert!(is_near(rows.transform_point3(DVec3::ONE), DVec3::new(7.0, 8.0, 9.0)));
    let looking = cube_transform(r#"{"position": [0, 0, 1], "look_at": [5, 0, 1], "up": [1, 1, 0]}"#);
    assert!(is_near(looking.matrix3.z_axis, DVec3::X) && is_near(looking.matrix3.y_axis, DVec3::Y));
    let axes = cube_transform(r#"{"x_axis": [0, 0, -3], "y_axis": [0, 5, 0]}"#);
    assert!(is_near(axes.matrix3.x_axis, DVec3::NEG_Z) && is_near(axes.matrix3.z_axis, DVec3::X));
    let determinant = |transform: DAffine3| transform.matrix3.determinant();
    assert!((determinant(looking) - 1.0).abs() < 1e-12 && (determinant(axes) - 1.0).abs() < 1e-12);
    assert_import_error(r#"{"type": "cube", "transform": {"look_at": [0, 0, 0]}}"#, "", "axis of the transform");
    assert_import_error(r#"{"type": "cube", "transform": {"scale": "big"}}"#, "", "`scale` is not a number or a list");
}

#[test]
fn quads_cubes_disks_and_spheres_have_tungstens_size() {
    let (_, quad, emission) = only_object(r#""type": "quad", "emission": [1, 2, 3]"#);
    let ShapeDescription::Rectangle(RectangleDescription { corner, edge0, edge1 }) = quad else { panic!() };
    assert_eq!((corner, corner + edge0 + edge1), (DVec3::new(-0.5, 0.0, 0.5), DVec3::new(0.5, 0.0, -0.5)));
    assert_eq!((edge0.cross(edge1), emission), (DVec3::Y, Some(DVec3::new(1.0, 2.0, 3.0))));
    let (_, cube, _) = only_object(r#""type": "cube""#);
    assert_eq!(cube, ShapeDescription::Box(BoxDescription { min: DVec3::splat(-0.5), max: DVec3::splat(0.5) }));
    let (placed, disk, _) = only_object(r#""type": "disk", "transform": {"scale": [2, 7, 3]}"#);
    let unit_disk = DiscDescription { center: DVec3::ZERO, normal: DVec3::Y, radius: 1.0 };
    assert_eq!(disk, ShapeDescription::Disc(unit_disk));
    assert_eq!(placed.matrix3.x_axis.length(), 3.0);
    let (placed, _, _) = only_object(r#""type": "sphere", "transform": {"scale": [1, 2, 5], "rotation": [3, 4, 5]}"#);
    let lengths = [placed.matrix3.x_axis, placed.matrix3.y_axis, placed.matrix3.z_axis].map(|axis| axis.length());
    assert!(lengths.iter().all(|length| (length - 5.0).abs() < 1e-12), "{lengths:?}");
}

#[test]
fn power_is_spread_over_the_area() {
    let radiance = |members: &str| only_object(&format!("{members}, \"power\": 12")).2.unwrap().x * PI;
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12 * expected, "{found}");
    close(radiance(r#""type": "quad", "transform": {"scale": [2, 9, 3]}"#), 12.0 / 6.0);
    close(radiance(r#""type": "cube", "transform": {"scale": [1, 2, 3]}"#), 12.0 / 22.0);
    close(radiance(r#""type": "sphere", "transform": {"scale": 2}"#), 12.0 / (16.0 * PI));
    close(radiance(r#""type": "disk", "transform": {"scale": 2}"#), 12.0 / (4.0 * PI));
    close(radiance(r#""type": "cylinder", "transform": {"scale": [2, 3, 2]}"#), 12.0 / (2.0 * PI + 6.0 * PI));
    // `power` counts, and not `emission`.
    close(radiance(r#""type": "quad", "emission": 5"#), 12.0);
}

#[test]
fn meshes_are_divided_among_their_bsdfs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.wo3"), triangle_file([3, 1], [0, 1, 2, 7])).unwrap();
    let mesh = r#"{"type": "mesh", "file": "a.wo3", "smooth": true, "power": 1,
        "transform": {"scale": 2}, "bsdf": [{"type": "mirror"}, {"type": "lambert"}]}"#;
    let scene = import_in_folder(folder.path(), mesh, "");
    // The index 7 counts as the last BSDF.
    assert!(matches!(scene.description.materials[0].kind, MaterialKindDescription::Diffuse(_)));
    let [(_, ObjectDescription::Shape { emission, .. })] = &placed_objects(&scene)[..] else { panic!() };
    assert!((emission.unwrap().x - 1.0 / (2.0 * PI)).abs() < 1e-15);
    let embedded = scene.assets.meshes.values().next().unwrap();
    assert_eq!(embedded.normals.as_deref(), Some(&[DVec3::Z; 3][..]));
    assert_import_error(r#"{"type": "mesh", "file": "a.wo3", "bsdf": []}"#, "", "the list `bsdf` is empty");
    std::fs::write(folder.path().join("b.wo3"), [3_u8; 20]).unwrap();
    let text = super::scene_json(r#"{"type": "mesh", "file": "b.wo3"}"#, "");
    let options = ImportOptions::default();
    let error = super::decode(&folder.path().join("a.json"), text.as_bytes(), &options).unwrap_err().to_string();
    assert!(error.contains("primitives[0]: `b.wo3`: the file is too short"), "{error}");
}

#[test]
fn instances_are_placed_without_scale() {
    let scene = import_scene(
        r#"{"type": "instances", "transform": {"position": [0, 0, 9]}, "masters": [{"type": "cube",
        "transform": {"scale": 2}}], "instances": [{"id": 0, "transform": {"position": [1, 0, 0], "scale": 5}}, {}]}"#,
        "",
    );
    let places: Vec<DVec3> = placed_objects(&scene).iter().map(|(place, _)| place.transform_point3(DVec3::X)).collect();
    assert_eq!(places, [DVec3::new(3.0, 0.0, 9.0), DVec3::new(2.0, 0.0, 9.0)]);
    assert_import_error(r#"{"type": "instances", "instances": [{"id": 1}]}"#, "", "`masters` has no entry 1");
    // Without a limit, these instances of nothing would take years.
    let nested = (0..8).fold(r#"{"type": "curves"}"#.to_owned(), |inner, _| {
        let many = vec!["{}"; 1000].join(", ");
        format!("{{\"type\": \"instances\", \"masters\": [{inner}], \"instances\": [{many}]}}")
    });
    let memory_limit = MemoryLimit::ProcessBytes(1 << 28);
    let options = ImportOptions { memory_limit, ..ImportOptions::default() };
    let text = super::scene_json(&nested, "");
    let error = super::decode(Path::new("/nowhere/a.json"), text.as_bytes(), &options).unwrap_err();
    assert!(error.to_string().contains("of memory"), "{error}");
    let in_file = import_scene(r#"{"type": "instances", "instances": "a.bin"}"#, "");
    assert!(has_note(&in_file, "instances in files are left out"));
}

#[test]
fn unsupported_primitives_are_left_out() {
    for kind in ["curves", "minecraft_map", "teapot"] {
        let scene = import_scene(&format!("{{\"type\": \"{kind}\", \"file\": \"x\"}}"), "");
        assert!(has_note(&scene, &format!("primitives of kind `{kind}` are left out (1×: primitives[0])")));
        assert!(scene.notes.iter().any(|note| note.concerns_unsupported_content));
        assert!(placed_objects(&scene).is_empty());
    }
    let flat = import_scene(
        r#"{"type": "sphere", "transform": {"scale": 0}}, {"type": "quad", "transform": {"scale": 0}}"#,
        "",
    );
    assert!(placed_objects(&flat).is_empty() && has_note(&flat, "scaled to nothing"));
}

const GAS: &str = r#""media": [{"name": "gas", "type": "homogeneous", "sigma_a": 0.5, "sigma_s": [1, 2, 3],
    "density": 2, "phase_function": {"type": "henyey_greenstein", "g": 0.25}}]"#;

fn import_with_gas(primitives: &str) -> ImportedScene {
    import_scene(primitives, GAS)
}

#[test]
fn media_fill_forward_bodies_and_dielectrics() {
    let body =
        |kind: &str| format!("{{\"type\": \"sphere\", \"int_medium\": \"gas\", \"bsdf\": {{\"type\": \"{kind}\"}}}}");
    for kind in ["forward", "dielectric"] {
        let scene = import_with_gas(&body(kind));
        let medium = &scene.description.media[0].value;
        let (absorption, scattering) = (DVec3::ONE, DVec3::new(2.0, 4.0, 6.0));
        assert_eq!(medium.coefficients, MediumCoefficients::AbsorptionScattering { absorption, scattering });
        assert_eq!(medium.phase, PhaseFunctionDescription::HenyeyGreenstein(0.25));
        assert_eq!(scene.description.materials[0].medium.as_ref().unwrap().value, medium.name);
    }
    assert!(has_note(&import_with_gas(&body("lambert")), "media behind surfaces that are neither"));
    assert!(placed_objects(&import_with_gas(r#"{"type": "sphere", "bsdf": {"type": "forward"}}"#)).is_empty());
    let outside = import_with_gas(r#"{"type": "sphere", "ext_medium": "gas"}"#);
    assert!(has_note(&outside, "media that are only stated as `ext_medium` are left out"));
    let voxels = import_scene(&body("forward"), r#""media": [{"name": "gas", "type": "voxel"}]"#);
    assert!(has_note(&voxels, "media of kind `voxel` are left out"));
    assert_import_error(&body("forward"), "", "no medium is called `gas`");
}

#[test]
fn a_medium_behind_a_flat_surface_fills_the_scene_behind_it() {
    let scene = import_with_gas(
        r#"{"type": "cube", "transform": {"scale": 4}},
        {"type": "quad", "int_medium": "gas", "bsdf": {"type": "forward"},
        "transform": {"position": [0, 1, 0], "scale": 4}}"#,
    );
    assert!(has_note(&scene, "a medium behind flat surfaces fills the bounds"));
    let [_, (_, ObjectDescription::Shape { shape: ShapeDescription::Mesh(region), .. })] = &placed_objects(&scene)[..]
    else {
        panic!()
    };
    let mesh = &scene.assets.meshes[&region.path.value];
    let top = mesh.positions.iter().fold(DVec3::NEG_INFINITY, |top, p| top.max(*p));
    assert!(top.y == 1.0 && top.x > 1.99 && top.x < 2.0 && mesh.solid_defect().is_none(), "{top}");
}
