//! Prefix rays: camera rays that end at their first receiver, in addition to whole camera paths.

use super::light_tracing::{DEPTH, POWER, REFLECTANCE, SIZE, ball_scene_builder, landing_flux};
use crate::support::*;
use caustica::camera::{Camera, Filter, FilterKind, Lens};
use caustica::integrate::{Algorithm, Settings};
use caustica::scene::{Material, Scene, SceneBuilder};
use caustica::shape::{Rectangle, Shape, Sphere};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Edge of an orthographic film \[length].
const FILM: f64 = 0.4;

/// Renders passes, and returns the mean over all pixels of each pass.
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
            Settings {
                allows_ray_photon_balance: false,
                allows_prefix_rays: prefix_rays,
                ..camera_ray_settings(4, 100)
            },
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
/// The caustic has a sharp focus. The mean of the picture is the caustic's flux in closed form.
#[test]
#[ignore = "long: statistics against a closed form"]
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
        allows_ray_photon_balance: false,
        aimed_paths: 20_000,
        gather_k: Some(0),
        initial_gather_radius: Some(0.02),
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

/// Renders `scene` with prefix rays and the pixel filter `filter`, and compares the mean of the
/// picture with `expected`, up to the relative tolerance `slack`.
///
/// The lamp's image covers less than 1/15 of a pixel, so 400 camera rays alone would have a
/// standard error above 20 % or meet no light. Aimed prefix rays must bring it below 2 %.
fn check_aimed_rays(scene: &Scene, filter: FilterKind, expected: f64, slack: f64) {
    let mut settings = Settings { allows_ray_photon_balance: false, ..camera_ray_settings(4, 100) };
    settings.camera_paths.filter = Filter::new(filter);
    let means = picture_means(scene, settings, 100);
    assert_mean(&format!("aimed prefix rays, {filter:?}"), &means, expected, slack * expected, 0.02);
}

/// A lamp in a mirror ball keeps its light.
///
/// A ball of radius R reflects parallel rays evenly, so the image of a lamp of solid angle Ω has
/// the area R²Ω/4. The distance of the lamp, 1000 R, changes this by about 10⁻³.
#[test]
fn aimed_rays_keep_lamps_seen_in_mirror_balls() {
    let (distance, lamp_radius, film) = (1000.0, 4.0, 2.2);
    let mut b = SceneBuilder::new();
    let mirror = b.add_material(Material::mirror(grey(1.0)));
    let lamp = b.add_material(Material::black());
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), mirror, grey(0.0));
    let towards_lamp = dvec3(3f64.sqrt(), 0.3, 1.0).normalize();
    b.add_shape(Shape::Sphere(Sphere::new(towards_lamp * distance, lamp_radius)), lamp, grey(1e4));
    let camera = Camera::orthographic(DVec3::Z * 4.0, DVec3::NEG_Z, DVec3::Y, film, SIZE, SIZE).unwrap();
    let sine = lamp_radius / distance;
    let solid_angle = 2.0 * PI * (1.0 - (1.0 - sine * sine).sqrt());
    check_aimed_rays(&b.build(camera).unwrap(), FilterKind::Box, 1e4 * 0.25 * solid_angle / (film * film), 2e-3);
}

/// A lamp behind a glass ball keeps its light.
///
/// The camera, the ball's center and the lamp lie on one line. So a ray at distance h from this
/// line stays in a plane, in which Snell's law gives its way. The quadrature over h has a relative
/// error below 10⁻⁷.
#[test]
fn aimed_rays_keep_lamps_seen_through_glass_balls() {
    const IOR: f64 = 1.5;
    let (distance, lamp_radius) = (200.0, 0.3);
    let mut b = SceneBuilder::new();
    let glass = b.add_material(Material::dielectric(IOR as f32, grey(0.0)));
    let lamp = b.add_material(Material::black());
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), glass, grey(0.0));
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::NEG_Z * distance, lamp_radius)), lamp, grey(1e4));
    let eye = dvec3(0.0031, 0.0017, 4.0);
    let camera = Camera::orthographic(eye, DVec3::NEG_Z, DVec3::Y, FILM, SIZE, SIZE).unwrap();
    // Fraction of the light of the lamp that a ray at distance h from the axis receives.
    let received = |h: f64| {
        let (outside, inside) = (libm::asin(h), libm::asin(h / IOR));
        let reflectance = fresnel_reflectance((1.0 - h * h).sqrt(), IOR);
        let after = |reflections: i32| {
            // Angles in the plane of the ray, from the direction towards the camera.
            let exit = outside + f64::from(reflections + 1) * (PI - 2.0 * inside);
            let direction = DVec2::new(libm::sin(exit + outside), libm::cos(exit + outside));
            let to_lamp = DVec2::new(-libm::sin(exit), -distance - libm::cos(exit));
            let hits = to_lamp.dot(direction) > 0.0 && to_lamp.perp_dot(direction).abs() < lamp_radius;
            let transmittance = 1.0 - reflectance;
            let reflected: f64 = (0..reflections).map(|_| reflectance).product();
            if hits { transmittance * transmittance * reflected } else { 0.0 }
        };
        (0..6).map(after).sum::<f64>()
    };
    let ring = |h: f64| 2.0 * PI * h * received(h);
    let expected = 1e4 * midpoint_integral(0.0, 0.5 * FILM, 1_000_000, ring) / (FILM * FILM);
    check_aimed_rays(&b.build(camera).unwrap(), FilterKind::Box, expected, 0.0);
}

/// A lamp out of focus in a flat mirror keeps its light, for filters that are wider than a pixel or
/// negative somewhere.
///
/// The values of a tent or of Mitchell's filter at all pixels add up to 1. So the mean of the
/// picture is the radiance of the lamp times its fraction of the film. The lamp is seen at up to
/// 2.4 degrees from the viewing axis, which changes its size on the film by less than .3 %.
#[test]
fn aimed_rays_keep_light_with_lenses_and_filters() {
    let (angle, distance, lamp_radius) = (0.2f64, 6.0, 0.004);
    let mut b = SceneBuilder::new();
    let mirror = b.add_material(Material::mirror(grey(1.0)));
    let lamp = b.add_material(Material::black());
    let corner = dvec3(-1.0, -1.0, -2.5);
    b.add_shape(Shape::Rectangle(Rectangle::new(corner, DVec3::X * 2.0, DVec3::Y * 2.0)), mirror, grey(0.0));
    // The mirror shows the lamp at distance 6.
    b.add_shape(Shape::Sphere(Sphere::new(dvec3(0.21, 0.13, 1.0), lamp_radius)), lamp, grey(1e4));
    let camera = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, angle, SIZE, SIZE).unwrap();
    let scene = b.build(camera.with_lens(Lens { radius: 0.01, focus_distance: 2.0, blades: 0 })).unwrap();
    let film = 2.0 * libm::tan(0.5 * angle);
    let image_radius = lamp_radius / distance / film;
    let expected = 1e4 * PI * image_radius * image_radius;
    for filter in [FilterKind::Box, FilterKind::Tent, FilterKind::Mitchell] {
        check_aimed_rays(&scene, filter, expected, 3e-3);
    }
}

/// Aimed rays give each pixel near a point image of a lamp the value of Mitchell's filter there.
///
/// The filter is negative in the outer pixels. The mean over the picture cannot reveal a wrong sign
/// of the filter, because filter values at all pixels add up to 1. The lamp is seen by an
/// orthographic camera in a flat mirror, as a disc of radius r = .02 pixels.
///
/// The tolerance has two parts. The mean of the filter over the disc differs from the value at its
/// center by r²/8 times the Laplacian; along an axis, |f| ≤ 8/9 and |f''| ≤ 4. And the tabulated
/// filter is constant between quantiles, so it differs from f by at most the variation of f over
/// one cell of the table.
#[test]
fn aimed_rays_give_each_pixel_its_filter_value() {
    let pixel = FILM / f64::from(SIZE);
    let (right, up) = (0.2, 0.35);
    let radius = 0.02;
    let mut b = SceneBuilder::new();
    let mirror = b.add_material(Material::mirror(grey(1.0)));
    let lamp = b.add_material(Material::black());
    let corner = dvec3(-1.0, -1.0, 0.0);
    b.add_shape(Shape::Rectangle(Rectangle::new(corner, DVec3::X * 2.0, DVec3::Y * 2.0)), mirror, grey(0.0));
    let center = dvec3(right * pixel, up * pixel, 8.0);
    b.add_shape(Shape::Sphere(Sphere::new(center, radius * pixel)), lamp, grey(1e4));
    let camera = Camera::orthographic(DVec3::Z * 4.0, DVec3::NEG_Z, DVec3::Y, FILM, SIZE, SIZE).unwrap();
    let scene = b.build(camera).unwrap();
    let mut settings = Settings { allows_ray_photon_balance: false, ..camera_ray_settings(4, 100) };
    settings.camera_paths.filter = Filter::new(FilterKind::Mitchell);
    let integrator = Algorithm::Hybrid.prepare(&scene, settings);
    let pictures: Vec<_> = (0..200).map(|pass| render_one_pass(&*integrator, pass)).collect();

    let unnormalized = |x: f64| FilterKind::Mitchell.unnormalized_axis_value(x);
    let integral = midpoint_integral(-2.0, 2.0, 100_000, unnormalized);
    let filter = |x: f64| unnormalized(x) / integral;
    // A cell of the table of 1024 quantiles is ∫|f|/(1024 |f|) wide. With |f| taken at `x`, the
    // formula is off by a factor of 2 at most, as long as |f| in the cell is above half of |f(x)|.
    let absolute_integral = midpoint_integral(-2.0, 2.0, 100_000, |x| filter(x).abs());
    let table_error = |x: f64| {
        let cell = 2.0 * absolute_integral / (1024.0 * filter(x).abs());
        let steps = || (-20..=20).map(|i| f64::from(i) / 20.0);
        let in_disc = steps().map(|s| x + s * radius);
        in_disc.flat_map(|x| steps().map(move |t| (x, x + t * cell))).fold(0.0f64, |error, (x, y)| {
            assert!(filter(y).abs() >= 0.5 * filter(x).abs(), "the filter varies too much around {x}");
            error.max((filter(y) - filter(x)).abs())
        })
    };
    let light = 1e4 * PI * radius * radius;
    let disc_error = radius * radius / 8.0 * 2.0 * 4.0 * 8.0 / 9.0;
    let mut negative_pixels = 0;
    for row in -2..2 {
        for column in -2..2 {
            // The image stands `right` and `up` of the corner between the four middle pixels.
            let (dx, dy) = (right - f64::from(column) - 0.5, -up - f64::from(row) - 0.5);
            let expected = light * filter(dx) * filter(dy);
            if expected.abs() < 0.02 * light {
                continue;
            }
            negative_pixels += u32::from(expected < 0.0);
            let half = SIZE as i32 / 2;
            let index = (half + row) * SIZE as i32 + half + column;
            let samples: Vec<f64> = pictures.iter().map(|picture| f64::from(picture[index as usize].x)).collect();
            let (x_error, y_error) = (table_error(dx), table_error(dy));
            let product_error = x_error * filter(dy).abs() + y_error * filter(dx).abs() + x_error * y_error;
            let slack = light * (product_error + disc_error);
            // A wrong sign changes the value by twice its magnitude.
            assert!(slack < 0.5 * expected.abs(), "{slack} of {expected}");
            assert_mean(&format!("pixel ({column}, {row})"), &samples, expected, slack, 0.05);
        }
    }
    assert!(negative_pixels > 0);
}
