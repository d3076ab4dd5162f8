//! Tests of the scene builder.

use super::*;
use crate::scene::Body;
use crate::shape::Sphere as Ball;

fn perspective_camera() -> Camera {
    Camera::perspective(DVec3::new(0.0, 0.0, 9.0), DVec3::NEG_Z, DVec3::Y, 1.0, 4, 3).unwrap()
}

fn add_emissive_sphere(builder: &mut SceneBuilder, center: DVec3, emission: Rgb) {
    let material = builder.add_material(Material::diffuse(Rgb::ONE));
    builder.add_shape(Shape::Sphere(Ball::new(center, 1.0)), material, emission);
}

#[test]
fn scenes_beyond_single_precision_are_refused() {
    let mut far = SceneBuilder::new();
    add_emissive_sphere(&mut far, DVec3::ZERO, Rgb::ZERO);
    add_emissive_sphere(&mut far, DVec3::new(1e15, 0.0, 0.0), Rgb::ZERO);
    assert!(matches!(far.build(perspective_camera()), Err(BuildError::ExtentTooLarge(_))));
    let mut bright = SceneBuilder::new();
    add_emissive_sphere(&mut bright, DVec3::ZERO, Rgb::splat(f32::MAX));
    assert_eq!(bright.build(perspective_camera()).err(), Some(BuildError::TooBright(0)));
    let mut source = SceneBuilder::new();
    source.add_delta_light(UnscaledDeltaLight::Point { position: DVec3::ZERO }, LightStrength::Power(Rgb::INFINITY));
    assert_eq!(source.build(perspective_camera()).err(), Some(BuildError::TooBright(0)));
}

#[test]
fn mixes_of_themselves_or_of_missing_materials_are_refused() {
    let refused = |mixes: &[(u32, u32)]| {
        let mut builder = SceneBuilder::new();
        builder.add_material(Material::black());
        mixes.iter().for_each(|&(first, second)| _ = builder.add_material(Material::mix(first, second, 0.5)));
        builder.build(perspective_camera()).err()
    };
    assert_eq!(refused(&[(0, 1)]), Some(BuildError::InvalidMix(1)));
    assert_eq!(refused(&[(0, 2), (1, 0)]), Some(BuildError::InvalidMix(1)));
    assert_eq!(refused(&[(0, 0), (1, 3)]), Some(BuildError::InvalidMix(2)));
    // Components may follow their mix.
    assert_eq!(refused(&[(2, 3), (0, 3), (0, 0)]), None);
}

#[test]
fn escaped_rays_see_the_environment_or_background() {
    let scene = |environments: &[f32]| {
        let mut builder = SceneBuilder::new();
        builder.set_background(Rgb::splat(0.5));
        for radiance in environments {
            builder.set_environment(EnvironmentLight::with_constant_radiance(Rgb::splat(*radiance)).unwrap());
        }
        add_emissive_sphere(&mut builder, DVec3::ZERO, Rgb::ONE);
        builder.build(perspective_camera()).unwrap()
    };
    let (without, with) = (scene(&[]), scene(&[2.0, 3.0]));
    assert_eq!((without.environment_light_index(), without.escaped_radiance(Vec3::X)), (None, Rgb::splat(0.5)));
    assert_eq!((with.environment_light_index(), with.escaped_radiance(Vec3::X)), (Some(1), Rgb::splat(3.0)));
    assert_eq!((with.lights().len(), with.mit_6837_lights().len()), (2, 1));
}

#[test]
fn a_scene_is_recentered_on_its_shapes() {
    let mut builder = SceneBuilder::new();
    let center = DVec3::new(1e6, 2e6, -3e6);
    add_emissive_sphere(&mut builder, center, Rgb::ZERO);
    let scene = builder.build(perspective_camera().translated(center)).unwrap();
    assert_eq!(scene.origin(), center);
    assert_eq!(scene.camera().center(), DVec3::new(0.0, 0.0, 9.0));
    assert_eq!(scene.photon_domain().center, Vec3::ZERO);
}

#[test]
fn with_camera_equals_building_with_that_camera() {
    let scene = |camera: Camera, moves: bool| {
        let mut builder = SceneBuilder::new();
        let glass = builder.add_material(Material::dielectric(1.5, Rgb::ZERO));
        builder.add_shape(Shape::Sphere(Ball::new(DVec3::new(2.0, 0.0, 0.0), 1.0)), glass, Rgb::ZERO);
        add_emissive_sphere(&mut builder, DVec3::new(-2.0, 3.0, 0.0), Rgb::ONE);
        if moves {
            builder.set_camera_motion(Motion::default());
        }
        builder.build(camera).unwrap()
    };
    let inside = Camera::perspective(DVec3::new(2.0, 0.1, 0.0), DVec3::NEG_Z, DVec3::Y, 1.0, 8, 6).unwrap();
    let outside = scene(perspective_camera(), true);
    let (moved, built) = (outside.with_camera(&inside), scene(inside, false));
    assert_eq!(moved.camera(), built.camera());
    assert_eq!(format!("{:?}", moved.derived), format!("{:?}", built.derived));
    assert_ne!(format!("{:?}", moved.derived), format!("{:?}", outside.derived), "the camera is inside of glass");
    assert!(Arc::ptr_eq(&moved.geometry.resting_hierarchy, &outside.geometry.resting_hierarchy));
    assert!(outside.has_motion() && !moved.has_motion());
    let there = moved.camera_in_description().center();
    assert!(there.distance(inside.center()) < 1e-12);
}

#[test]
fn equal_geometry_shares_its_hierarchy() {
    // A triangle with the given height, and a ball with the given radius, lit by a lamp.
    let scene = |earlier: Option<&Scene>, reflectance: f32, height: f64, radius: f64| {
        let mut builder = SceneBuilder::new();
        add_emissive_sphere(&mut builder, DVec3::new(0.0, 5.0, 0.0), Rgb::ONE);
        let white = builder.add_material(Material::diffuse(Rgb::splat(reflectance)));
        builder.add_shape(Shape::Sphere(Ball::new(DVec3::Y * 2.0, radius)), white, Rgb::ZERO);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.0, height, 0.0)];
        builder.add_mesh(&corners, &[], &[[0, 1, 2]], white, Rgb::ZERO);
        builder.build_reusing_hierarchy(earlier, perspective_camera()).unwrap()
    };
    let first = scene(None, 0.5, 1.0, 0.5);
    let shares = |next: &Scene| Arc::ptr_eq(&next.geometry.resting_hierarchy, &first.geometry.resting_hierarchy);
    let recolored = scene(Some(&first), 0.7, 1.0, 0.5);
    assert!(shares(&recolored) && recolored.geometry.bounds() == first.geometry.bounds());
    assert!(!shares(&scene(None, 0.5, 1.0, 0.5)));
    // Move one corner, or grow one box, by a single step of f32. The bounds of the scene stay the
    // same.
    let up = |x: f64| f64::from((x as f32).next_up());
    let (moved, grown) = (scene(Some(&first), 0.5, up(1.0), 0.5), scene(Some(&first), 0.5, 1.0, up(0.5)));
    assert!(!shares(&moved) && !shares(&grown));
    assert_ne!(moved.geometry.mesh.corners(0), first.geometry.mesh.corners(0));
    assert_eq!(grown.geometry.mesh.corners(0), first.geometry.mesh.corners(0));
}

#[test]
fn null_interface_materials_without_objects_do_not_count() {
    let is_crossed = |object: u32| {
        let mut builder = SceneBuilder::new();
        builder.add_material(Material::smooth_boundary(Body { is_null_interface: true, ..Body::new(1.0) }));
        builder.add_material(Material::diffuse(Rgb::ONE));
        builder.add_material(Material::mix(0, 1, 0.5));
        builder.add_shape(Shape::Sphere(Ball::new(DVec3::ZERO, 1.0)), object, Rgb::ZERO);
        builder.build(perspective_camera()).unwrap().shadow_rays_cross_surfaces()
    };
    assert_eq!([0, 1, 2].map(is_crossed), [true, false, true]);
}

#[test]
fn lamps_are_flagged_only_where_boundaries_cross_them() {
    let is_flagged = |height: f64, ball_radius: f64| {
        let mut builder = SceneBuilder::new();
        let glass = builder.add_material(Material::dielectric(1.5, Rgb::ZERO));
        builder.add_shape(Shape::Sphere(Ball::new(DVec3::ZERO, ball_radius)), glass, Rgb::ZERO);
        let corners = [DVec3::new(-9.0, height, -9.0), DVec3::new(0.0, height, 9.0), DVec3::new(9.0, height, -9.0)];
        builder.add_mesh(&corners, &[], &[[0, 1, 2]], glass, Rgb::ZERO);
        add_emissive_sphere(&mut builder, DVec3::ZERO, Rgb::ONE);
        builder.build(perspective_camera()).unwrap().derived.lights_across_boundaries == [true]
    };
    // The corners of the box around the lamp lie at the distance √3 from its center.
    assert_eq!([is_flagged(2.0, 1.8), is_flagged(2.0, 1.5), is_flagged(0.5, 1.8)], [false, true, true]);
}
