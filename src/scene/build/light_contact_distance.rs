//! Lights that lie in a surface.

use crate::light::Light;
use crate::math::{BoundingSphere, Ray, rounding_error_bound};
use crate::scene::Scene;
use glam::Vec3;

/// Distance at which the light of a light in a surface starts, in position errors.
const CONTACT_POSITION_ERRORS: f32 = 40.0;

/// Roundings of double precision in the difference of two described positions.
///
/// A map has four, its product with another one, and the difference one, for each position; and as
/// many for room.
const POSITION_ROUNDINGS: f64 = 24.0;

/// Distance within which a light counts as lying in a surface \[length]: see
/// [`Scene::light_contact_distance`].
///
/// It covers the rounding of the light's position, and the position errors of the surfaces that it
/// touches. Those of a huge triangle are large all over it. Surfaces elsewhere do not matter.
pub(super) fn light_contact_distance(scene: &Scene, domain: BoundingSphere, light: &Light) -> f32 {
    let Some(position) = light.position() else { return 0.0 };
    let own = position.length() * rounding_error_bound(1)
        + (scene.origin.length() * POSITION_ROUNDINGS * 0.5 * f64::EPSILON) as f32;
    // No error exceeds that of a triangle across the domain, √3·18 roundings. An axis hits a
    // surface as near within √3 of that.
    let reach =
        rounding_error_bound(64) * (domain.radius + domain.center.abs().max_element() + position.length()) + own;
    let mut error = own;
    for axis in Vec3::AXES {
        let mut from = -reach;
        loop {
            let ray = Ray { origin: position + axis * from, direction: axis, t_max: reach - from };
            let Some(hit) = scene.intersect(&ray) else { break };
            let point = scene.geometry.surface_point(&ray, &hit);
            let surface_error = point.error.length();
            if (point.p - position).dot(point.ng).abs() <= own + surface_error {
                error = error.max(own + surface_error);
            }
            // The error is at least one step of the coordinates there, so the start moves on.
            from = (from + hit.t + surface_error).max(from.next_up());
        }
    }
    (CONTACT_POSITION_ERRORS * error).min(reach)
}
