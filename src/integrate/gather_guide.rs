//! Importance sampling of final-gathering directions by the directions of nearby photons.

use crate::math::{Frame, warp};
use glam::{Vec2, Vec3};

/// Largest number of photons, on each side of a surface, that guide a final-gathering ray. The
/// direction of the ray is sampled near the directions from which these photons arrived.
pub(super) const GUIDE_PHOTONS: u32 = 32;

/// Width of the cone around each photon's direction in the guide of final-gathering rays: 1 −
/// cosine of the half angle of 0.2 rad.
///
/// Without overlap, the cones of 32 photons cover 64 % of a hemisphere.
const ONE_MINUS_COS: f32 = 0.02;

/// Distribution of final-gathering directions: an equal mixture of uniform cones, one around each
/// direction from which a nearby photon arrived.
///
/// Source: Hey and Purgathofer 2002, "Importance Sampling with Hemispherical Particle Footprints".
#[derive(Debug, Default)]
pub(super) struct GatherGuide {
    directions: Vec<Vec3>,
}

impl GatherGuide {
    /// Removes all photon directions.
    pub fn clear(&mut self) {
        self.directions.clear();
    }

    /// Adds the unit direction from which a photon arrived.
    pub fn push_direction(&mut self, direction: Vec3) {
        self.directions.push(direction);
    }

    /// Samples a unit direction. `choice` in \[0, 1) selects the cone around one photon direction,
    /// and `u` in \[0, 1)² a direction in this cone.
    ///
    /// Returns `None` if the guide has no photon directions.
    #[inline]
    pub fn sample_direction(&self, choice: f32, u: Vec2) -> Option<Vec3> {
        let chosen = ((choice * self.directions.len() as f32) as usize).min(self.directions.len().checked_sub(1)?);
        Some(
            Frame::from_normal(self.directions[chosen])
                .to_world(warp::square_to_uniform_cone(u, ONE_MINUS_COS))
                .normalize(),
        )
    }

    /// Returns the pdf of unit direction `w` \[1/sr]; `None` if the guide has no photon directions.
    #[inline]
    pub fn pdf(&self, w: Vec3) -> Option<f32> {
        if self.directions.is_empty() {
            return None;
        }
        // |w − d|² = 2(1 − cos) is exact for small angles, unlike the cosine.
        let around = self.directions.iter().filter(|d| (w - **d).length_squared() <= 2.0 * ONE_MINUS_COS).count();
        Some(around as f32 * warp::uniform_cone_pdf(ONE_MINUS_COS) / self.directions.len() as f32)
    }
}

#[cfg(test)]
mod tests;
