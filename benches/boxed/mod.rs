//! A closed Cornell box with a glass ball and a mirror ball, lit by a square light in the ceiling.

use caustica::camera::Camera;
use caustica::scene::{Material, Scene, SceneBuilder};
use caustica::shape::{Rectangle, Shape, Sphere};
use glam::{DVec3, Vec3};

/// Returns the scene with an image of 256 × 256 pixels.
pub fn scene() -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.add_material(Material::diffuse(Vec3::splat(0.75)));
    let red = builder.add_material(Material::diffuse(Vec3::new(0.65, 0.08, 0.08)));
    let green = builder.add_material(Material::diffuse(Vec3::new(0.1, 0.5, 0.12)));
    let black = builder.add_material(Material::black());
    let glass = builder.add_material(Material::dielectric(1.5, Vec3::ZERO));
    let mirror = builder.add_material(Material::mirror(Vec3::splat(0.95)));
    let v = DVec3::new;
    let mut wall = |corner, e0, e1, material, emission| {
        builder.add_shape(Shape::Rectangle(Rectangle::new(corner, e0, e1)), material, Vec3::splat(emission));
    };
    let (x, y, z) = (v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), v(0.0, 0.0, 4.0));
    wall(v(-1.0, 0.0, -1.0), z, x, white, 0.0);
    wall(v(-1.0, 2.0, -1.0), x, z, white, 0.0);
    wall(v(-1.0, 0.0, -1.0), x, y, white, 0.0);
    wall(v(-1.0, 0.0, 3.0), y, x, white, 0.0);
    wall(v(-1.0, 0.0, -1.0), y, z, red, 0.0);
    wall(v(1.0, 0.0, -1.0), z, y, green, 0.0);
    wall(v(-0.15, 1.98, -0.15), x * 0.15, z * 0.075, black, 60.0);
    builder.add_shape(Shape::Sphere(Sphere::new(v(0.4, 0.45, 0.2), 0.35)), glass, Vec3::ZERO);
    builder.add_shape(Shape::Sphere(Sphere::new(v(-0.4, 0.4, -0.35), 0.4)), mirror, Vec3::ZERO);
    let eye = v(0.0, 1.1, 2.9);
    let camera = Camera::perspective(eye, v(0.0, 0.85, 0.0) - eye, DVec3::Y, 50f64.to_radians(), 256, 256).unwrap();
    builder.build(camera).unwrap()
}
