//! Emission from directional lights.

use super::*;
use crate::camera::Camera;
use crate::photon::{PhotonPass, StoreMask};
use crate::scene::{DeltaLightKind, LightStrength, Material, SceneBuilder};
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
    builder.add_delta_light(DeltaLightKind::Directional { direction }, LightStrength::Physical(Rgb::ONE));
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
    builder.add_delta_light(DeltaLightKind::Directional { direction }, LightStrength::Physical(Rgb::ONE));
    let eye = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap();
    let scene = builder.build(eye).unwrap();
    // As far as the farther plane, with room.
    assert!(scene.photon_domain().radius >= 3.0);
    let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
    let pass = PhotonPass { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: 0 };
    let photons = pass.trace(Key::new(1), 4096, &|_| {}).deposits.photons;
    let on = |axis: usize, at: f32| photons.iter().any(|p| (p.position[axis] - at).abs() < 1e-3);
    assert!(on(1, -1.0) && on(2, -3.0));
}

#[test]
fn distant_planes_shadow_parallel_light() {
    for (height, shaded) in [(1.0, true), (100.0, true), (1e6, true), (-1.0, false)] {
        let scene = sun_over_ball_scene(height);
        let source = PhotonSource::emitting_in_all_directions(&scene).unwrap();
        let pass = PhotonPass { scene: &scene, source: &source, mask: StoreMask::ALL, max_bounces: 0 };
        let photons = pass.trace(Key::new(1), 4096, &|_| {}).deposits.photons;
        let on_ball = photons.iter().filter(|p| p.position.length() < 0.6).count();
        assert_eq!(on_ball == 0, shaded, "{on_ball} of {} under a plane at {height}", photons.len());
        assert!(!photons.is_empty());
    }
}
