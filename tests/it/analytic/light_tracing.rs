//! Light tracing: splats on the film show all light of a caustic that a ball lens focuses on a
//! screen.

use crate::support::*;
use caustica::camera::{Camera, Lens};
use caustica::integrate::{Algorithm, LightTracing, Settings};
use caustica::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Rectangle, Shape, Sphere};
use glam::{DVec2, DVec3, Vec2};
use std::f64::consts::PI;

const IOR: f64 = 1.5;
pub(super) const POWER: f64 = 5.0;
/// Reflectance of the screen. The screen is dark, so light that returns to it from the ball adds
/// less than the squared reflectance.
pub(super) const REFLECTANCE: f64 = 0.02;
/// Distance of the light above the ball's center.
const HEIGHT: f64 = 20.0;
/// Depth of the screen below the ball's center. The paraxial focus is 1.5 to 1.6 below it.
pub(super) const DEPTH: f64 = 1.5;
/// Largest distance from the axis at which the beam hits the ball.
const BEAM: f64 = 0.6;
/// Edge of the picture in pixels.
pub(super) const SIZE: u32 = 24;

/// Builds a glass ball of radius 1 in a narrow beam from above, and a screen below it.
fn ball_scene(camera: Camera) -> Scene {
    ball_scene_builder().build(camera).unwrap()
}

pub(super) fn ball_scene_builder() -> SceneBuilder {
    let mut b = SceneBuilder::new();
    let glass = b.add_material(Material::dielectric(IOR as f32, grey(0.0)));
    let screen = b.add_material(Material::diffuse(grey(REFLECTANCE)));
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), glass, grey(0.0));
    let corner = dvec3(-1.5, -DEPTH, -1.5);
    b.add_shape(Shape::Rectangle(Rectangle::new(corner, DVec3::Z * 3.0, DVec3::X * 3.0)), screen, grey(0.0));
    let angle = libm::asin(BEAM / HEIGHT);
    let kind = UnscaledDeltaLight::Spot { position: DVec3::Y * HEIGHT, axis: -DVec3::Y, inner: angle, outer: angle };
    b.add_delta_light(kind, LightStrength::Power(grey(POWER)));
    b
}

/// Returns the landing distance from the axis and the transmittance of the ray at the angle `theta`
/// from the beam's axis.
///
/// The ray is refracted at both surfaces of the ball.
fn landing(theta: f64) -> (f64, f64) {
    let h = HEIGHT * libm::sin(theta);
    let convergence = 2.0 * (libm::asin(h) - libm::asin(h / IOR)) - theta;
    let crossing = h / libm::sin(convergence);
    let reflectance = fresnel_reflectance((1.0 - h * h).sqrt(), IOR);
    ((DEPTH - crossing).abs() * libm::tan(convergence), (1.0 - reflectance) * (1.0 - reflectance))
}

/// Returns the flux \[W] that lands on the screen after two refractions.
pub(super) fn landing_flux() -> f64 {
    let end = 1.0 - libm::cos(libm::asin(BEAM / HEIGHT));
    let transmittance = |x: f64| landing(libm::acos(1.0 - x)).1;
    POWER / end * midpoint_integral(0.0, end, 1000, transmittance)
}

/// Cameras that look at the focus on the screen, past the ball, at 60 degrees from the screen's
/// normal.
fn cameras() -> [(&'static str, Camera); 3] {
    let tilt = 60f64.to_radians();
    let direction = dvec3(libm::sin(tilt), -libm::cos(tilt), 0.0);
    let focus = dvec3(0.0, -DEPTH, 0.0);
    let eye = focus - direction * 8.0;
    let angle = 2.0 * libm::atan(0.2 / 8.0);
    let pinhole = Camera::perspective(eye, direction, DVec3::Y, angle, SIZE, SIZE).unwrap();
    [
        ("pinhole", pinhole),
        ("lens", pinhole.with_lens(Lens { radius: 0.05, focus_distance: 7.9, blades: 0 })),
        ("orthographic", Camera::orthographic(eye, direction, DVec3::Y, 0.4, SIZE, SIZE).unwrap()),
    ]
}

/// Returns the area of the screen that pixel (`x`, `y`) shows through the lens center.
fn screen_area(camera: &Camera, x: u32, y: u32) -> f64 {
    let at = |dx: f32, dy: f32| {
        let ray = camera.generate_ray(Vec2::new(x as f32 + 0.5 + dx, y as f32 + 0.5 + dy), None);
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let p = o + d * ((-DEPTH - o.y) / d.y);
        DVec2::new(p.x, p.z)
    };
    (at(0.5, 0.0) - at(-0.5, 0.0)).perp_dot(at(0.0, 0.5) - at(0.0, -0.5)).abs()
}

/// Renders passes and returns the flux of the screen that the picture shows \[W], for each pass.
fn pictured_flux(camera: &Camera, (light_tracing, photons): (LightTracing, u32), seed: u64, passes: u32) -> Vec<f64> {
    let scene = ball_scene(*camera);
    let mut settings = Settings {
        allows_ray_photon_balance: false,
        aimed_paths: photons,
        light_tracing,
        ..camera_ray_settings(1, 100)
    };
    settings.camera_paths.seed = seed;
    let areas: Vec<f64> = (0..SIZE * SIZE).map(|i| screen_area(camera, i % SIZE, i / SIZE)).collect();
    let integrator = Algorithm::Hybrid.prepare(&scene, settings);
    let flux = |pixels: Vec<caustica::color::Rgb>| {
        pixels.iter().zip(&areas).map(|(l, area)| f64::from(l.x) * area * PI / REFLECTANCE).sum()
    };
    (0..passes).map(|pass| flux(render_one_pass(&*integrator, pass))).collect()
}

/// Splats with and without weights show the flux of the closed form, for every kind of camera.
///
/// The tolerance covers three effects: light that the ball reflects inside (at most .2 %), light
/// that returns to the screen, and the variation of the screen area that a pixel shows.
#[test]
#[ignore = "long: statistics against a closed form"]
fn light_tracing_shows_all_flux_of_a_focus() {
    let end = libm::asin(BEAM / HEIGHT);
    let widest = (1..=1000).map(|i| landing(end * f64::from(i) / 1000.0).0).fold(0.0, f64::max);
    assert!(widest < 0.15, "the film holds the whole caustic: {widest}");
    // With few photons, weighted splats have weights between 0 and 1 in the pixels of the caustic.
    let cases =
        [(LightTracing::Full, 20_000, 16), (LightTracing::Weighted, 20_000, 16), (LightTracing::Weighted, 200, 800)];
    for (name, camera) in cameras() {
        for (light_tracing, photons, passes) in cases {
            let samples = pictured_flux(&camera, (light_tracing, photons), 5, passes);
            let what = format!("{name}, {light_tracing:?}, {photons} photons");
            assert_mean(&what, &samples, landing_flux(), 5e-3 * POWER, 8e-3);
        }
    }
}

/// After 16 passes, each of eight seeds shows the light of the focus within 3 %.
#[test]
fn every_seed_shows_the_light_of_a_focus() {
    let (_, camera) = cameras()[0];
    for seed in 0..8 {
        let samples = pictured_flux(&camera, (LightTracing::Weighted, 20_000), seed, 16);
        let (mean, _) = mean_and_error(&samples);
        let ratio = mean / landing_flux();
        eprintln!("seed {seed}: {ratio:.4}");
        assert!((ratio - 1.0).abs() < 0.03, "seed {seed}: {ratio}");
    }
}
