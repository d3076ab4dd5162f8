//! Length of the paths of moving parts on the film while the shutter is open. From it, a pass
//! determines into how many time slices it divides the shutter interval.

use super::Scene;
use super::animation::MID_SHUTTER;
use super::geometry::HitPrimitive;
use crate::camera::Camera;
use crate::math::Motion;
use glam::{DVec3, Vec2};

/// Number of equal time steps into which the shutter interval is divided. During each step, points
/// count as moving along a straight line.
const STEPS: u32 = 16;

/// Largest number of moving shapes whose motion is measured. If there are more, only every n-th
/// shape is measured, with the smallest n that suffices.
const MAX_MEASURED_SHAPES: usize = 4096;

/// Number of columns, and of rows, of a grid of film points. The motion of the camera and of planes
/// is measured at the scene points that the camera sees there.
const FILM_POINTS_PER_SIDE: u32 = 5;

/// Measures how far points move while the shutter is open, in pixels of the film.
struct MotionLengthMeter {
    /// The camera at times 0, 1/[`STEPS`], …, 1 of the shutter interval.
    cameras: Vec<Camera>,
    /// Width and height of the film \[pixels].
    size: Vec2,
    /// Width of a pixel's footprint \[length] at the distance of the center of the [photon
    /// domain](Scene::photon_domain), a ball around all bounded objects.
    pixel_width: f64,
}

impl MotionLengthMeter {
    fn new(scene: &Scene) -> Self {
        let moved = |step| match scene.animation.as_ref().and_then(|animation| animation.camera.as_ref()) {
            Some((camera, motion)) => {
                super::animation::camera_at_time(camera, motion, step_time(step)).unwrap_or(scene.camera)
            }
            None => scene.camera,
        };
        let (width, growth) = scene.camera.pixel_footprint_and_growth();
        let distance = scene.photon_domain().center.distance(scene.camera.center().as_vec3());
        let (columns, rows) = scene.camera.size();
        Self {
            cameras: (0..=STEPS).map(moved).collect(),
            size: Vec2::new(columns as f32, rows as f32),
            pixel_width: f64::from(width + growth * distance),
        }
    }

    /// Returns the length of the path of a moving point on the film \[pixels].
    ///
    /// `position(i)` is the point, in scene coordinates, after `i` steps of the shutter interval.
    /// Film positions outside the picture are clamped to its edge. A step does not count if the
    /// point is behind the camera at the start or end of the step.
    fn film_path_length_in_pixels(&self, position: &impl Fn(u32) -> DVec3) -> f64 {
        let film_position = |(step, camera): (u32, &Camera)| {
            let at = camera.connect_to_point(position(step).as_vec3(), None)?.film_position;
            Some(at.clamp(Vec2::ZERO, self.size))
        };
        let film_positions: Vec<Option<Vec2>> = (0..).zip(&self.cameras).map(film_position).collect();
        let step = |pair: &[Option<Vec2>]| match pair {
            [Some(a), Some(b)] => f64::from(a.distance(*b)),
            _ => 0.0,
        };
        film_positions.windows(2).map(step).sum()
    }

    /// Returns the length of the path of a moving point through the scene, in pixels: divided by
    /// the width of a pixel's footprint at the center of the [photon domain](Scene::photon_domain).
    ///
    /// `position(i)` is the point, in scene coordinates, after `i` steps of the shutter interval.
    /// This measure is for objects outside the picture: their shadows and caustics may fall into
    /// the picture, and move about as far as the objects.
    fn scene_path_length_in_pixels(&self, position: &impl Fn(u32) -> DVec3) -> f64 {
        (0..STEPS).map(|step| position(step).distance(position(step + 1))).sum::<f64>() / self.pixel_width
    }
}

/// Time after `step` of [`STEPS`] steps of the shutter interval, from 0 (shutter opens) to 1
/// (shutter closes).
fn step_time(step: u32) -> f64 {
    f64::from(step) / f64::from(STEPS)
}

/// The eight corners of the box from `min` to `max`.
fn box_corners((min, max): (DVec3, DVec3)) -> impl Iterator<Item = DVec3> {
    (0..8).map(move |i| {
        let pick = |bit: u32, low: f64, high: f64| if (i >> bit) & 1 == 0 { low } else { high };
        DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z))
    })
}

/// Returns the trajectory of a moving point as a function. The function maps a number of steps
/// since the opening of the shutter (see [`STEPS`]) to the point's position in scene coordinates.
/// `point` is the position at mid-shutter.
fn trajectory_from_mid_shutter(motion: &Motion, point: DVec3) -> impl Fn(u32) -> DVec3 + use<'_> {
    let before = motion.at_time(MID_SHUTTER).inverse().transform_point3(point);
    move |step| motion.at_time(step_time(step)).transform_point3(before)
}

/// Returns the length of the longest path that a measured point of the scene takes on the film
/// while the shutter is open \[pixels]; 0 if nothing moves.
///
/// - For a moving shape, the corners of its bounds are measured, both on the film and in the scene.
///   Of many shapes, only every n-th is measured.
/// - For a moving light, its position or points around it are measured in the scene.
/// - For the camera and for moving planes, points that the camera sees are measured on the film.
///
/// A length in the scene is divided by the width of a pixel's footprint at the center of the
/// [photon domain](Scene::photon_domain), a ball around all bounded objects.
#[must_use]
pub fn max_motion_in_pixels(scene: &Scene) -> f32 {
    let Some(animation) = &scene.animation else { return 0.0 };
    let meter = MotionLengthMeter::new(scene);
    let mut longest = 0.0f64;

    // Measure moving shapes by the corners of their boxes.
    let stride = animation.shapes.len().div_ceil(MAX_MEASURED_SHAPES).max(1);
    for (shape, motion) in animation.shapes.iter().step_by(stride) {
        let maps: Vec<_> = (0..=STEPS).map(|step| motion.at_time(step_time(step))).collect();
        for corner in box_corners(shape.bounds_f64()) {
            let position = |step: u32| maps[step as usize].transform_point3(corner);
            longest = longest
                .max(meter.film_path_length_in_pixels(&position))
                .max(meter.scene_path_length_in_pixels(&position));
        }
    }

    // Measure moving lights by their position, or by points around it that turn with the light.
    let domain = scene.photon_domain();
    for (i, kind, _, motion) in &animation.lights {
        let center = scene.lights[*i].representative_point().unwrap_or(domain.center).as_dvec3();
        let reach = if kind.changes_by_rotation() { f64::from(domain.radius) } else { 0.0 };
        for corner in box_corners((center - reach, center + reach)) {
            longest = longest.max(meter.scene_path_length_in_pixels(&trajectory_from_mid_shutter(motion, corner)));
        }
    }

    // Measure the camera and moving planes by points that the camera sees at mid-shutter.
    if animation.camera.is_some() || !animation.planes.is_empty() {
        let first_plane = scene.geometry.planes.len() - animation.planes.len();
        for (x, y) in (0..FILM_POINTS_PER_SIDE * FILM_POINTS_PER_SIDE)
            .map(|i| (i % FILM_POINTS_PER_SIDE, i / FILM_POINTS_PER_SIDE))
        {
            let at = (Vec2::new(x as f32, y as f32) + 0.5) / FILM_POINTS_PER_SIDE as f32 * meter.size;
            let ray = scene.camera.generate_ray(at, None);
            let hit = scene.intersect(&ray);
            let distance = hit.map_or(domain.radius, |hit| hit.t);
            let seen = (ray.origin + ray.direction * distance).as_dvec3();
            let plane = hit.and_then(|hit| match hit.primitive {
                HitPrimitive::Plane(i) => animation.planes.get((i as usize).checked_sub(first_plane)?),
                HitPrimitive::Triangle(..) | HitPrimitive::Shape(..) => None,
            });
            longest = longest.max(match plane {
                Some((_, motion)) => meter.film_path_length_in_pixels(&trajectory_from_mid_shutter(motion, seen)),
                None => meter.film_path_length_in_pixels(&|_| seen),
            });
        }
    }
    longest as f32
}
