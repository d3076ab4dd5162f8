//! Tests of cameras.

use super::*;
use glam::{DAffine3, Vec3};

fn wide_angle_camera() -> Camera {
    Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 90f64.to_radians(), 400, 200).unwrap()
}

fn assert_ray_direction(camera: &Camera, p: Vec2, d: Vec3) {
    let direction = camera.generate_ray(p, None).direction;
    assert!((direction - d.normalize()).length() < 1e-6, "{p}: {direction}");
}

#[test]
fn camera_angle_is_vertical_and_rows_start_at_the_top() {
    let c = wide_angle_camera();
    assert_ray_direction(&c, Vec2::new(200.0, 100.0), Vec3::NEG_Z);
    assert_ray_direction(&c, Vec2::new(200.0, 0.0), Vec3::new(0.0, 1.0, -1.0));
    assert_ray_direction(&c, Vec2::new(400.0, 100.0), Vec3::new(2.0, 0.0, -1.0));
}

#[test]
fn parallel_up_vector_is_an_error() {
    let make = |d, up| Camera::perspective(DVec3::ZERO, d, up, 1.0, 4, 4);
    assert_eq!(make(DVec3::Y, DVec3::Y * 3.0), Err(DegenerateUpVector));
    assert_eq!(make(DVec3::ZERO, DVec3::Y), Err(DegenerateUpVector));
    assert!(make(DVec3::new(1e-9, 1.0, 0.0), DVec3::Y).is_ok());
}

#[test]
fn orthographic_rays_start_one_pixel_apart() {
    let c = Camera::orthographic(DVec3::Z, DVec3::NEG_Z, DVec3::Y, 2.0, 400, 200).unwrap();
    for (p, start) in [
        (Vec2::new(200.0, 100.0), Vec3::Z),
        (Vec2::new(400.0, 100.0), Vec3::new(2.0, 0.0, 1.0)),
        (Vec2::new(0.0, 0.0), Vec3::new(-2.0, 1.0, 1.0)),
    ] {
        assert_ray_direction(&c, p, Vec3::NEG_Z);
        assert_eq!(c.generate_ray(p, None).origin, start);
    }
}

#[test]
fn panorama_covers_all_directions() {
    let c = Camera::panorama(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 400, 200).unwrap();
    for (x, y, d) in [
        (200.0, 100.0, Vec3::NEG_Z),
        (300.0, 100.0, Vec3::X),
        (100.0, 100.0, Vec3::NEG_X),
        (0.0, 100.0, Vec3::Z),
        (123.0, 0.0, Vec3::Y),
        (300.0, 150.0, Vec3::new(1.0, -1.0, 0.0)),
    ] {
        assert_ray_direction(&c, Vec2::new(x, y), d);
    }
}

#[test]
fn lens_rays_converge_in_the_focal_plane() {
    let lens = Lens { radius: 0.3, focus_distance: 4.0, blades: 0 };
    let (open, shut) =
        (wide_angle_camera().with_lens(lens), wide_angle_camera().with_lens(Lens { radius: 0.0, ..lens }));
    for p in [Vec2::new(200.0, 100.0), Vec2::new(17.0, 3.0)] {
        let through_middle = wide_angle_camera().generate_ray(p, None);
        assert_eq!(open.generate_ray(p, None), through_middle);
        let in_focus = through_middle.at(4.0 / -through_middle.direction.z);
        for u in [Vec2::new(0.1, 0.9), Vec2::new(0.7, 0.3)] {
            assert_eq!(shut.generate_ray(p, Some(u)), through_middle);
            let ray = open.generate_ray(p, Some(u));
            assert!(ray.origin.length() <= 0.3 && ray.origin != Vec3::ZERO);
            assert!((ray.at(4.0 / -ray.direction.z) - in_focus).length() < 1e-5);
        }
    }
}

#[test]
fn moved_camera_starts_rays_at_its_new_position() {
    let turn = DAffine3::from_quat(glam::DQuat::from_xyzw(0.0, 0.5f64.sqrt(), 0.0, 0.5f64.sqrt()));
    let map = Transform::new(DAffine3::from_translation(DVec3::X) * turn).unwrap();
    let moved = wide_angle_camera().transformed(&map);
    assert_ray_direction(&moved, Vec2::new(200.0, 100.0), Vec3::NEG_X);
    assert_eq!(moved.center(), DVec3::X);
}

#[test]
fn smaller_pictures_show_the_same_view() {
    let camera = wide_angle_camera().with_lens(Lens { radius: 0.3, focus_distance: 4.0, blades: 0 });
    let panorama = Camera::panorama(DVec3::X, DVec3::NEG_Z, DVec3::Y, 400, 200).unwrap();
    let parallel = Camera::orthographic(DVec3::X, DVec3::NEG_Z, DVec3::Y, 3.0, 400, 200).unwrap();
    for camera in [camera, panorama, parallel] {
        let small = camera.with_size(40, 20);
        assert_eq!(small.size(), (40, 20));
        for p in [Vec2::new(200.0, 100.0), Vec2::new(10.0, 190.0)] {
            let (large, small) = (camera.generate_ray(p, None), small.generate_ray(p / 10.0, None));
            assert!((large.direction - small.direction).length() < 1e-6 && large.origin.distance(small.origin) < 1e-6);
        }
    }
}

#[test]
fn orbits_scale_focus_and_parallel_pictures() {
    let focused = wide_angle_camera().with_lens(Lens { radius: 0.3, focus_distance: 4.0, blades: 0 });
    let moved = focused.orbited(DVec3::NEG_Z * 4.0, DVec3::Y, 1.0, 0.0, 2.0);
    assert_eq!(moved.lens().unwrap().focus_distance, 8.0);
    assert!((moved.center() - (moved.forward() * -8.0 + DVec3::NEG_Z * 4.0)).length() < 1e-12);
    let parallel = Camera::orthographic(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 3.0, 300, 300).unwrap();
    let wider = parallel.orbited(DVec3::NEG_Z, DVec3::Y, 0.0, 0.0, 2.0);
    let side = wider.generate_ray(Vec2::new(300.0, 150.0), None).origin;
    assert!((side - Vec3::new(3.0, 0.0, 1.0)).length() < 1e-6, "{side}");
}

#[test]
fn disparity_of_stereo_pairs_is_distance_over_depth() {
    let (angle, distance) = (0.8f64, 0.3);
    let camera = Camera::perspective(DVec3::new(1.0, 2.0, 3.0), DVec3::NEG_Z, DVec3::Y, angle, 64, 48).unwrap();
    let [left, right] = camera.stereo_pair(distance).unwrap();
    for (depth, p) in [(2.0f64, Vec2::new(20.0, 9.0)), (7.5, Vec2::new(50.0, 30.0))] {
        let disparity = 48.0 * distance / (2.0 * depth * libm::tan(0.5 * angle));
        let shift = Vec2::new(0.5 * disparity as f32, 0.0);
        let seen = [(camera, p), (left, p + shift), (right, p - shift)].map(|(camera, p)| {
            let ray = camera.generate_ray(p, None);
            ray.origin.as_dvec3() + ray.direction.as_dvec3() * (depth / -f64::from(ray.direction.z))
        });
        assert!((seen[1] - seen[0]).length() < 1e-5, "{seen:?}");
        assert!((seen[2] - seen[0]).length() < 1e-5, "{seen:?}");
    }
    let panorama = Camera::panorama(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 64, 32).unwrap();
    assert_eq!(panorama.stereo_pair(distance), None);
}
