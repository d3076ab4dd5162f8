//! Pivot: the point about which the camera turns on the live page and on turntables.

use crate::scene::Scene;
use glam::{DVec3, Vec2};

/// Returns the surface point that the center of the picture shows, in the coordinates of the scene
/// description.
///
/// If the camera ray through the picture's center hits no surface, returns the point of the ray
/// that is nearest to the center of the scene. A point closer to the camera than a tenth of the
/// scene's radius is moved to that distance.
pub(super) fn pivot(scene: &Scene) -> DVec3 {
    let camera = scene.camera();
    let (width, height) = camera.size();
    let ray = camera.generate_ray(0.5 * Vec2::new(width as f32, height as f32), None);
    let domain = scene.photon_domain();
    let middle = (domain.center - ray.origin).dot(ray.direction).max(0.1 * domain.radius);
    let distance = scene.intersect(&ray).map_or(middle, |hit| hit.t);
    scene.origin() + ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(distance)
}
