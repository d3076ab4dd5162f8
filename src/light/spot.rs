//! Spotlights.

use crate::color::Rgb;
use glam::Vec3;
use std::f32::consts::TAU;

/// A point source with full intensity inside an inner cone, falling smoothly to nothing at an outer one.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Place.
    pub position: Vec3,
    /// Unit direction of the middle of the beam.
    pub axis: Vec3,
    /// 1 − cosine of the half angle at which the intensity begins to fall: a cosine has no digits left for narrow beams.
    pub inner: f32,
    /// 1 − cosine of the half angle at which it is zero.
    pub outer: f32,
    /// Intensity inside the inner cone \[W/sr].
    pub peak: Rgb,
}

impl Spot {
    /// Intensity in unit direction `w`.
    #[inline]
    #[must_use]
    pub fn intensity(&self, w: Vec3) -> Rgb {
        // |w − a|² = 2(1 − cos) keeps its digits in narrow beams.
        self.intensity_at(0.5 * (w - self.axis).length_squared())
    }

    /// Intensity where 1 − cosine of the angle to the axis is `one_minus_cos`: a cubic step in the cosine (Pharr, Jakob, Humphreys 2023,
    /// section 12.2.1).
    #[inline]
    #[must_use]
    pub fn intensity_at(&self, one_minus_cos: f32) -> Rgb {
        if one_minus_cos <= self.inner {
            return self.peak;
        }
        let x = (self.outer - one_minus_cos) / (self.outer - self.inner);
        if x > 0.0 { self.peak * (x * x * (3.0 - 2.0 * x)) } else { Rgb::ZERO }
    }

    /// Flux \[W]: the step's mean over the rim is one half.
    #[must_use]
    pub fn power(&self) -> Rgb {
        self.peak * (TAU * (self.inner + 0.5 * (self.outer - self.inner)))
    }
}
