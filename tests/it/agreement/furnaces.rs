//! Furnace tests: if all walls emit the same radiance, every object that absorbs nothing is
//! invisible.

use super::compare::{Estimate, Grid, Renders, compare};
use super::methods::{ALL, Effort, Method};
use crate::support::{FALSE_ALARM_RATE, box_faces, dvec3, grey, midpoint_integral, square_camera, student_t_tail};
use caustica::scene::{Body, Material, Scene, SceneBuilder};
use caustica::shape::{Rectangle, Shape, Sphere};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const ALBEDO: Vec3 = Vec3::new(0.7, 0.5, 0.2);
const SIZE: (u32, u32) = (12, 12);

/// Builds a closed box with a ball inside. Its diffuse walls have radiance 1 everywhere.
///
/// Walls reflect the fraction `albedo` of the radiance, and emit the rest. The camera looks at
/// `at`.
fn furnace_scene(albedo: Vec3, ball: Option<Material>, at: DVec3) -> Scene {
    let mut b = SceneBuilder::new();
    let wall = b.add_material(if albedo == Vec3::ZERO { Material::black() } else { Material::diffuse(albedo) });
    for face in box_faces(-DVec3::ONE, DVec3::ONE, true) {
        b.add_shape(face, wall, Vec3::ONE - albedo);
    }
    if let Some(material) = ball {
        let material = b.add_material(material);
        b.add_shape(Shape::Sphere(Sphere::new(dvec3(0.0, 0.0, -0.3), 0.4)), material, Vec3::ZERO);
    }
    // At the wider angle, the view is 1.2 wide on the wall behind the ball. At the narrower angle,
    // it lies within the ball's outline.
    b.build(square_camera(dvec3(0.0, 0.0, 0.95), at, if albedo == Vec3::ZERO { 22.0 } else { 34.0 }, SIZE.0)).unwrap()
}

fn lossless_materials() -> Vec<(&'static str, Material)> {
    vec![
        ("mirror", Material::mirror(Vec3::ONE)),
        ("glass", Material::dielectric(1.5, Vec3::ZERO)),
        ("pane", Material::thin_dielectric(1.5, Vec3::ONE)),
        ("plastic", Material::coated_diffuse(Vec3::ONE, 1.5, 0.0, true)),
        // With the index ik, the reflectance is |1 − ik|²/|1 + ik|² = 1.
        ("metal", Material::conductor(Vec3::ZERO, Vec3::splat(2.0), 0.0)),
    ]
}

fn constant_estimate(value: DVec3) -> Estimate {
    Estimate { mean: vec![value], variance: vec![DVec3::ZERO], bias: vec![DVec3::ZERO], dof: f64::INFINITY }
}

const EFFORT: Effort = Effort { passes: 12, samples: 4, photons: 10_000, caustic: 10_000, radius: 0.12 };

/// Lossless balls are invisible between walls of equal radiance.
///
/// The light on a wall consists of direct light and light from the ball. Each part has a gradient
/// although their sum has none. So photon density estimates have a bias, which [`Renders`]
/// measures.
#[test]
#[ignore = "long: furnace of every lossless material by every integrator"]
fn lossless_materials_vanish_in_furnace() {
    let balls = lossless_materials().into_iter().map(|(name, m)| (name, Some(m))).chain([("nothing", None)]);
    for (name, ball) in balls {
        let scene = furnace_scene(ALBEDO, ball, DVec3::ZERO);
        for method in ALL {
            let renders = Renders::new(method, &scene, EFFORT);
            let ours = renders.over(&Grid::new(SIZE, 12));
            compare(&format!("furnace with {name}, {method:?}"), &ours, &constant_estimate(DVec3::ONE), 0.045);
        }
    }
}

/// The energy loss of rough materials is as the docs of [`Conductor`](caustica::bsdf::Conductor)
/// and `RoughDielectric` state.
///
/// Between black walls of radiance 1, the ball shows its directional albedo: 1 − loss. The view is
/// 22° wide, 0.6 of the ball's radius, so normals are within 45° of it. The allowed losses are the
/// stated ones, rounded up. With multiple scattering, 1 % per interface is allowed. A metal at α =
/// 0.1 loses 1.2 % along the normal and 11 % at 85°. Glass loses 0.1 % and 1.2 % on its way through
/// two interfaces. A tenth of the light is reflected inside; up to 14 % of this light is lost too.
#[test]
#[ignore = "long: furnaces of many materials"]
fn rough_materials_lose_only_stated_energy() {
    let frosted = |alpha| Material::rough_boundary(Body::new(1.5), alpha);
    let metal = |alpha| Material::conductor(Vec3::ZERO, Vec3::splat(2.0), alpha);
    for (name, ball, least, most) in [
        ("metal", metal(0.1).with_single_microfacet_scattering(), 0.96, 1.0),
        ("frosted glass", frosted(0.1).with_single_microfacet_scattering(), 0.95, 1.0),
        ("rough metal", metal(0.5).with_single_microfacet_scattering(), 0.6, 1.0),
        ("metal with multiple scattering", metal(0.1), 0.99, 1.01),
        ("rough metal with multiple scattering", metal(0.8), 0.99, 1.01),
        ("frosted glass with multiple scattering", frosted(0.3), 0.98, 1.02),
    ] {
        let scene = furnace_scene(Vec3::ZERO, Some(ball), DVec3::ZERO);
        for method in ALL {
            let ours = Renders::new(method, &scene, Effort { samples: 16, ..EFFORT }).over(&Grid::new(SIZE, 12));
            let (mean, error) = (ours.mean[0].x, ours.variance[0].x.sqrt());
            eprintln!("{name}, {method:?}: {mean:.5} ± {error:.1e}");
            assert!(error < 0.01);
            let p = |excess: f64| if excess <= 0.0 { 1.0 } else { student_t_tail(excess / error, ours.dof) };
            assert!(p(mean - most - 1e-5) >= FALSE_ALARM_RATE, "{name}, {method:?} gains: {mean} ± {error}");
            assert!(p(least - mean) >= FALSE_ALARM_RATE, "{name}, {method:?} loses too much: {mean} ± {error}");
        }
    }
}

/// Returns the albedo kd + (ks/π)∫ cosˢα cosθ' dω of the Phong BRDF at the angle θ, by midpoints.
///
/// The integral is over the upper hemisphere.
fn phong_albedo(kd: f64, ks: f64, s: f64, theta: f64) -> f64 {
    let (sin, cos) = (libm::sin(theta), libm::cos(theta));
    let ring = |t: f64| {
        let (st, ct) = (libm::sin(t), libm::cos(t));
        let lobe = |phi: f64| libm::pow((cos * ct - sin * st * libm::cos(phi)).max(0.0), s);
        st * ct * midpoint_integral(0.0, 2.0 * PI, 300, lobe)
    };
    kd + ks / PI * midpoint_integral(0.0, 0.5 * PI, 300, ring)
}

/// Under uniform light of 1, a Phong surface shows its albedo at the angle `theta`.
///
/// The view is narrow, so all its rays have nearly the same angle.
#[test]
#[ignore = "long: furnaces of a glossy material"]
fn glossy_material_shows_its_furnace_albedo() {
    let (kd, ks, s) = (0.4, 3.0, 12.0);
    for theta in [0.2f64, 1.1] {
        let mut b = SceneBuilder::new();
        let black = b.add_material(Material::black());
        let gloss = b.add_material(Material::phong(grey(kd), grey(ks), s as f32));
        for face in box_faces(-DVec3::ONE, DVec3::ONE, true) {
            b.add_shape(face, black, Vec3::ONE);
        }
        let square = Rectangle::new(dvec3(-0.4, 0.0, -0.4), DVec3::Z * 0.8, DVec3::X * 0.8);
        b.add_shape(Shape::Rectangle(square), gloss, Vec3::ZERO);
        let eye = dvec3(libm::sin(theta), libm::cos(theta), 0.0) * 0.8;
        let scene = b.build(square_camera(eye, DVec3::ZERO, 0.5, 8)).unwrap();
        let expected = phong_albedo(kd, ks, s, theta);
        assert!(expected < 1.0);
        for method in ALL {
            let renders = Renders::new(method, &scene, Effort { samples: 64, ..EFFORT });
            let ours = renders.over(&Grid::new((8, 8), 8));
            // The tolerance of 10⁻³ covers midpoint quadrature and the view's width of half a
            // degree.
            let truth =
                Estimate { bias: vec![DVec3::splat(1e-3 * expected)], ..constant_estimate(DVec3::splat(expected)) };
            compare(&format!("gloss at {theta}, {method:?}"), &ours, &truth, 0.04);
        }
    }
}

/// Integrators agree in a closed box with Phong walls, and the radiance is below 1.
///
/// Walls with the albedo kd + 2ks/(s + 2) = 0.75 would have radiance 1. This albedo is an upper
/// bound for the BRDF.
#[test]
#[ignore = "long: many samples by several integrators"]
fn integrators_agree_on_glossy_walls() {
    let mut b = SceneBuilder::new();
    let wall = b.add_material(Material::phong(grey(0.25), grey(1.5), 4.0));
    for face in box_faces(-DVec3::ONE, DVec3::ONE, true) {
        b.add_shape(face, wall, Vec3::splat(0.25));
    }
    let scene = b.build(square_camera(dvec3(0.0, 0.0, 0.9), dvec3(0.3, 0.1, -1.0), 30.0, SIZE.0)).unwrap();
    let grid = Grid::new(SIZE, 12);
    let path = Renders::new(Method::Path, &scene, EFFORT);
    let (mean, error) = (path.over(&grid).mean[0].x, path.over(&grid).variance[0].x.sqrt());
    assert!(mean + 5.0 * error < 1.0, "{mean} ± {error}");
    for method in ALL.into_iter().skip(1) {
        let ours = Renders::new(method, &scene, EFFORT);
        compare(&format!("glossy walls, {method:?}"), &ours.over(&grid), &path.over(&grid), 0.03);
    }
}
