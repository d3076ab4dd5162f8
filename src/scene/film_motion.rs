//! Motion vectors: displacement on the film of visible points while the shutter is open.

use super::animation::{camera_at_time, motion_of_hit};
use super::{Hit, Scene};
use crate::camera::Camera;
use glam::{Vec2, Vec3};

/// Measures how far a point moves on the film from the opening to the closing of the shutter.
#[derive(Clone, Copy, Debug)]
pub struct FilmMotionMeter {
    /// Camera at the opening of the shutter.
    camera_at_opening: Camera,
    /// Camera at the closing of the shutter.
    camera_at_closing: Camera,
}

impl FilmMotionMeter {
    /// Creates the meter for `scene`; `None` if nothing moves.
    #[must_use]
    pub fn new(scene: &Scene) -> Option<Self> {
        let animation = scene.animation.as_deref()?;
        let camera = |time| {
            let moved = animation.camera.as_ref().and_then(|(camera, motion)| camera_at_time(camera, motion, time));
            moved.unwrap_or(scene.camera)
        };
        Some(Self { camera_at_opening: camera(0.0), camera_at_closing: camera(1.0) })
    }

    /// Returns how far a surface point moves on the film, from the opening to the closing of the
    /// shutter \[pixels to the right and down].
    ///
    /// The point is at `p` at the time `time` in \[0, 1]. The point lies on the object of `scene`
    /// that `hit` names. Returns `None` if the point is behind the camera at the opening or the
    /// closing.
    #[must_use]
    pub fn surface_point_displacement(&self, scene: &Scene, hit: &Hit, time: f64, p: Vec3) -> Option<Vec2> {
        let Some(motion) = motion_of_hit(scene, hit) else {
            return self.camera_at_opening.film_displacement(p, &self.camera_at_closing, p);
        };
        let before = motion.at_time(time).inverse().transform_point3(p.as_dvec3());
        let at = |time| motion.at_time(time).transform_point3(before).as_vec3();
        self.camera_at_opening.film_displacement(at(0.0), &self.camera_at_closing, at(1.0))
    }

    /// Returns how far a point at infinity in unit `direction` moves on the film, from the opening
    /// to the closing of the shutter \[pixels to the right and down].
    ///
    /// Returns `None` if the point is behind the camera at the opening or the closing, or if the
    /// camera is orthographic.
    #[must_use]
    pub fn displacement_at_infinity(&self, direction: Vec3) -> Option<Vec2> {
        self.camera_at_opening.film_displacement_at_infinity(direction, &self.camera_at_closing)
    }
}
