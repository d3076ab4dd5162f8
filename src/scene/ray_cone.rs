//! How much of a surface a ray sees at once.

use super::Effects;
use crate::bsdf::{Bsdf, DIFFUSE_BLUR};

/// Part of a pixel that textures are blurred over: the pixel's own filter blurs them too.
const PIXEL: f32 = 0.5;

/// The cone around a ray that textures are blurred over (Amanatides 1984, "Ray tracing with cones"; Akenine-Möller et al. 2021,
/// "Improved shader and texture level of effects using ray cones").
///
/// A walk from the camera begins as wide as a pixel. It grows with distance, and faster after surfaces that scatter. What a photon
/// sees is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayCone {
    /// Diameter where the ray is \[length].
    width: f32,
    /// What the diameter grows by along the ray.
    spread: f32,
    /// Whether it is a cone at all.
    blurs: bool,
    /// Whether the walk has met a surface that is no mirror and no smooth glass.
    scattered: bool,
    /// The effects that are simulated.
    pub effects: Effects,
}

impl RayCone {
    /// Of a walk from the camera, whose pixels have this width \[length] and grow by so much along the ray.
    #[inline]
    #[must_use]
    pub fn of_pixel((width, spread): (f32, f32), effects: Effects) -> Self {
        Self { width: width * PIXEL, spread: spread * PIXEL, blurs: true, ..Self::point(effects) }
    }

    /// A line.
    #[inline]
    #[must_use]
    pub const fn point(effects: Effects) -> Self {
        Self { width: 0.0, spread: 0.0, blurs: false, scattered: false, effects }
    }

    /// Goes on by `distance` \[length].
    #[inline]
    pub fn travel(&mut self, distance: f32) {
        self.width += self.spread * distance;
    }

    /// Leaves a surface.
    #[inline]
    pub(super) fn leave(&mut self, bsdf: &Bsdf) {
        if self.blurs {
            self.spread += bsdf.blur();
        }
        self.scattered |= !bsdf.is_specular();
    }

    /// Leaves a point of a medium.
    #[inline]
    pub(super) fn scatter(&mut self) {
        if self.blurs {
            self.spread += DIFFUSE_BLUR;
        }
        self.scattered = true;
    }

    /// Diameter where the ray is \[length].
    #[inline]
    #[must_use]
    pub fn width(&self) -> f32 {
        self.width
    }

    /// The cone as it sees lights: those that could have been asked for are seen as they would have been, as points.
    #[inline]
    pub(super) fn of_lights(&self) -> Self {
        if self.scattered { Self::point(self.effects) } else { *self }
    }
}
