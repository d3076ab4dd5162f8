//! Light under water: radiance is scaled by n², and flux is conserved.

use crate::support::*;
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::scene::{Body, Material, Scene, SceneBuilder};
use caustica::shape::{Plane, Rectangle, Shape, Sphere};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const N: f64 = 1.333;
const SKY: f64 = 3.0;

/// Builds an infinite pool of depth 1 under an infinite sky.
///
/// A black ceiling emits the sky's light, and perfect mirrors stand around the pool.
fn pool_scene(albedo: f64, eye: DVec3, at: DVec3) -> Scene {
    let mut b = SceneBuilder::new();
    let floor = b.add_material(Material::diffuse(grey(albedo)));
    let black = b.add_material(Material::black());
    let mirror = b.add_material(Material::mirror(Vec3::ONE));
    let water = b.add_material(Material::dielectric(N as f32, Vec3::ZERO));
    for (i, face) in box_faces(dvec3(-1.0, -1.0, -1.0), dvec3(1.0, 0.5, 1.0), true).into_iter().enumerate() {
        let (material, light) = match i {
            0 => (floor, 0.0),
            1 => (black, SKY),
            _ => (mirror, 0.0),
        };
        b.add_shape(face, material, grey(light));
    }
    let surface = Rectangle::new(dvec3(-1.0, 0.0, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0);
    b.add_shape(Shape::Rectangle(surface), water, Vec3::ZERO);
    b.build(square_camera(eye, at, 30.0, 10)).unwrap()
}

/// Returns the irradiance of the pool's floor with the albedo ρ = `albedo`.
///
/// Let L be the sky's radiance, and Fe the hemispherical reflectance of the water from outside. The
/// floor first receives πL(1 − Fe). Floor and water surface then exchange light, with the internal
/// reflectance Fi = 1 − (1 − Fe)/n². The sum is πL(1 − Fe)/(1 − ρFi).
fn irradiance_of_floor(albedo: f64) -> f64 {
    let outer = hemispherical_reflectance(N);
    let inner = 1.0 - (1.0 - outer) / (N * N);
    // Quadrature confirms the relation between Fi and Fe. With m steps, the square root at the
    // critical angle causes an error of O(m⁻¹·⁵).
    assert!((inner - hemispherical_reflectance(1.0 / N)).abs() < 1e-6);
    PI * SKY * (1.0 - outer) / (1.0 - albedo * inner)
}

#[test]
fn flux_is_conserved_under_water() {
    let albedo = 0.7;
    let scene = pool_scene(albedo, DVec3::ZERO, DVec3::Z);
    // One ray in a million may pass between two rectangles that touch at the water's edge.
    for (name, mask, expected) in [
        ("first", StoreMask::CAUSTIC, PI * SKY * (1.0 - hemispherical_reflectance(N))),
        ("all", StoreMask::ALL, irradiance_of_floor(albedo)),
    ] {
        let passes = trace_photon_passes(&scene, mask, 10_000, PASSES, 1 << 15);
        let samples: Vec<f64> =
            passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, |_| true).x / 4.0).collect();
        assert_mean(
            &format!("{name} flux under water"),
            &samples,
            expected,
            expected * (1e-5 + STORED_COLOR_ROUNDING),
            4e-3,
        );
    }
}

/// Radiance is scaled by n² at the surface of a pool.
///
/// A camera that looks down sees R·L of the sky, and (1 − R)/n² of the floor's ρE/π. A camera that
/// looks up from the floor sees n²(1 − R)·L of the sky, and R of the floor's ρE/π. The expected
/// mean over the view is a quadrature over the pixels' angles.
#[test]
#[ignore = "long: t-tests over many bounces"]
fn radiance_scales_by_squared_index_under_water() {
    let albedo = 0.7;
    let down = pool_scene(albedo, dvec3(0.0, 0.4, 0.0), -DVec3::Y);
    let mean_reflectance = view_average(|cos| fresnel_reflectance(cos, N));
    let floor = albedo / PI * irradiance_of_floor(albedo) / (N * N);
    let expected = mean_reflectance * SKY + (1.0 - mean_reflectance) * floor;
    let settings = caustica::integrate::Settings {
        camera_paths: camera_ray_settings(2, 1000).camera_paths,
        ..fixed_radius_settings(1 << 16, 1 << 16, 0.3)
    };
    assert_mean(
        "looking into a pool",
        &red_channels(&mean_radiance_per_pass(&down, settings.clone(), PASSES)),
        expected,
        expected * 1e-4,
        5e-3,
    );

    let up = pool_scene(albedo, dvec3(0.0, -0.9, 0.0), DVec3::Y);
    // The corners of the view are at 21°, where there is no total reflection. Reflected rays show
    // the floor.
    let through = view_average(|cos| 1.0 - fresnel_reflectance(cos, 1.0 / N));
    let expected = through * N * N * SKY + (1.0 - through) * floor * N * N;
    assert_mean(
        "looking out of a pool",
        &red_channels(&mean_radiance_per_pass(&up, settings, PASSES)),
        expected,
        expected * 1e-4,
        2e-3,
    );
}

/// Returns the mean of `f`(cosθ) over a square view of 30°, where θ is the angle to its axis.
fn view_average(f: impl Fn(f64) -> f64) -> f64 {
    let half = libm::tan(15f64.to_radians());
    let row = |y: f64| midpoint_integral(-half, half, 200, |x| f(1.0 / (1.0 + x * x + y * y).sqrt()));
    midpoint_integral(-half, half, 200, row) / (4.0 * half * half)
}

/// A spherical lamp is half under black water, inside a large dome. Three eighths of its flux reach
/// the dome.
///
/// Let μ be the cosine of the angle between the lamp's normal and the vertical. Only the upper half
/// sends light to the dome. A point of it sends the fraction (1 + μ)/2 of its flux upwards, and the
/// mean of this fraction is 3/4. Two effects are negligible. Rays that fall slightly can reach the
/// dome before the water; they carry about 10⁻⁵ of the flux, because the dome has 10⁴ times the
/// radius of the lamp. And less than 10⁻⁴ of the flux leaves the lower half through the water,
/// because the water has an optical depth of 10⁴ per radius of the lamp.
#[test]
fn half_submerged_lamp_emits_three_eighths() {
    let mut b = SceneBuilder::new();
    let black = b.add_material(Material::black());
    let dome = b.add_material(Material::diffuse(Vec3::ZERO));
    let water = Body { absorption: Vec3::splat(1e4), is_null_interface: true, ..Body::new(1.0) };
    let water = b.add_material(Material::smooth_boundary(water));
    b.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), water, Vec3::ZERO);
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), black, Vec3::ONE);
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1e4)), dome, Vec3::ZERO);
    let scene = b.build(square_camera(DVec3::Y * 5.0, DVec3::ZERO, 30.0, 4)).unwrap();
    let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: 0 };
    let fraction = |i| {
        let audit = tracer.trace(test_key(70).child_key(i), 1 << 11, &|_| {}).audit;
        audit.stopped[0] / audit.emitted[0]
    };
    assert_mean("flux above water", &(0..16).map(fraction).collect::<Vec<_>>(), 0.375, 1e-4, 0.01);
}
