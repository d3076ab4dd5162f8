//! Adjoint transport: the flux of photons that land in a window of the floor agrees with path
//! tracing.
//!
//! A camera that looks straight at a plane weights each part of it equally. So the mean over its
//! image is ρE/π, where E is the window's mean irradiance and ρ its albedo. Neither side estimates
//! a density, so neither is biased.

use super::compare::{Estimate, Grid, Renders, compare, compare_renders};
use super::methods::{Effort, Method};
use crate::support::{flux_where, scene_from_text, trace_photon_passes};
use caustica::photon::StoreMask;
use caustica::scene::Scene;
use glam::DVec3;
use std::f64::consts::PI;

const ALBEDO: f64 = 0.5;

/// Number of passes. It gives a standard error of 2 %.
const PASSES: u32 = 12;
/// Number of passes for shading normals, whose corrections add noise.
const SHADING_NORMAL_PASSES: u32 = 24;

/// Half the width of the window \[length].
///
/// The camera looks down from this height with a field of view of 90°.
const HALF: f64 = 0.4;

/// Scene text of a light beside the window that faces up, so that light reaches the floor only by
/// reflection at objects above.
const UP: &str = "RectangleLight { corner .5 .5 -.4  edge0 0 0 1  edge1 1 0 0  radiance 6 5 4 }";

/// Scene text of a light above the window, off its center, that faces down.
const DOWN: &str = "RectangleLight { corner -.3 2.2 -.7  edge0 1 0 0  edge1 0 0 1  radiance 6 5 4 }";

const CEILING: &str = "Rectangle { corner -1.5 1.3 -1.5  edge0 3 0 0  edge1 0 0 3 }";
const BALL: &str = "Sphere { center 0 1.1 0  radius .5 }";
const COARSE: &str = "Transform { Translate 0 1.2 0  UniformScale .7  TriangleMesh { obj_file coarse-ball.obj } }";

fn furnished_room(light: &str, materials: &str, objects: &str) -> Scene {
    let floor = "Rectangle { corner -2 0 -2  edge0 0 0 4  edge1 4 0 0 }";
    scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 {HALF} 0  direction 0 -1 0  up 0 0 1  angle 90  width 8  height 8 }}
        Background {{ color 0 0 0 }}
        Lights {{ {light} }}
        Materials {{ Diffuse floor {{ reflectance {ALBEDO} {ALBEDO} {ALBEDO} }} {materials} }}
        Group {{ MaterialName floor {floor} {objects} }}"
    ))
}

/// Estimates ρE/π by photons, where E is the window's mean irradiance and ρ its albedo.
fn flux_by_photons(scene: &Scene, mask: StoreMask, passes: u32) -> Estimate {
    let traced = trace_photon_passes(scene, mask, 1000, passes, 1 << 17);
    let window = |p: DVec3| p.y.abs() < 1e-3 && p.x.abs() < HALF && p.z.abs() < HALF;
    let per_area = ALBEDO / PI / (4.0 * HALF * HALF);
    let samples: Vec<DVec3> =
        traced.iter().map(|t| flux_where(scene, &t.deposits.surface_photons, window) * per_area).collect();
    let n = f64::from(passes);
    let mean = samples.iter().sum::<DVec3>() / n;
    let squares: DVec3 = samples.iter().map(|s| (s - mean) * (s - mean)).sum();
    Estimate { mean: vec![mean], variance: vec![squares / n / (n - 1.0)], bias: vec![DVec3::ZERO], dof: n - 1.0 }
}

/// Fails unless the flux by photons agrees with that by path tracing.
///
/// At least the fraction `least` of the flux must involve the object, so that the comparison is a
/// test of the object.
fn check_adjoint(what: &str, scene: &Scene, least: f64) {
    check_adjoint_with_settings(PASSES, what, scene, least);
}

fn check_adjoint_with_settings(passes: u32, what: &str, scene: &Scene, least: f64) {
    let photons = flux_by_photons(scene, StoreMask::ALL, passes);
    let direct = flux_by_photons(scene, StoreMask::DIRECT, 2);
    let part = 1.0 - direct.mean[0].x / photons.mean[0].x;
    assert!(part >= least, "{what}: only {part} comes by the object");
    let effort = Effort { passes, samples: 384, photons: 0, caustic: 0, radius: 1.0 };
    let path = Renders::new(Method::Path, scene, effort).over(&Grid::new((8, 8), 8));
    compare(&format!("{what} ({:.0} % by the object)", 100.0 * part), &photons, &path, 0.02);
}

#[test]
#[ignore = "long: t-tests of adjoint transport"]
fn reflections_agree_from_camera_and_light() {
    for (name, material) in [
        ("diffuse", "Diffuse m { reflectance .9 .7 .5 }"),
        ("gloss", "Phong m { diffuseColor .2 .2 .2  specularColor 6 5 4  shininess 25 }"),
        ("mirror", "Mirror m { reflectance .9 .8 .7 }"),
        ("metal", "Conductor m { metal copper }"),
        ("rough metal", "Conductor m { metal gold  roughness .2 }"),
        ("very rough metal", "Conductor m { metal gold  roughness .6 }"),
        ("pane", "Thin m { indexOfRefraction 2.5  transmittance .9 .5 .9 }"),
        (
            "mix",
            "Diffuse a { reflectance .9 .7 .5 } Mirror b { reflectance .9 .8 .7 } Mix m { first a second b amount .4 }",
        ),
    ] {
        check_adjoint(name, &furnished_room(UP, material, &format!("MaterialName m {CEILING}")), 0.95);
    }
}

#[test]
#[ignore = "long: t-tests of adjoint transport"]
fn refractions_agree_from_camera_and_light() {
    // Light that crosses a pane counts as direct, so its part by the object cannot be told.
    for (name, material, object, least) in [
        ("glass", "Dielectric m { indexOfRefraction 1.5  absorption .2 .6 1 }", BALL, 0.3),
        ("frosted glass", "Dielectric m { indexOfRefraction 1.5  roughness .15 }", BALL, 0.3),
        ("very frosted glass", "Dielectric m { indexOfRefraction 1.5  roughness .6 }", BALL, 0.3),
        ("pane", "Thin m { indexOfRefraction 1.5  transmittance .9 .5 .9 }", CEILING, 0.0),
    ] {
        check_adjoint(name, &furnished_room(DOWN, material, &format!("MaterialName m {object}")), least);
    }
}

/// Tests interpolated shading normals, for which photon paths need a correction (Veach 1997,
/// section 5.3).
#[test]
#[ignore = "long: t-test of adjoint transport"]
fn shading_normals_agree_from_camera_and_light() {
    for (name, light, material, least) in [
        ("diffuse", UP, "Diffuse m { reflectance .9 .7 .5 }", 0.95),
        ("gloss", UP, "Phong m { diffuseColor .2 .2 .2  specularColor 6 5 4  shininess 25 }", 0.95),
        ("mirror", UP, "Mirror m { reflectance .9 .8 .7 }", 0.95),
        ("rough metal", UP, "Conductor m { metal gold  roughness .2 }", 0.95),
        ("glass", DOWN, "Dielectric m { indexOfRefraction 1.5 }", 0.3),
        ("frosted glass", DOWN, "Dielectric m { indexOfRefraction 1.5  roughness .2 }", 0.3),
    ] {
        check_adjoint_with_settings(
            SHADING_NORMAL_PASSES,
            &format!("smoothly shaded {name}"),
            &furnished_room(light, material, &format!("MaterialName m {COARSE}")),
            least,
        );
    }
}

/// Tests nested dielectrics with priorities: ice in water in a glass, and oil that overlaps the
/// glass.
#[test]
fn nested_dielectrics_agree_from_camera_and_light() {
    let materials = "Dielectric glass { indexOfRefraction 1.5  absorption .3 .3 .1 }
        Dielectric water { indexOfRefraction 1.33  absorption .2 .5 1  priority 1 }
        Dielectric ice { indexOfRefraction 1.2  priority 2 }
        Dielectric oil { indexOfRefraction 1.7  absorption .1 1 .4  priority 3 }";
    let objects = "MaterialName glass Sphere { center 0 1.1 0  radius .5 }
        MaterialName water Sphere { center 0 1.1 0  radius .42 }
        MaterialName ice Sphere { center .1 1.35 0  radius .22 }
        MaterialName oil Sphere { center -.4 1.1 .1  radius .25 }";
    check_adjoint("nested bodies", &furnished_room(DOWN, materials, objects), 0.3);
}

/// Tests a light inside dielectric bodies.
#[test]
#[ignore = "long: t-test of adjoint transport"]
fn enclosed_light_agrees_from_camera_and_light() {
    let lamp = "SphereLight { center .05 1.1 0  radius .2  radiance 6 5 4 }";
    let bulb = "Dielectric glass { indexOfRefraction 1.5  absorption .3 1 2 }
        Dielectric air { indexOfRefraction 1  priority 1 }";
    let objects = "MaterialName glass Sphere { center 0 1.1 0  radius .45 }
        MaterialName air Sphere { center 0 1.1 0  radius .38 }";
    check_adjoint("lamp in a bulb", &furnished_room(lamp, bulb, objects), 0.99);
    let ball = "MaterialName glass Sphere { center 0 1.1 0  radius .45 }";
    let solid = "Dielectric glass { indexOfRefraction 1.5  absorption .3 1 2 }";
    check_adjoint("lamp in solid glass", &furnished_room(lamp, solid, ball), 0.99);
    let frosted = "Dielectric glass { indexOfRefraction 1.5  roughness .3  absorption .3 1 2 }";
    check_adjoint("lamp in frosted glass", &furnished_room(lamp, frosted, ball), 0.99);
    let water = "Dielectric water { indexOfRefraction 1.33  absorption .3 .6 1 }  Diffuse m { reflectance .9 .7 .5 }";
    let objects = "MaterialName water Sphere { center 0 1.2 0  radius .7 }
        MaterialName m Sphere { center -.25 .9 .1  radius .25 }";
    let lamp = "SphereLight { center .2 1.3 0  radius .2  radiance 6 5 4 }";
    check_adjoint("lamp and matt ball under water", &furnished_room(lamp, water, objects), 0.99);
}

/// Tests a diffuse ball of flat faces with smooth shading normals.
///
/// Photons are stored with a density proportional to the cosine to the geometric normal, and the
/// camera shades with the shading normal. The ball fills the image. It is lit only through a
/// mirror, so all its light comes from photons.
#[test]
#[ignore = "long: t-test of adjoint transport"]
fn diffuse_shading_normals_agree_from_camera_and_light() {
    let scene = scene_from_text(&format!(
        "PerspectiveCamera {{ center 0 .1 0  direction 0 1 0  up 0 0 1  angle 45  width 32  height 32 }}
        Background {{ color 0 0 0 }}
        Lights {{ RectangleLight {{ corner .5 .1 -.5  edge0 .8 0 0  edge1 0 0 1  radiance 6 5 4 }} }}
        Materials {{ Diffuse m {{ reflectance .9 .7 .5 }} Mirror s {{ reflectance .9 .9 .9 }} }}
        Group {{ MaterialName m {COARSE}
            MaterialName s Rectangle {{ corner -1 -.5 -1  edge0 0 0 2  edge1 2 0 0 }} }}"
    ));
    let grid = Grid::new((32, 32), 16);
    let effort = Effort { passes: SHADING_NORMAL_PASSES, samples: 2, photons: 1 << 12, caustic: 1 << 17, radius: 0.03 };
    let path = Renders::new(Method::Path, &scene, Effort { samples: 128, ..effort });
    for method in [Method::Hybrid, Method::Sppm] {
        let renders = Renders::new(method, &scene, effort);
        compare_renders("coarse ball", &renders, &path, &grid, (0.06, 0.03));
    }
}
