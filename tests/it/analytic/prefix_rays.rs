//! Prefix rays: camera rays that end at their first receiver, in addition to whole camera paths.

use super::light_tracing::{DEPTH, POWER, REFLECTANCE, SIZE, ball_scene_builder, landing_flux};
use crate::support::*;
use caustica::camera::Camera;
use caustica::integrate::{Algorithm, Settings};
use caustica::scene::{Material, Scene, SceneBuilder};
use caustica::shape::{Rectangle, Shape, Sphere};
use glam::DVec3;
use std::f64::consts::PI;

/// Edge of an orthographic film \[length].
const FILM: f64 = 0.4;

/// Renders passes and returns the mean over the picture's pixels for each.
///
/// Also checks that prefix rays are traced if `settings` allow them, and only then.
fn picture_means(scene: &Scene, settings: Settings, passes: u32) -> Vec<f64> {
    let allowed = settings.allows_prefix_rays;
    let integrator = Algorithm::Hybrid.prepare(scene, settings);
    assert_eq!(integrator.prefix_rays_per_pixel() > 0.0, allowed);
    let mean =
        |pixels: Vec<caustica::color::Rgb>| pixels.iter().map(|l| f64::from(l.x)).sum::<f64>() / pixels.len() as f64;
    (0..passes).map(|pass| mean(render_one_pass(&*integrator, pass))).collect()
}

/// Prefix rays keep the mean of small highlights, and more than halve the standard error.
///
/// A mirror shows a lamp that is smaller than a pixel. The mean radiance of the picture is the
/// radiance of the lamp times its fraction of the film.
#[test]
fn prefix_rays_keep_light_of_small_highlights() {
    let radius = 0.3 * FILM / f64::from(SIZE);
    let mut b = SceneBuilder::new();
    let mirror = b.add_material(Material::mirror(grey(1.0)));
    let lamp = b.add_material(Material::black());
    b.add_shape(
        Shape::Rectangle(Rectangle::new(dvec3(-1.0, -1.0, 0.0), DVec3::X * 2.0, DVec3::Y * 2.0)),
        mirror,
        grey(0.0),
    );
    b.add_shape(Shape::Sphere(Sphere::new(dvec3(0.0231, 0.0117, 8.0), radius)), lamp, grey(10.0));
    let camera = Camera::orthographic(DVec3::Z * 4.0, DVec3::NEG_Z, DVec3::Y, FILM, SIZE, SIZE).unwrap();
    let scene = b.build(camera).unwrap();
    let expected = 10.0 * PI * radius * radius / (FILM * FILM);
    let samples = |prefix_rays| {
        picture_means(
            &scene,
            Settings { allows_balance: false, allows_prefix_rays: prefix_rays, ..camera_ray_settings(4, 100) },
            200,
        )
    };
    let (with, without) = (samples(true), samples(false));
    assert_mean("with prefix rays", &with, expected, 0.0, 0.03);
    assert_mean("without prefix rays", &without, expected, 0.0, 0.1);
    let (error, usual) = (mean_and_error(&with).1, mean_and_error(&without).1);
    assert!(error < 0.5 * usual, "{error} with, {usual} without prefix rays");
}

/// Prefix rays keep the mean of a caustic seen in a mirror, and more than halve the standard error.
///
/// The caustic has a sharp focus. The picture shows the flux of the closed form.
#[test]
fn prefix_rays_keep_light_of_mirrored_caustics() {
    // The camera looks at the caustic at 60 degrees, by a mirror half way.
    let tilt = 60f64.to_radians();
    let direction = dvec3(libm::sin(tilt), -libm::cos(tilt), 0.0);
    let fold = dvec3(0.0, -DEPTH, 0.0) - direction * 4.0;
    let mirrored = dvec3(-direction.x, direction.y, 0.0);
    let mut b = ball_scene_builder();
    let mirror = b.add_material(Material::mirror(grey(1.0)));
    let corner = fold - dvec3(0.0, 0.5, 0.5);
    b.add_shape(Shape::Rectangle(Rectangle::new(corner, DVec3::Y, DVec3::Z)), mirror, grey(0.0));
    let camera = Camera::orthographic(fold - mirrored * 4.0, mirrored, DVec3::Y, FILM, SIZE, SIZE).unwrap();
    let scene = b.build(camera).unwrap();
    // All photons of the caustic are within the gather radius, so that the estimate keeps their
    // flux.
    let settings = Settings {
        allows_balance: false,
        aimed_paths: 20_000,
        gather_k: Some(0),
        radius: Some(0.02),
        ..camera_ray_settings(1, 100)
    };
    let flux_per_mean = FILM * FILM / libm::cos(tilt) * PI / REFLECTANCE;
    let flux = |prefix_rays| {
        let means = picture_means(&scene, Settings { allows_prefix_rays: prefix_rays, ..settings.clone() }, 300);
        means.iter().map(|mean| mean * flux_per_mean).collect::<Vec<f64>>()
    };
    let (with, without) = (flux(true), flux(false));
    assert_mean("with prefix rays", &with, landing_flux(), 5e-3 * POWER, 0.012);
    assert_mean("without prefix rays", &without, landing_flux(), 5e-3 * POWER, 0.04);
    let (error, usual) = (mean_and_error(&with).1, mean_and_error(&without).1);
    assert!(error < 0.5 * usual, "{error} with, {usual} without prefix rays");
}
