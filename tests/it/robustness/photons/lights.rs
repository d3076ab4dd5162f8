//! Lights of zero power, lights inside walls, and scenes that are black.

use super::{WITH_PHOTONS, assert_finite, flat_camera, rectangle_around, rendered, settings};
use crate::support::{PATIENCE, mean_and_error, render_one_pass, render_passes};
use caustica::camera::Camera;
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, Settings};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::{Key, Purpose};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Shape, Sphere};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Integrators whose only bias is that of density estimates.
const ALL: [Algorithm; 5] = [Algorithm::Path, Algorithm::Hybrid, Algorithm::Sppm, Algorithm::Ppm, Algorithm::Pm];

/// Builds a ball and a glass body on a floor, lit by point lights of the given powers.
/// `None` omits the light at this position of the list.
fn scene_lit_by(powers: &[Option<f32>]) -> Scene {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Rgb::splat(0.6)));
    let glass = b.add_material(Material::dielectric(1.5, Rgb::ZERO));
    b.add_shape(rectangle_around(DVec3::ZERO, DVec3::Z * 4.0, DVec3::X * 4.0), white, Rgb::ZERO);
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(-0.6, 0.5, 0.0), 0.5)), white, Rgb::ZERO);
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(0.6, 0.5, 0.0), 0.5)), glass, Rgb::ZERO);
    for (i, power) in powers.iter().enumerate() {
        let position = DVec3::new(i as f64 * 0.3 - 0.5, 2.0, 0.7);
        if let Some(power) = power {
            b.add_delta_light(UnscaledDeltaLight::Point { position }, LightStrength::Power(Rgb::splat(*power)));
        }
    }
    let camera = Camera::perspective(DVec3::new(0.0, 1.0, 5.0), DVec3::new(0.0, -0.1, -1.0), DVec3::Y, 0.6, 12, 12);
    b.build(camera.unwrap()).unwrap()
}

/// Lights of zero power, before, between or after other lights, change no bit of the image.
///
/// A scene with only such lights is black.
#[test]
fn zero_power_lights_change_nothing() {
    let (dark, lit) = (Some(0.0), Some(50.0));
    ALL.par_iter().for_each(|algorithm| {
        let settings = || Settings { initial_gather_radius: Some(0.1), ..settings(10_000, 4) };
        let seen = |powers: &[Option<f32>]| render_passes(&scene_lit_by(powers), *algorithm, settings(), 2);
        let one = seen(&[None, lit]);
        assert!(one.iter().any(|v| *v != Rgb::ZERO), "{}", algorithm.name());
        for powers in [&[dark, lit][..], &[None, lit, dark], &[dark, lit, dark, dark, dark, dark, dark]] {
            assert!(seen(powers) == one, "{}: {powers:?}", algorithm.name());
        }
        for powers in [&[dark][..], &[dark; 7], &[]] {
            let scene = scene_lit_by(powers);
            let out = rendered(&scene, *algorithm, settings(), 4);
            assert_finite(algorithm.name(), &out);
            assert!(out.film.pixel_means().all(|v| v == DVec3::ZERO), "{}", algorithm.name());
            assert_eq!(out.unaimed.emitted_paths + out.aimed.emitted_paths, 0);
        }
    });
}

/// Returns rotations after which points of a plane are off the rotated plane by rounding errors.
fn test_rotations() -> impl Iterator<Item = DQuat> {
    let turn = |i: i32| DQuat::from_axis_angle(DVec3::new(1.0, f64::from(i), 0.3).normalize(), 0.7 * f64::from(i));
    (0..12).map(turn)
}

/// Builds a point light of 1 W in the plane of a black floor, and a ceiling 2 wide at height 1.
///
/// A sixth of the light falls on the ceiling, as on the face of a cube.
fn point_in_the_floor(turn: DQuat, at: DVec3) -> Scene {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Rgb::splat(0.5)));
    let black = b.add_material(Material::black());
    let (x, y, z) = (turn * DVec3::X, turn * DVec3::Y, turn * DVec3::Z);
    b.add_shape(rectangle_around(at, z * 2.0, x * 2.0), black, Rgb::ZERO);
    b.add_shape(rectangle_around(at + y, x * 2.0, z * 2.0), white, Rgb::ZERO);
    b.add_delta_light(UnscaledDeltaLight::Point { position: at }, LightStrength::Power(Rgb::ONE));
    let camera = Camera::orthographic(at + 0.5 * y, y, z, 2.0, 16, 16).unwrap();
    b.build(camera).unwrap()
}

/// A point light in the plane of a floor lights the ceiling, although rounding may place it below
/// the floor.
///
/// Tolerance for photons: five sigma of a binomial distribution of 2¹⁶ paths, which is .044.
/// Tolerance for shadow rays: five times .1/64, because 4096 rays are stratified over an image that
/// varies by a tenth per pixel.
#[test]
fn point_light_in_floor_lights_ceiling() {
    let places = [DVec3::ZERO, DVec3::new(0.1, 0.2, 0.3), DVec3::new(100.1, 0.7, -33.3)];
    let all: Vec<(DVec3, DQuat)> = places.iter().flat_map(|at| test_rotations().map(move |turn| (*at, turn))).collect();
    all.par_iter().for_each(|(at, turn)| {
        let scene = point_in_the_floor(*turn, *at);
        let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
        let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::DIRECT, max_bounces: 0 };
        let traced = tracer.trace(Key::new(3).purpose_key(Purpose::Test), 1 << 16, &|_| {});
        let flux: f64 = traced.deposits.surface_photons.iter().map(|p| f64::from(p.attributes.flux().y)).sum();
        assert!((6.0 * flux - 1.0).abs() < 0.044, "{at} {turn}: {flux}");
        let out = rendered(&scene, Algorithm::Whitted, settings(0, 16), 1);
        let seen = out.film.mean_picture().iter().map(|v| f64::from(v.y)).sum::<f64>() / 256.0 * 4.0 * PI / 0.5;
        assert!((6.0 * seen - 1.0).abs() < 5.0 * 0.1 / 64.0, "{at} {turn}: {seen}");
    });
}

/// Builds an area light in the plane of a black ceiling, facing down, and a floor under it.
///
/// If `first` is true, the light precedes the ceiling in the scene.
fn lamp_in_the_ceiling(turn: DQuat, first: bool) -> Scene {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Rgb::splat(0.5)));
    let black = b.add_material(Material::black());
    let (x, y, z) = (turn * DVec3::X, turn * DVec3::Y, turn * DVec3::Z);
    let lamp = rectangle_around(y, x * 0.5, z * 0.5);
    if first {
        b.add_shape(lamp.clone(), black, Rgb::ONE);
    }
    b.add_shape(rectangle_around(y, x * 4.0, z * 4.0), black, Rgb::ZERO);
    if !first {
        b.add_shape(lamp, black, Rgb::ONE);
    }
    b.add_shape(rectangle_around(DVec3::ZERO, z * 4.0, x * 4.0), white, Rgb::ZERO);
    b.build(Camera::orthographic(0.5 * y, -y, z, 0.5, 4, 4).unwrap()).unwrap()
}

/// All integrators find the light of an area light in the plane of a ceiling, whichever of both the
/// scene lists first.
///
/// Light sampling and BSDF sampling share the light by MIS weights. The error of the midpoint rule
/// with 40 steps is 40⁻²/24 of the second derivative, below 10⁻⁴. t with 15 degrees of freedom
/// exceeds 7 once in 10⁵ times.
#[test]
fn area_light_in_ceiling_plane_loses_no_light() {
    // The expected radiance is the mean over the patch of 0.5 × 0.5 of ρ/π L ∫ dA h²/d⁴ with height
    // h = 1 and distance d.
    let n = 40;
    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 0.5;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                for l in 0..n {
                    let d2 = 1.0 + (at(i) - at(k)) * (at(i) - at(k)) + (at(j) - at(l)) * (at(j) - at(l));
                    sum += 1.0 / (d2 * d2);
                }
            }
        }
    }
    let expected = 0.5 / PI * 0.25 * sum / libm::pow(f64::from(n), 4.0);
    for algorithm in ALL {
        for (i, turn) in test_rotations().take(6).enumerate() {
            let scene = lamp_in_the_ceiling(turn, i % 2 == 0);
            let method = algorithm.prepare(&scene, settings(1000, 64));
            let mean = |i| render_one_pass(&*method, i).iter().map(|v| f64::from(v.y)).sum::<f64>() / 16.0;
            let (mean, error) = mean_and_error(&(0..16).map(mean).collect::<Vec<f64>>());
            let off = (mean - expected).abs();
            assert!(off < 7.0 * error + 1e-4 * expected, "{} {i}: {}", algorithm.name(), mean / expected);
            assert!(error < 3e-3 * expected, "{}: {error}", algorithm.name());
        }
    }
}

/// Lights whose surroundings block all light store no photons, and the picture is black.
///
/// One is a point light in a black ball. The other is an area light just in front of a black wall.
#[test]
fn blocked_lights_emit_no_photons() {
    let mut b = SceneBuilder::new();
    let white = b.add_material(Material::diffuse(Rgb::splat(0.5)));
    let black = b.add_material(Material::black());
    let glass = b.add_material(Material::dielectric(1.5, Rgb::ZERO));
    b.add_shape(rectangle_around(DVec3::ZERO, DVec3::Z * 4.0, DVec3::X * 4.0), white, Rgb::ZERO);
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::new(1.0, 1.0, 0.0), 0.3)), glass, Rgb::ZERO);
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::Y, 0.1)), black, Rgb::ZERO);
    b.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::Y }, LightStrength::Power(Rgb::ONE));
    b.add_shape(rectangle_around(DVec3::Y * 2.0, DVec3::X, DVec3::Z), black, Rgb::ZERO);
    b.add_shape(rectangle_around(DVec3::Y * 1.999_99, DVec3::Z * 0.1, DVec3::X * 0.1), black, Rgb::ONE);
    let scene = b.build(flat_camera(DVec3::new(0.0, 3.0, 0.0), -DVec3::Y, 4.0, 8)).unwrap();
    for algorithm in WITH_PHOTONS {
        let out = rendered(&scene, algorithm, settings(20_000, 4), 4);
        assert_finite(algorithm.name(), &out);
        assert!(out.film.pixel_means().all(|v| v == DVec3::ZERO), "{}", algorithm.name());
        assert_eq!(out.unaimed.stored_photons + out.aimed.stored_photons, 0);
        for report in [out.unaimed, out.aimed].iter().filter(|r| r.emitted_paths > 0) {
            let [emitted, absorbed] = [report.audit.emitted[1], report.audit.absorbed[1]];
            assert!(emitted > 0.0 && (absorbed / emitted - 1.0).abs() < 1e-6, "{:?}", report.audit);
        }
    }
}

/// Runs the program on a scene with more flags and returns its messages. Panics if the program
/// fails.
fn run_messages(lights_and_things: &str, more: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let camera =
        "PerspectiveCamera { center 0 0 5 lookAt 0 0 0 angle 30 width 8 height 8 }\nBackground { color 0 0 0 }\n";
    std::fs::write(folder.path().join("a.txt"), format!("{camera}{lights_and_things}")).unwrap();
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_caustica"));
    command.current_dir(folder.path()).timeout(PATIENCE);
    let output = command.args(["render", "a.txt", "-o", "a.exr", "--passes", "4"]).args(more).output().unwrap();
    let words = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{words}");
    let picture = caustica::image::read(&folder.path().join("a.exr")).unwrap();
    assert!(picture.pixels().iter().all(|p| *p == glam::Vec3::ZERO), "{words}");
    words
}

/// A render of a black scene ends, writes the image, and names the cause in a message.
#[test]
fn black_scenes_terminate_with_report() {
    let ball = "Group { Sphere { center 0 0 0 radius 1 } }\n";
    let cases = [
        (ball.to_owned(), "the scene has no light"),
        (format!("Lights {{ PointLight {{ position 0 5 5 power 0 0 0 }} }} {ball}"), "no light has any power"),
        (
            format!(
                "Lights {{ PointLight {{ position 0 5 5 power 9 9 9 }} }} Materials {{ Diffuse {{ reflectance 0 0 0 }} }} {ball}"
            ),
            "no light reaches what the camera sees",
        ),
        (
            "Lights { PointLight { position 0 0 0 power 9 9 9 } } Materials { Diffuse soot { reflectance 0 0 0 } \
                 Dielectric glass { indexOfRefraction 1.5 } } Group { MaterialName soot Sphere { center 0 0 0 radius .5 } \
                 MaterialName glass Sphere { center 1 0 0 radius .3 } }".to_owned(),
            "no light reaches what the camera sees",
        ),
    ];
    cases.par_iter().enumerate().for_each(|(i, (text, reason))| {
        for method in ["hybrid", "sppm", "pm", "path"] {
            let words = run_messages(text, &["--photons", "1k", "--caustic-photons", "1k", "--integrator", method]);
            assert!(words.contains(&format!("note: every pixel is black: {reason}")), "{method}: {words}");
            // The last scene has glass, so photons are emitted. None escapes from the enclosure.
            let sent = i == 3 && method != "path";
            assert_eq!(words.contains("no photon stored"), sent, "{method}: {words}");
            assert!(!sent || words.contains(" 0 % left the scene"), "{method}: {words}");
        }
    });
}
