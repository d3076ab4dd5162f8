//! Contact distances of delta lights. A surface point closer to a light than this distance counts
//! as touching the light.

use crate::light::Light;
use crate::math::{BoundingSphere, Ray, rounding_error_bound};
use crate::scene::Scene;
use glam::Vec3;

/// Contact distance in units of the position error. A surface point that is nearer to a light than
/// the contact distance counts as touching the light. The position error is the sum of the errors
/// of the light's and the surface's position.
const CONTACT_POSITION_ERRORS: f32 = 40.0;

/// Bound on the number of f64 rounding errors in the difference of two positions, with a safety
/// factor of 2.
///
/// Each position has up to six errors: four from a transform, one from a product of transforms, and
/// one from the difference. The bound is 2 positions · 6 errors · 2 = 24.
const POSITION_ROUNDINGS: f64 = 24.0;

/// Distance \[length] below which a surface point counts as touching `light`: see
/// [`Scene::light_contact_distance`]. The distance is 0 for area lights and lights at infinity.
///
/// The distance allows for the rounding of the light's position, and for the position errors of the
/// surfaces that the light touches.
pub(super) fn light_contact_distance(scene: &Scene, domain: BoundingSphere, light: &Light) -> f32 {
    let Some(position) = light.position() else { return 0.0 };
    let light_error = position.length() * rounding_error_bound(1)
        + (scene.origin.length() * POSITION_ROUNDINGS * 0.5 * f64::EPSILON) as f32;
    // The position error of a triangle as large as the domain is √3·18 roundings. If a surface is
    // at distance d from the light, one of the three axes meets it within √3·d. So
    // `search_distance` must exceed √3·√3·18 = 54 roundings.
    let search_distance = rounding_error_bound(64)
        * (domain.radius + domain.center.abs().max_element() + position.length())
        + light_error;
    let mut error = light_error;
    for axis in Vec3::AXES {
        let mut from = -search_distance;
        loop {
            let ray = Ray { origin: position + axis * from, direction: axis, t_max: search_distance - from };
            let Some(hit) = scene.intersect(&ray) else { break };
            let point = scene.geometry.surface_point(&ray, &hit);
            let surface_error = point.position_error.length();
            if (point.p - position).dot(point.ng).abs() <= light_error + surface_error {
                error = error.max(light_error + surface_error);
            }
            // Each step advances by at least one unit in the last place, so the loop ends.
            from = (from + hit.t + surface_error).max(from.next_up());
        }
    }
    (CONTACT_POSITION_ERRORS * error).min(search_distance)
}
