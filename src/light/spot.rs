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
    /// Cosine of the half angle at which the intensity begins to fall.
    pub cos_inner: f32,
    /// Cosine of the half angle at which it is zero.
    pub cos_outer: f32,
    /// Intensity inside the inner cone \[W/sr].
    pub peak: Rgb,
}

impl Spot {
    /// Intensity in unit direction `w`: a cubic step in the cosine (Pharr, Jakob, Humphreys 2023, section 12.2.1).
    #[inline]
    #[must_use]
    pub fn intensity(&self, w: Vec3) -> Rgb {
        let cos = w.dot(self.axis);
        if cos >= self.cos_inner {
            return self.peak;
        }
        let x = (cos - self.cos_outer) / (self.cos_inner - self.cos_outer);
        if x > 0.0 { self.peak * (x * x * (3.0 - 2.0 * x)) } else { Rgb::ZERO }
    }

    /// Flux \[W]: the step's mean over the rim is one half.
    #[must_use]
    pub fn power(&self) -> Rgb {
        self.peak * (TAU * ((1.0 - self.cos_inner) + 0.5 * (self.cos_inner - self.cos_outer)))
    }
}
