//! Tests of resolved scenes by rays in the coordinates of the scene file.

mod materials;
mod media;
mod meshes;
mod oriented_lights;
mod shared_meshes;
mod textures;

use super::super::parse;
use super::*;
use crate::bsdf::Bsdf;
use crate::light::{DirectionalLight, Light, PointLight};
use crate::math::Ray;
use crate::scene::{Effects, Material, RayCone, SurfaceInteraction};
use glam::{Vec3, dvec3, vec3};
use std::f32::consts::PI;

const CAMERA: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 angle 30 }\n";

fn resolve_in_folder(folder: &Path, text: &str) -> Result<Scene, SceneError> {
    let text = format!("{CAMERA}{text}");
    resolve(&parse("a.txt", &text).unwrap(), &SourceText::new("a.txt", &text), folder)
}

fn resolve_scene_text(text: &str) -> Scene {
    resolve_in_folder(Path::new(""), text).unwrap()
}

fn resolve_error(text: &str) -> SceneError {
    resolve_in_folder(Path::new(""), text).unwrap_err()
}

/// Returns the first surface that a ray hits, and the hit point in file coordinates.
fn visible_surface(scene: &Scene, origin: DVec3, direction: Vec3) -> Option<(SurfaceInteraction<'_>, DVec3)> {
    let ray = Ray::new((origin - scene.origin()).as_vec3(), direction);
    let surface =
        scene.surface_interaction(&ray, &scene.intersect(&ray)?, &RayCone::zero_width_cone(Effects::ALL), || 0.0);
    Some((surface, surface.point.p.as_dvec3() + scene.origin()))
}

fn visible_reflectance(scene: &Scene, origin: DVec3, direction: Vec3) -> Vec3 {
    match visible_surface(scene, origin, direction).unwrap().0.bsdf {
        Bsdf::Diffuse(reflectance) => reflectance,
        other => panic!("{other:?}"),
    }
}

/// True if vectors with components up to 10 differ by a few roundings of single precision.
fn is_nearly_equal(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().max_element() < 1e-5
}

const MATERIAL_BLOCK_PARSERS: &str =
    "Materials { Diffuse a { reflectance .1 .1 .1 } Diffuse b { reflectance .2 .2 .2 } }\n";

#[test]
fn the_current_material_crosses_group_borders() {
    let ball = |x: i32| format!("Sphere {{ center {x} 0 0 radius .4 }}");
    let [zero, one, two, three, four] = [0, 1, 2, 3, 4].map(ball);
    let scene = resolve_scene_text(&format!(
        "{MATERIAL_BLOCK_PARSERS} Group {{ {zero} MaterialName b {one} Group {{ {two} MaterialIndex 0 {three} }} {four} }}"
    ));
    let seen = [0, 1, 2, 3, 4].map(|x| visible_reflectance(&scene, dvec3(f64::from(x), 0.0, 5.0), Vec3::NEG_Z).x);
    assert_eq!(seen, [0.1, 0.2, 0.2, 0.1, 0.1]);
}

#[test]
fn objects_before_any_material_use_the_first() {
    let ball = "Group { Sphere { center 0 0 0 radius 1 } }";
    let at = |text: &str| visible_reflectance(&resolve_scene_text(text), dvec3(0.0, 0.0, 5.0), Vec3::NEG_Z);
    assert_eq!(at(ball), Vec3::ONE);
    assert_eq!(at(&format!("{MATERIAL_BLOCK_PARSERS}{ball}")), Vec3::splat(0.1));
}

#[test]
fn unknown_material_names_are_refused() {
    // The parser refuses unknown names of materials. But a description may be changed after
    // parsing.
    let text = format!("{CAMERA}{MATERIAL_BLOCK_PARSERS}Group {{ MaterialName b }}");
    let mut description = parse("a.txt", &text).unwrap();
    description.materials.pop();
    let error = resolve(&description, &SourceText::new("a.txt", &text), Path::new("")).unwrap_err();
    assert_eq!((error.line(), error.offending_text()), (3, "b"));
    assert!(error.message().contains("no material named `b`") && !error.remedy().is_empty());
}

#[test]
fn outer_transforms_are_applied_last() {
    // A unit ball: doubled, moved to x = 3, turned to y = 3, moved up by 1.
    let ball = "Sphere { center 0 0 0 radius 1 }";
    let inner = format!("Transform {{ Translate 3 0 0 UniformScale 2 {ball} }}");
    let scene =
        resolve_scene_text(&format!("Group {{ Transform {{ Translate 0 1 0 ZRotate 90 Group {{ {inner} }} }} }}"));
    let (_, p) = visible_surface(&scene, dvec3(0.0, 4.0, 9.0), Vec3::NEG_Z).unwrap();
    assert!((p - dvec3(0.0, 4.0, 2.0)).length() < 1e-5, "{p}");
    assert!(visible_surface(&scene, dvec3(3.0, 1.0, 9.0), Vec3::NEG_Z).is_none());
}

#[test]
fn mirroring_preserves_the_outer_side() {
    for shape in [
        "Rectangle { corner -1 -1 0 edge0 2 0 0 edge1 0 2 0 emission 1 1 1 }",
        "Disc { center 0 0 0 normal 0 0 1 radius 1 emission 1 1 1 }",
        "Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 emission 1 1 1 }",
        "Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 normal0 .1 0 1 normal1 .1 0 1 normal2 .1 0 1 emission 1 1 1 }",
        "Sphere { center 0 0 0 radius 1 emission 1 1 1 }",
    ] {
        for scale in ["1 1 1", "-1 1 1", "1 -1 1", "-2 1 1", "-1 -3 1"] {
            let scene = resolve_scene_text(&format!("Group {{ Transform {{ Scale {scale} {shape} }} }}"));
            let (surface, _) = visible_surface(&scene, dvec3(0.1, 0.1, 5.0), Vec3::NEG_Z).unwrap();
            assert_eq!(surface.emission, Vec3::ONE, "{scale} {shape}");
            assert!(surface.point.ng.z > 0.0 && surface.point.ns.dot(surface.point.ng) > 0.0, "{scale} {shape}");
        }
        // A flat shape that is mirrored along its normal emits on its other side.
        let scene = resolve_scene_text(&format!("Group {{ Transform {{ Scale 1 1 -1 {shape} }} }}"));
        let from_front = visible_surface(&scene, dvec3(0.1, 0.1, 5.0), Vec3::NEG_Z).unwrap().0.emission;
        let from_behind = visible_surface(&scene, dvec3(0.1, 0.1, -5.0), Vec3::Z).unwrap().0.emission;
        let flat = !shape.starts_with("Sphere");
        assert_eq!((from_front == Vec3::ONE, from_behind), (!flat, Vec3::ONE), "{shape}");
    }
}

#[test]
fn shading_normals_use_the_inverse_transpose() {
    let normals = "normal0 1 0 1 normal1 1 0 1 normal2 1 0 1";
    let triangle = format!("Triangle {{ vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 {normals} }}");
    let scene = resolve_scene_text(&format!("Group {{ Transform {{ Scale 2 1 1 {triangle} }} }}"));
    let (surface, _) = visible_surface(&scene, dvec3(0.1, 0.1, 5.0), Vec3::NEG_Z).unwrap();
    assert!(is_nearly_equal(surface.point.ns, vec3(0.5, 0.0, 1.0).normalize()), "{}", surface.point.ns);
}

#[test]
fn planes_move_with_their_transform() {
    // The plane has normal length 2 and offset 2, so it lies at y = 1. It is doubled to y = 2, and
    // then moved by −5 to y = −3.
    let scene =
        resolve_scene_text("Group { Transform { Translate 0 -5 0 UniformScale 2 Plane { normal 0 2 0 offset 2 } } }");
    let (surface, p) = visible_surface(&scene, dvec3(0.0, 3.0, 0.0), Vec3::NEG_Y).unwrap();
    assert!((p.y + 3.0).abs() < 1e-5 && surface.point.ng.y > 0.99, "{p}");
}

#[test]
fn singular_products_are_reported_at_the_inner_transform() {
    let ball = "Sphere { center 0 0 0 radius 1 }";
    let huge = "Scale 1e300 1 1";
    let error = resolve_error(&format!("Group {{\nTransform {{ {huge}\nTransform {{ {huge} {ball} }} }} }}"));
    assert_eq!((error.line(), error.offending_text()), (4, "Transform"));
    assert!(error.message().contains("singular") && error.remedy().contains("scale"), "{error}");
    // The error points at the innermost enclosing transform, even if another transform has ended
    // before the object.
    let fine = format!("Transform {{ UniformScale 2 {ball} }}");
    let error = resolve_error(&format!(
        "Group {{\nTransform {{ {huge} Group {{ {fine}\nTransform {{ {huge} {ball} }} }} }} }}"
    ));
    assert_eq!(error.line(), 4);
}

#[test]
fn a_sphere_of_zero_volume_is_refused() {
    let error =
        resolve_error("Group { Transform { UniformScale 1e-150\nScale 2 1 1 Sphere { center 0 0 0 radius 1e-300 } } }");
    assert_eq!((error.line(), error.offending_text()), (3, "Sphere"));
    assert!(error.message().contains("squeezed flat"));
}

#[test]
fn object_emission_overrides_material_emission() {
    let materials = "Materials { Diffuse a { reflectance 0 0 0 emission 1 2 3 } }";
    let ball = |x: i32, more: &str| format!("Sphere {{ center {x} 0 0 radius .4 {more} }}");
    let (own, none, other) = (ball(0, ""), ball(1, "emission 0 0 0"), ball(2, "emission 4 5 6"));
    let scene = resolve_scene_text(&format!("{materials} Group {{ {own} {none} {other} }}"));
    let emission = |x: f64| visible_surface(&scene, dvec3(x, 0.0, 5.0), Vec3::NEG_Z).unwrap().0.emission;
    assert_eq!([0.0, 1.0, 2.0].map(emission), [vec3(1.0, 2.0, 3.0), Vec3::ZERO, vec3(4.0, 5.0, 6.0)]);
    assert_eq!(scene.lights().len(), 2);
}

#[test]
fn unrenderable_objects_are_reported_with_position() {
    let axis = "BezierCurve { controls [ 0 0 0 ] [ 0 1 0 ] }";
    let long = format!("BezierCurve {{ controls {} }}", "[ 1 0 0 ] [ 1 1 0 ]".repeat(15));
    let emitting = "Materials { Diffuse a { reflectance 0 0 0 emission 1 1 1 } }";
    for (text, offending, message) in [
        ("Group {\nPlane { normal 0 1 0 offset 0 emission 0 0 1 } }".to_owned(), "Plane", "cannot emit"),
        (format!("{emitting} Group {{\nPlane {{ normal 0 1 0 offset 0 }} }}"), "Plane", "cannot emit"),
        (format!("Group {{\nRevSurface {{ profile {axis} }} }}"), "RevSurface", "no area"),
        (format!("Group {{\nRevSurface {{ profile {long} }} }}"), "RevSurface", "the degree is 29"),
    ] {
        let error = resolve_error(&text);
        assert_eq!((error.line(), error.column(), error.offending_text()), (3, 1, offending), "{error}");
        assert!(error.message().contains(message) && !error.remedy().is_empty(), "{error}");
    }
    let error = resolve_error("Group { Sphere { center 0 0 0 radius 1e30 } }");
    assert!(error.message().contains("single precision") && !error.remedy().is_empty(), "{error}");
}

#[test]
fn profiles_revolve_and_curves_are_invisible() {
    let curve = "BezierCurve { controls [ 2 -1 7 ] [ 2 1 7 ] }";
    assert_eq!(resolve_scene_text(&format!("Group {{ {curve} }}")).analytic_shape_count(), 0);
    let turned = format!("Transform {{ Translate 1 0 0 ZRotate 90 RevSurface {{ profile {curve} }} }}");
    let scene = resolve_scene_text(&format!("Group {{ {turned} }}"));
    let (surface, p) = visible_surface(&scene, dvec3(1.0, 0.0, 5.0), Vec3::NEG_Z).unwrap();
    assert!(
        (p.z - 2.0).abs() < 1e-6 && (surface.point.ng - Vec3::Z).length() < 1e-6,
        "a profile that goes up faces outward"
    );
    assert!(visible_surface(&scene, dvec3(3.0, 0.0, 5.0), Vec3::NEG_Z).is_none());
}

#[test]
fn meshes_are_found_beside_or_above_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir(&scenes).unwrap();
    let write = |path: &Path, x: f64| {
        std::fs::write(path, format!("v {x} -1 0\nv {} -1 0\nv {x} 1 0\nf 1 2 3\n", x + 1.0)).unwrap();
    };
    write(&scenes.join("beside.obj"), 0.0);
    write(&folder.path().join("above.obj"), 10.0);
    write(&scenes.join("both.obj"), 20.0);
    write(&folder.path().join("both.obj"), 30.0);
    let absolute = folder.path().join("absolute.obj");
    write(&absolute, 40.0);
    let mesh = |path: &str| format!("TriangleMesh {{ obj_file \"{path}\" }}");
    let paths = ["beside.obj", "above.obj", "both.obj", &absolute.display().to_string()].map(mesh).join(" ");
    let scene = resolve_in_folder(&scenes, &format!("Group {{ {paths} {} }}", mesh("beside.obj"))).unwrap();
    assert_eq!(scene.triangle_count(), 5);
    let there = |x: f64| visible_surface(&scene, dvec3(x + 0.1, -0.5, 5.0), Vec3::NEG_Z).is_some();
    assert_eq!([0.0, 10.0, 20.0, 30.0, 40.0].map(there), [true, true, true, false, true]);
}

#[test]
fn unreadable_meshes_are_reported_at_their_path() {
    let folder = tempfile::tempdir().unwrap();
    let error = |path: &str| {
        resolve_in_folder(folder.path(), &format!("Group {{\nTriangleMesh {{ obj_file {path} }} }}")).unwrap_err()
    };
    let missing = error("no.obj");
    assert_eq!((missing.line(), missing.offending_text()), (3, "no.obj"));
    assert!(missing.message().contains("`no.obj` does not exist"));
    let places = [folder.path().join("no.obj"), folder.path().join("../no.obj")];
    assert!(places.iter().all(|p| missing.remedy().contains(&p.display().to_string())), "{}", missing.remedy());
    let absolute = error("/no/such.obj");
    assert!(!absolute.remedy().contains(" or "), "{}", absolute.remedy());
    std::fs::create_dir(folder.path().join("folder.obj")).unwrap();
    assert!(error("folder.obj").message().contains("`folder.obj` is a folder"));
    std::fs::write(folder.path().join("bad.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let broken = error("bad.obj");
    assert_eq!((broken.line(), broken.offending_text()), (3, "bad.obj"));
    assert!(broken.message().contains("bad.obj:2"), "{broken}");
}

#[test]
fn area_lights_have_the_given_strength() {
    let scene = resolve_scene_text(
        "Lights {
            RectangleLight { corner 0 0 0 edge0 2 0 0 edge1 0 3 0 power 6 0 0 }
            DiscLight { center 10 0 0 normal 0 0 1 radius 2 power 0 4 0 }
            SphereLight { center 20 0 0 radius 3 power 0 0 9 }
            RectangleLight { corner 30 0 0 edge0 1 0 0 edge1 0 1 0 radiance 1 2 3 }
        } Group { }",
    );
    let emission = |x: f64| visible_surface(&scene, dvec3(x, 0.5, 9.0), Vec3::NEG_Z).unwrap().0.emission;
    // A Lambertian emitter of area A and radiance L has flux πAL.
    assert!(is_nearly_equal(emission(1.0), vec3(1.0 / PI, 0.0, 0.0)));
    assert!(is_nearly_equal(emission(10.0), vec3(0.0, 1.0 / (PI * PI), 0.0)));
    assert!(is_nearly_equal(emission(20.0), vec3(0.0, 0.0, 9.0 / (PI * 36.0 * PI))));
    assert_eq!(emission(30.5), vec3(1.0, 2.0, 3.0));
    // A rectangle light is dark from behind. The surfaces of all area lights reflect nothing.
    assert_eq!(visible_surface(&scene, dvec3(1.0, 0.5, -9.0), Vec3::Z).unwrap().0.emission, Vec3::ZERO);
    assert!(scene.materials().iter().skip(1).all(|m| *m == Material::black()));
    let power = |i: usize| scene.lights()[i].power(scene.photon_domain());
    assert!(is_nearly_equal(power(0), vec3(6.0, 0.0, 0.0)) && is_nearly_equal(power(1), vec3(0.0, 4.0, 0.0)));
    assert!(is_nearly_equal(power(2), vec3(0.0, 0.0, 9.0)) && is_nearly_equal(power(3), vec3(1.0, 2.0, 3.0) * PI));
}

#[test]
fn point_lights_have_the_given_strength() {
    // The middle of the ball is the middle of the scene, 3 away from the lights.
    let ball = "Group { Sphere { center 1 0 0 radius 1 } }";
    let lights = "Lights {
        PointLight { position 4 0 0 color 1 2 3 }
        PointLight { position 4 0 0 intensity 1 2 3 }
        PointLight { position 4 0 0 power 1 2 3 }
        DirectionalLight { direction 0 -2 0 color 1 2 3 }
        DirectionalLight { direction 0 -2 0 irradiance 1 2 3 }
    }";
    let scene = resolve_scene_text(&format!("{lights}{ball}"));
    let c = vec3(1.0, 2.0, 3.0);
    let strengths: Vec<Vec3> = scene
        .lights()
        .iter()
        .map(|light| match light {
            Light::Point(PointLight { position, intensity }) => {
                assert!(is_nearly_equal(*position, vec3(3.0, 0.0, 0.0)));
                *intensity
            }
            Light::Directional(DirectionalLight { direction, irradiance }) => {
                assert_eq!(*direction, Vec3::NEG_Y);
                *irradiance
            }
            other => panic!("{other:?}"),
        })
        .collect();
    let expected = [c * PI * 9.0, c, c / (4.0 * PI), c * PI, c];
    // For values up to 85, 3e-5 is a few roundings.
    assert!(strengths.iter().zip(expected).all(|(a, b)| (*a - b).abs().max_element() < 3e-5), "{strengths:?}");
}

#[test]
fn a_spotlight_angle_includes_the_penumbra() {
    let spot = |fields: &str| {
        let text = format!("Lights {{ SpotLight {{ position 0 4 0 {fields} intensity 1 1 1 }} }} Group {{ }}");
        match &resolve_scene_text(&text).lights()[0] {
            Light::Spot(spot) => *spot,
            other => panic!("{other:?}"),
        }
    };
    let sharp = spot("lookAt 0 0 0 angle 60");
    assert_eq!((sharp.axis, sharp.inner_one_minus_cos), (Vec3::NEG_Y, sharp.outer_one_minus_cos));
    assert!((1.0 - sharp.outer_one_minus_cos - 0.75f32.sqrt()).abs() < 1e-6);
    let soft = spot("direction 0 0 7 angle 180 penumbra 30");
    assert_eq!(soft.axis, Vec3::Z);
    assert!((soft.inner_one_minus_cos - 0.5).abs() < 1e-6 && (soft.outer_one_minus_cos - 1.0).abs() < 1e-6);
    let all_rim = spot("direction 0 0 1 angle 60 penumbra 30");
    assert_eq!(all_rim.inner_one_minus_cos, 0.0);
}

#[test]
fn the_camera_has_the_given_direction() {
    for aim in ["lookAt 1 0 0", "direction -1 -2 -3"] {
        let text = format!(
            "PerspectiveCamera {{ center 2 2 3 {aim} up 0 0 1 angle 90 width 30 height 20 }} Background {{ color 1 2 3 }} Group {{ }}"
        );
        let scene = resolve(&parse("a.txt", &text).unwrap(), &SourceText::new("a.txt", &text), Path::new("")).unwrap();
        let camera = scene.camera();
        assert_eq!((camera.size(), scene.background()), ((30, 20), vec3(1.0, 2.0, 3.0)));
        assert!((camera.center() + scene.origin() - dvec3(2.0, 2.0, 3.0)).length() < 1e-12);
        let middle = camera.generate_ray(glam::vec2(15.0, 10.0), None).direction;
        assert!(is_nearly_equal(middle, vec3(-1.0, -2.0, -3.0).normalize()), "{middle}");
        // The direction `up` appears upward in the picture.
        assert!(camera.generate_ray(glam::vec2(15.0, 0.0), None).direction.z > middle.z);
    }
    // The parser refuses an `up` along the view. But a description may be changed after parsing.
    let text = format!("{CAMERA}Group {{ }}");
    let mut description = parse("a.txt", &text).unwrap();
    description.camera.value.up = DVec3::Z;
    let error = resolve(&description, &SourceText::new("a.txt", &text), Path::new("")).unwrap_err();
    assert_eq!((error.line(), error.offending_text()), (1, "PerspectiveCamera"));
}

#[test]
fn radiance_above_single_precision_is_refused() {
    let checker = "Textures { Checker a { color1 9 9 9 } } Materials { Phong { emission a emissionScale 1e38 } }";
    for (text, place) in [
        ("Lights { SphereLight { center 0 0 0 radius 1e-10 power 1e30 1 1 } } Group { }", "SphereLight"),
        ("Lights { DiscLight { center 0 0 0 normal 0 1 0 radius 1e-200 power 0 1 0 } } Group { }", "DiscLight"),
        (&format!("{checker} Group {{ MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"), "Sphere"),
    ] {
        let error = resolve_error(text);
        assert!(error.offending_text() == place && error.message().contains("3.4e38"), "{error}");
        assert!(error.remedy().contains("emit less"), "{error}");
    }
}
