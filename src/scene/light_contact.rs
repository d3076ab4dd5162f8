//! Lights that stand in a surface.

use super::Scene;
use crate::light::Light;
use crate::math::{Ray, gamma};
use glam::Vec3;

/// How far from a light in a surface its light begins, in distances that rounding may have put it to one side.
const CLEAR: f32 = 40.0;

/// Roundings of double precision between the coordinates of a description and two places that count from the middle: four in a map, one in
/// its product with another, one in the difference, of each; and as many for room.
const ROUNDINGS: f64 = 24.0;

impl Scene {
    /// How near to a surface light `light` is taken to stand in it \[length]: it shines on both sides. 0 for lights with a surface, and from
    /// infinity.
    ///
    /// Places are rounded to 2⁻²⁴ of their coordinates, so which side such a light is on nobody knows. What leaves it passes that
    /// surface unless it goes along it, at an angle whose cosine to the normal is below a fortieth.
    #[inline]
    #[must_use]
    pub fn light_contact(&self, light: usize) -> f32 {
        self.light_contact[light]
    }

    /// The same of a light, by the rounding of its place and the errors of the surfaces that it touches: those of a huge triangle are large
    /// wherever on it, and none of what stands elsewhere counts.
    pub(super) fn contact_of(&self, light: &Light) -> f32 {
        let Some(place) = light.position() else { return 0.0 };
        let own = place.length() * gamma(1) + (self.middle.length() * ROUNDINGS * 0.5 * f64::EPSILON) as f32;
        // No error is larger than that of a triangle across the domain, √3·18 roundings; an axis meets what is so near within √3 of it.
        let reach = gamma(64) * (self.domain.radius + self.domain.center.abs().max_element() + place.length()) + own;
        let mut doubt = own;
        for axis in Vec3::AXES {
            let mut from = -reach;
            loop {
                let ray = Ray { origin: place + axis * from, direction: axis, t_max: reach - from };
                let Some(hit) = self.intersect(&ray) else { break };
                let point = self.point(&ray, &hit).0;
                let error = point.error.length();
                if (point.p - place).dot(point.ng).abs() <= own + error {
                    doubt = doubt.max(own + error);
                }
                // An error is no less than a step of the coordinates there, so the start moves on.
                from = (from + hit.t + error).max(from.next_up());
            }
        }
        (CLEAR * doubt).min(reach)
    }
}
