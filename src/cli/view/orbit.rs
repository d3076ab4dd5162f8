//! Camera of `caustica view`, which the user moves around a point on the live page.

use crate::camera::Camera;
use crate::cli::pivot::pivot;
use crate::scene::Scene;
use crate::view::Orbit;
use glam::DVec3;

/// Smallest angle between the view direction and the up or down direction that the user can reach
/// by pitching the camera \[radians]. If the scene's own camera has a smaller angle, that angle is
/// the limit.
const MIN_POLE_ANGLE: f64 = 0.05;

/// Largest absolute value of the zoom [`Orbit::log_distance`]. The distance of the camera from the
/// pivot thus changes by a factor of at most e⁸ ≈ 3000.
const MAX_LOG_ZOOM: f64 = 8.0;

/// Returns the camera of `scene`, moved by `orbit` around the point that the center of the picture
/// shows. Returns `None` if `orbit` is zero or not finite, or if `up` is zero.
///
/// `up` is the up vector of the scene file. All coordinates are those of the scene file. Pitch is
/// limited by [`MIN_POLE_ANGLE`], and zoom by [`MAX_LOG_ZOOM`].
pub(super) fn orbited_camera(scene: &Scene, up: DVec3, orbit: Orbit) -> Option<Camera> {
    let Orbit { yaw, pitch, log_distance: zoom } = orbit;
    if orbit == Orbit::default() || ![yaw, pitch, zoom].iter().all(|number| number.is_finite()) {
        return None;
    }
    let camera = scene.camera_in_description();
    let axis = up.try_normalize()?;
    // Angle between view direction and up axis. A positive pitch raises the view, so it makes this
    // angle smaller.
    let angle = libm::acos(camera.forward().dot(axis).clamp(-1.0, 1.0));
    let (least, most) = (MIN_POLE_ANGLE.min(angle), (std::f64::consts::PI - MIN_POLE_ANGLE).max(angle));
    let pitch = angle - (angle - pitch).clamp(least, most);
    let distance = libm::exp(zoom.clamp(-MAX_LOG_ZOOM, MAX_LOG_ZOOM));
    Some(camera.orbited(pivot(scene), axis, yaw, pitch, distance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, SceneBuilder};
    use crate::shape::{Shape, Sphere};
    use glam::Vec3;

    fn ball_scene() -> Scene {
        let mut builder = SceneBuilder::new();
        let white = builder.add_material(Material::diffuse(Vec3::ONE));
        builder.add_shape(Shape::Sphere(Sphere::new(DVec3::new(3.0, 1.0, -5.0), 1.0)), white, Vec3::ZERO);
        let camera = Camera::perspective(DVec3::new(3.0, 1.0, 0.0), -DVec3::Z, DVec3::Y, 0.7, 32, 24).unwrap();
        builder.build(camera).unwrap()
    }

    #[test]
    fn orbits_keep_the_pivot_in_the_center() {
        let scene = ball_scene();
        let point = DVec3::new(3.0, 1.0, -4.0);
        for (yaw, pitch, zoom) in [(0.7, 0.0, 0.0), (0.0, -0.4, 0.5), (-2.0, 9.0, -1.0)] {
            let camera = orbited_camera(&scene, DVec3::Y * 3.0, Orbit { yaw, pitch, log_distance: zoom }).unwrap();
            let to_point = point - camera.center();
            assert!((to_point.length() - 4.0 * libm::exp(zoom)).abs() < 1e-4, "{yaw} {pitch}");
            assert!((to_point.normalize() - camera.forward()).length() < 1e-4, "{yaw} {pitch}");
            assert!(camera.forward().y.abs() < 1.0 - 1e-4, "the poles are never reached");
        }
        let right = orbited_camera(&scene, DVec3::Y, Orbit { yaw: 0.5, ..Orbit::default() }).unwrap();
        assert!(right.center().x > 3.0, "a positive yaw moves the camera to the right");
        assert_eq!(orbited_camera(&scene, DVec3::Y, Orbit::default()), None);
        assert_eq!(orbited_camera(&scene, DVec3::Y, Orbit { yaw: f64::NAN, ..Orbit::default() }), None);
    }
}
