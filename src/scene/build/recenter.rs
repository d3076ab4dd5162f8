//! Choosing the origin of scene coordinates.

use super::object::{BoundsF64, MergedMeshes, ObjectGeometry, SceneObject};
use crate::camera::Camera;
use crate::scene::BuildError;
use crate::scene::animation::{MID_SHUTTER, shape_at_time};
use crate::shape::Shape;
use glam::{DVec3, Vec2};

/// Largest accepted ratio of an object's distance from the origin to the object's size, 2¹². The
/// center of the scene's bounding box becomes the origin if no object exceeds this ratio.
///
/// Single precision then rounds the object's coordinates by at most 2⁻²⁴·2¹² = 2⁻¹² of its size.
const MAX_DISTANCE_IN_SIZES: f64 = 4096.0;

/// Number of bisection steps of [`minimax_coordinate`], enough for the digits of double precision.
const BISECTIONS: u32 = 64;

/// Camera position, and the distance \[length] to the nearest shape along five camera rays.
type CameraAndNearestDistance = (DVec3, f64);

/// Center and size of a region in which single precision must resolve details.
///
/// For an object it is the center and the largest extent of its bounding box. For the camera it is
/// the camera's position and the distance to the nearest shape.
#[derive(Clone, Copy, Debug)]
struct FineDetailRegion {
    center: DVec3,
    size: f64,
}

/// Chooses the origin of scene coordinates; returns it in world coordinates. It is the camera
/// position if the scene has no bounded objects.
pub(super) fn choose_scene_origin(
    objects: &[SceneObject],
    mesh: &MergedMeshes,
    camera: &Camera,
) -> Result<DVec3, BuildError> {
    let (mut resting, mut moving, mut meshes) = (Vec::new(), Vec::new(), Vec::new());
    let mut shapes = Vec::new();
    for object in objects {
        match (&object.geometry, &object.motion) {
            (ObjectGeometry::Shape(shape), None) => {
                resting.push(shape.bounds_f64());
                shapes.push(shape);
            }
            (ObjectGeometry::Shape(shape), Some(motion)) => {
                let at = |time| {
                    shape_at_time(shape, motion, time).map(|shape| shape.bounds_f64()).ok_or(BuildError::SingularMotion)
                };
                moving.push(union_of_bounds(union_of_bounds(at(0.0)?, at(MID_SHUTTER)?), at(1.0)?));
            }
            (ObjectGeometry::Mesh(_), _) => meshes.extend(object.resting_bounds(mesh)),
            (ObjectGeometry::Plane(_), _) => {}
        }
    }
    let boxes = [resting, moving, meshes].concat();
    Ok(origin_for_bounds(&boxes, camera_and_nearest_distance(camera, &shapes)).unwrap_or(camera.center()))
}

fn union_of_bounds((a, b): BoundsF64, (c, d): BoundsF64) -> BoundsF64 {
    (a.min(c), b.max(d))
}

/// Chooses the origin for objects with bounding boxes `boxes`; `None` if there are no boxes.
///
/// The camera of `view` counts as an object whose size is the distance to the nearest shape. The
/// origin is the center of the union of all boxes, if no object is farther from this center than
/// [`MAX_DISTANCE_IN_SIZES`] times the object's size. Otherwise, as for small objects on a huge
/// sphere, the origin minimizes the greatest ratio of an object's distance to its size.
fn origin_for_bounds(boxes: &[BoundsF64], view: Option<CameraAndNearestDistance>) -> Option<DVec3> {
    let (min, max) = boxes.iter().copied().reduce(union_of_bounds)?;
    let center = min * 0.5 + max * 0.5;
    let target = |(min, max): &BoundsF64| FineDetailRegion {
        center: *min * 0.5 + *max * 0.5,
        size: (*max - *min).max_element(),
    };
    // The camera may lie outside the box, but the origin must not: move the camera's region into
    // the box.
    let view = view.map(|(center, size)| FineDetailRegion { center: center.clamp(min, max), size });
    let targets: Vec<FineDetailRegion> = boxes.iter().map(target).chain(view).filter(|t| t.size > 0.0).collect();
    let greatest_ratio =
        |m: DVec3| targets.iter().map(|t| (t.center - m).abs().max_element() / t.size).fold(0.0, f64::max);
    let max_ratio = greatest_ratio(center);
    if max_ratio.is_nan() || max_ratio <= MAX_DISTANCE_IN_SIZES {
        return Some(center);
    }
    let nearest = DVec3::from_array([0, 1, 2].map(|axis| minimax_coordinate(&targets, axis, max_ratio)));
    Some(nearest.clamp(min, max))
}

/// Returns the camera position, and the distance of the nearest shape along the rays through the
/// center and the corners of the image.
///
/// Returns `None` if these rays hit none of `shapes`, which are the shapes at rest. Meshes and
/// moving shapes are not tested.
fn camera_and_nearest_distance(camera: &Camera, shapes: &[&Shape]) -> Option<CameraAndNearestDistance> {
    let (position, (width, height)) = (camera.center(), camera.size());
    let local = camera.translated(-position);
    let size = Vec2::new(width as f32, height as f32);
    let rays = [Vec2::splat(0.5), Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|p| local.generate_ray(p * size, None));
    let distances = shapes.iter().map(|shape| shape.translated(-position)).flat_map(|shape| {
        let nearest = rays.iter().filter_map(|ray| Some(shape.intersect(ray)?.t)).reduce(f32::min);
        nearest.into_iter()
    });
    Some((position, f64::from(distances.reduce(f32::min)?)))
}

/// Returns the coordinate along `axis` of the best origin. Each target region has a ratio: its
/// distance from the origin along `axis`, divided by its size. The best origin is the one whose
/// greatest ratio is smallest.
///
/// The greatest ratio of the best origin lies between 0 and `max_ratio`, and is found by bisection.
fn minimax_coordinate(targets: &[FineDetailRegion], axis: usize, max_ratio: f64) -> f64 {
    let feasible_interval = |t: f64| {
        let ends =
            targets.iter().map(|target| (target.center[axis] - t * target.size, target.center[axis] + t * target.size));
        ends.fold((f64::NEG_INFINITY, f64::INFINITY), |(low, high), (a, b)| (low.max(a), high.min(b)))
    };
    let (mut infeasible, mut feasible) = (0.0, max_ratio);
    for _ in 0..BISECTIONS {
        let t = 0.5 * (infeasible + feasible);
        let (low, high) = feasible_interval(t);
        if low <= high { feasible = t } else { infeasible = t }
    }
    let (low, high) = feasible_interval(feasible);
    0.5 * low + 0.5 * high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounding_box_of_ball(center: DVec3, radius: f64) -> BoundsF64 {
        (center - radius, center + radius)
    }

    #[test]
    fn objects_of_similar_size_lie_around_the_box_center() {
        let boxes = [bounding_box_of_ball(DVec3::ZERO, 1.0), bounding_box_of_ball(DVec3::new(100.0, 0.0, 3.0), 0.1)];
        let off = origin_for_bounds(&boxes, None).unwrap() - DVec3::new(49.55, 0.0, 1.05);
        assert!(off.length() < 1e-12, "{off}");
        assert_eq!(origin_for_bounds(&[], Some((DVec3::ONE, 1.0))), None);
    }

    #[test]
    fn small_objects_on_a_huge_one_determine_the_origin() {
        let floor = bounding_box_of_ball(DVec3::new(0.0, -1e5, 0.0), 1e5);
        let boxes = [
            floor,
            bounding_box_of_ball(DVec3::new(2.0, 0.5, 0.0), 0.5),
            bounding_box_of_ball(DVec3::new(-2.0, 0.5, 0.0), 0.25),
        ];
        let found = origin_for_bounds(&boxes, None).unwrap();
        // The origin lies between the balls at x = 2 and x = −2. Its distances from them are in the
        // ratio of their radii, 0.5 : 0.25.
        assert!((found.x - (2.0 - 4.0 / 1.5)).abs() < 1e-9 && (found.y - 0.5).abs() < 1.0, "{found}");
        assert!((origin_for_bounds(&[floor], Some((DVec3::Y, 1.0))).unwrap().y).abs() < 2.0);
        assert_eq!(origin_for_bounds(&[floor], None), Some(DVec3::Y * -1e5));
    }
}
