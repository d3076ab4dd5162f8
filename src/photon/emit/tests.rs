//! Emission from directional lights, and the wavelengths of photon paths.

use super::*;
use crate::camera::Camera;
use crate::color::{DispersionFormula, Wavelength};
use crate::photon::{PhotonTracer, StoreMask};
use crate::scene::{Body, LightStrength, Material, PathEvent, SceneBuilder, SpectralInterior, UnscaledDeltaLight};
use crate::shape::{Plane, Shape, Sphere};
use glam::DVec3;

/// A scene with a directional light above a ball, and a horizontal plane at `height`, which may lie
/// between light and ball.
fn sun_over_ball_scene(height: f64) -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Rgb::ONE));
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 0.5)), white, Rgb::ZERO);
    builder.add_plane(Plane::new(DVec3::Y * height, DVec3::Y), white, Rgb::ZERO);
    let direction = DVec3::new(0.3, -1.0, 0.1);
    builder.add_delta_light(UnscaledDeltaLight::Directional { direction }, LightStrength::Physical(Rgb::ONE));
    let eye = Camera::perspective(DVec3::Z * 9.0, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap();
    builder.build(eye).unwrap()
}

#[test]
fn directional_light_reaches_unbounded_planes() {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Rgb::ONE));
    builder.add_plane(Plane::new(DVec3::NEG_Y, DVec3::Y), white, Rgb::ZERO);
    builder.add_plane(Plane::new(DVec3::Z * -3.0, DVec3::Z), white, Rgb::ZERO);
    let direction = DVec3::new(0.1, -1.0, -0.5);
    builder.add_delta_light(UnscaledDeltaLight::Directional { direction }, LightStrength::Physical(Rgb::ONE));
    let eye = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap();
    let scene = builder.build(eye).unwrap();
    // The photon domain, the ball onto which lights at infinity emit photons, extends at least to
    // the farther plane.
    assert!(scene.photon_domain().radius >= 3.0);
    let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: 0 };
    let photons = tracer.trace(Key::new(1), 4096, &|_| {}).deposits.surface_photons;
    let on = |axis: usize, at: f32| photons.iter().any(|p| (p.position[axis] - at).abs() < 1e-3);
    assert!(on(1, -1.0) && on(2, -3.0));
}

#[test]
fn distant_planes_shadow_parallel_light() {
    for (height, shaded) in [(1.0, true), (100.0, true), (1e6, true), (-1.0, false)] {
        let scene = sun_over_ball_scene(height);
        let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
        let tracer = PhotonTracer { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: 0 };
        let photons = tracer.trace(Key::new(1), 4096, &|_| {}).deposits.surface_photons;
        let on_ball = photons.iter().filter(|p| p.position.length() < 0.6).count();
        assert_eq!(on_ball == 0, shaded, "{on_ball} of {} under a plane at {height}", photons.len());
        assert!(!photons.is_empty());
    }
}

/// A scene with two lamps of powers 1 : 3 inside a ball of dispersive glass.
fn lamps_in_glass_scene() -> Scene {
    let mut builder = SceneBuilder::new();
    let flint = builder.add_dispersion_formula(DispersionFormula::from_abbe_number(1.8, 25.0));
    let glass =
        builder.add_material(Material::smooth_boundary(Body { dispersion_formula: Some(flint), ..Body::new(1.8) }));
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 2.0)), glass, Rgb::ZERO);
    for (x, power) in [(-1.0, 1.0), (1.0, 3.0)] {
        let kind = UnscaledDeltaLight::Point { position: DVec3::X * x };
        builder.add_delta_light(kind, LightStrength::Physical(Rgb::splat(power)));
    }
    let eye = Camera::perspective(DVec3::Z * 9.0, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap();
    builder.build(eye).unwrap()
}

/// In each range of wavelengths, positions and directions are stratified.
///
/// The test counts the paths of each lamp in 4 cells of wavelengths times 4 × 4 cells of
/// directions, or of positions. 16 successive Sobol' points from a multiple of 16 have one point in
/// each of 4 × 4 cells. So a run of n successive points has n/16 ± 2 points in each cell. The paths
/// in one range of wavelengths are one or two runs, whose ends are off by at most one point. In
/// total, a count deviates from its expected value by at most 4.2. With independent wavelengths,
/// the standard deviations of the counts of the two lamps would be 8 and 14.
#[test]
fn wavelengths_are_stratified_with_directions_and_positions() {
    const PATHS: u32 = 1 << 14;
    let scene = lamps_in_glass_scene();
    let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    for seed in 0..4 {
        let key = Key::new(seed);
        let mut counts = [[[[0u32; 16]; 4]; 2]; 2];
        for index in 0..PATHS {
            let point = source.sample_primary_emission(key, index, PATHS);
            let (mut path, _) = source.emit_photon_path::<SpectralInterior>(key, index, PATHS).unwrap();
            let event = path.next_vertex(&scene, key.photon_path_key(index), |_| None);
            assert!(matches!(event, PathEvent::Surface(_)));
            let u = source.wavelength_sample(key, index, PATHS, point.light);
            assert_eq!(path.interior.wavelength(), Some(Wavelength::sample(u)));
            for (i, square) in [point.direction_sample, point.position_sample].into_iter().enumerate() {
                let cell = (square * 4.0).as_uvec2();
                counts[point.light][i][(u * 4.0) as usize][(cell.y * 4 + cell.x) as usize] += 1;
            }
        }
        for (counts, expected) in counts.iter().zip([64, 192]) {
            let most = counts.as_flattened().as_flattened().iter().map(|n| n.abs_diff(expected)).max().unwrap();
            assert!(most <= 4, "seed {seed}: {most} beside {expected}");
        }
    }
}
