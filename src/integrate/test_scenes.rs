//! Scenes that several tests of this module render.

use crate::camera::Camera;
use crate::scene::{LightStrength, Material, Scene, SceneBuilder, UnscaledDeltaLight};
use crate::shape::{Plane, Shape, Sphere};
use glam::{DVec3, Vec3};

/// Returns a scene with a glass ball of radius 0.8 above a white plane, and a point light. The
/// camera at `eye` looks in the direction `forward`, and its picture has 64 × 48 pixels.
pub(super) fn glass_ball_above_plane(eye: DVec3, forward: DVec3) -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Vec3::splat(0.7)));
    let glass = builder.add_material(Material::dielectric(1.5, Vec3::ZERO));
    builder.add_plane(Plane::new(DVec3::ZERO, DVec3::Y), white, Vec3::ZERO);
    builder.add_shape(Shape::Sphere(Sphere::new(DVec3::Y, 0.8)), glass, Vec3::ZERO);
    let kind = UnscaledDeltaLight::Point { position: DVec3::new(2.0, 4.0, 1.0) };
    builder.add_delta_light(kind, LightStrength::Power(Vec3::splat(100.0)));
    builder.build(Camera::perspective(eye, forward, DVec3::Y, 0.7, 64, 48).unwrap()).unwrap()
}
