//! Tests that connections of points to the film agree with camera rays.

use super::super::Lens;
use super::*;

fn cameras_of_all_kinds() -> [Camera; 4] {
    let (center, direction, up) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-0.3, -0.2, -1.0), DVec3::Y);
    let perspective = Camera::perspective(center, direction, up, 1.1, 64, 48).unwrap();
    [
        perspective,
        perspective.with_lens(Lens { radius: 0.2, focus_distance: 4.0, blades: 6 }),
        Camera::orthographic(center, direction, up, 5.0, 64, 48).unwrap(),
        Camera::panorama(center, direction, up, 64, 48).unwrap(),
    ]
}

/// Checks that a point on a camera ray connects to the film position and the origin of that ray.
#[test]
fn connections_invert_camera_rays() {
    for camera in cameras_of_all_kinds() {
        for (film, lens, t) in [
            (Vec2::new(3.0, 40.5), Vec2::new(0.1, 0.7), 0.6),
            (Vec2::new(32.0, 24.0), Vec2::new(0.9, 0.2), 5.0),
            (Vec2::new(60.25, 1.5), Vec2::new(0.5, 0.5), 40.0),
        ] {
            let ray = camera.generate_ray(film, Some(lens));
            let found = camera.connect_to_point(ray.at(t), Some(lens)).unwrap();
            assert!((found.film_position - film).length() < 2e-4, "{found:?}");
            assert!((found.direction_to_camera + ray.direction).length() < 1e-5, "{found:?}");
            assert!((found.ray_origin - ray.origin).length() < 1e-5, "{found:?}");
        }
    }
}

/// Compares the importance of a connection with the Jacobian of the film position, by finite
/// differences perpendicular to the ray.
#[test]
fn camera_importance_is_the_film_jacobian() {
    for camera in cameras_of_all_kinds() {
        for film in [Vec2::new(5.0, 40.0), Vec2::new(32.0, 24.0), Vec2::new(50.0, 7.0)] {
            let lens = Some(Vec2::new(0.3, 0.6));
            let ray = camera.generate_ray(film, lens);
            let p = ray.at(3.0);
            let (s, t) = ray.direction.any_orthonormal_pair();
            let step = 0.01;
            let at = |v: Vec3| camera.connect_to_point(p + v, lens).unwrap().film_position;
            let along = |v: Vec3| (at(v * step) - at(v * -step)) / (2.0 * step);
            let area = along(s).perp_dot(along(t)).abs();
            let importance = camera.connect_to_point(p, lens).unwrap().importance;
            assert!((area / importance - 1.0).abs() < 2e-3, "{area} {importance}");
        }
    }
}

/// Only in a panorama do other film positions have the same ray: one more near an edge of the film,
/// two or more near a corner.
#[test]
fn other_film_positions_have_the_same_ray() {
    for camera in cameras_of_all_kinds() {
        for (x, y, count) in [
            (32.0, 24.0, 0),
            (0.25, 30.0, 1),
            (63.0, 9.0, 1),
            (9.0, 0.5, 1),
            (9.0, 47.5, 1),
            (0.25, 0.5, 2),
            (31.5, 47.5, 2),
        ] {
            let ray = camera.generate_ray(Vec2::new(x, y), None);
            let mut found = 0;
            camera.for_each_other_film_position(Vec2::new(x, y), 1.5, |other| {
                found += 1;
                let direction = camera.generate_ray(other, None).direction;
                assert!((direction - ray.direction).length() < 1e-5, "{x}, {y}: {other}");
            });
            assert_eq!(found, if camera.projection == CameraProjection::Panorama { count } else { 0 }, "{x}, {y}");
        }
    }
}

#[test]
fn points_behind_the_camera_do_not_connect() {
    let [pinhole, lens, orthographic, panorama] = cameras_of_all_kinds();
    let behind = pinhole.generate_ray(Vec2::new(32.0, 24.0), None).at(-2.0);
    for camera in [pinhole, lens, orthographic] {
        assert_eq!(camera.connect_to_point(behind, Some(Vec2::splat(0.5))), None);
    }
    assert!(panorama.connect_to_point(behind, None).is_some());
    assert_eq!(panorama.connect_to_point(panorama.center().as_vec3(), None), None);
}
