//! Cameras inside glass, and bodies that overlap by priority.

use crate::support::{assert_mean, render_passes};
use caustica::camera::Camera;
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use caustica::light::EnvironmentLight;
use caustica::scene::{Body, Material, Scene, SceneBuilder};
use caustica::shape::{Plane, Shape, Sphere};
use glam::{DVec3, Vec3};

/// Returns the mean radiance of each of several independent renders.
fn mean_radiances(scene: &Scene, renders: u64) -> Vec<f64> {
    let one = |seed| {
        let camera_paths =
            CameraPathSettings { samples_per_pixel: Some(4), max_bounces: 1000, seed, ..CameraPathSettings::default() };
        let image = render_passes(scene, Algorithm::Path, Settings { camera_paths, ..Settings::default() }, 1);
        image.iter().map(|p| f64::from(p.x)).sum::<f64>() / image.len() as f64
    };
    (0..renders).map(one).collect()
}

fn narrow_camera(center: DVec3, direction: DVec3, angle: f64) -> Camera {
    Camera::perspective(center, direction, DVec3::Z, angle, 4, 4).unwrap()
}

/// From below a surface of index n, the sky is seen within Snell's window.
///
/// Under a sky of radiance 1, its radiance is n²(1 − R). Beyond the critical angle, only the black
/// bottom is seen.
#[test]
#[ignore = "long: many samples of a hard case"]
fn sky_is_seen_through_snells_window() {
    for n in [0.6f64, 1.33, 1.5, 3.0] {
        let critical = if n > 1.0 { libm::asin(1.0 / n) } else { 1.6 };
        for part in [0.0, 0.3, 0.7, 0.95, 0.999, 1.001, 1.2] {
            let angle = part * critical;
            if angle > 1.5 {
                continue;
            }
            let mut b = SceneBuilder::new();
            let body = b.add_material(Material::dielectric(n as f32, Vec3::ZERO));
            let black = b.add_material(Material::black());
            b.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), body, Vec3::ZERO);
            b.add_plane(Plane::new(DVec3::NEG_Y * 2.0, DVec3::Y), black, Vec3::ZERO);
            b.set_environment(EnvironmentLight::with_constant_radiance(Vec3::ONE).unwrap());
            let direction = DVec3::new(libm::sin(angle), libm::cos(angle), 0.0);
            let scene = b.build(narrow_camera(DVec3::NEG_Y, direction, 1e-6)).unwrap();
            let (sin_t, cos) = (n * libm::sin(angle), libm::cos(angle));
            let expected = if sin_t >= 1.0 {
                0.0
            } else {
                let cos_t = (1.0 - sin_t * sin_t).sqrt();
                let (rs, rp) = ((n * cos - cos_t) / (n * cos + cos_t), (cos - n * cos_t) / (cos + n * cos_t));
                n * n * (1.0 - 0.5 * (rs * rs + rp * rp))
            };
            let samples = mean_radiances(&scene, 1);
            // Directions have an error of 10⁻⁶ from the camera's angle. The derivative dT/dθ is at
            // most 4n²·tanθt, which is below 23 at the fraction 0.999.
            assert!(
                (samples[0] - expected).abs() < 1e-6 * 4.0 * n * n * 30.0 + 1e-6,
                "{n} {part}: {samples:?} {expected}"
            );
        }
    }
}

/// Inside a glass ball, the radiance of the sky is multiplied by n² in every direction.
///
/// The camera is less than 1/n of the radius from the center, so no ray is totally reflected.
#[test]
#[ignore = "long: many samples of a hard case"]
fn radiance_in_glass_scales_by_squared_index() {
    for (n, off) in [(1.5f64, 0.6), (1.1, 0.85), (0.7, 0.99), (2.4, 0.4)] {
        let mut b = SceneBuilder::new();
        let glass = b.add_material(Material::dielectric(n as f32, Vec3::ZERO));
        b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), glass, Vec3::ZERO);
        b.set_environment(EnvironmentLight::with_constant_radiance(Vec3::ONE).unwrap());
        let camera = Camera::panorama(DVec3::X * off, DVec3::NEG_Z, DVec3::Y, 16, 8).unwrap();
        let samples = mean_radiances(&b.build(camera).unwrap(), 16);
        // Each of about ten interfaces rounds reflectance and squared index by 2⁻²³. After a
        // thousand bounces, 10⁻⁹ of the light is left.
        assert_mean(&format!("inside of {n}"), &samples, n * n, n * n * 20.0 * f64::from(f32::EPSILON), 0.01);
    }
}

/// Overlapping balls resolve by priority: a camera sees radiance multiplied by n² of the body
/// around it.
///
/// That is the body with the higher priority at the camera's position. Radiance over n² is
/// invariant along a ray.
#[test]
#[ignore = "long: many samples of a hard case"]
fn overlapping_bodies_resolve_by_priority() {
    let scene = |priorities: [u8; 2], at: f64, order: bool| {
        let mut b = SceneBuilder::new();
        let mut balls = [(1.5f32, -0.3, priorities[0]), (1.2, 0.3, priorities[1])];
        if order {
            balls.reverse();
        }
        for (n, x, priority) in balls {
            let material = b.add_material(Material::smooth_boundary(Body { priority, ..Body::new(n) }));
            b.add_shape(Shape::Sphere(Sphere::new(DVec3::X * x, 0.6)), material, Vec3::ZERO);
        }
        b.set_environment(EnvironmentLight::with_constant_radiance(Vec3::ONE).unwrap());
        // The camera looks perpendicular to the row of balls, where light can leave.
        b.build(narrow_camera(DVec3::new(at, 0.0, 0.0), DVec3::Y, 0.3)).unwrap()
    };
    for (priorities, at, n) in [
        ([1, 0], -0.6, 1.5f64),
        ([1, 0], 0.0, 1.5),
        ([1, 0], 0.6, 1.2),
        ([0, 1], -0.6, 1.5),
        ([0, 1], 0.0, 1.2),
        ([0, 1], 0.6, 1.2),
    ] {
        for order in [false, true] {
            let samples = mean_radiances(&scene(priorities, at, order), 16);
            let slack = n * n * 20.0 * f64::from(f32::EPSILON);
            assert_mean(&format!("{priorities:?} at {at}"), &samples, n * n, slack, 0.01);
        }
    }
}
