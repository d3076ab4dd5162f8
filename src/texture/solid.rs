//! Patterns in space: clouds, veins, rings.

use super::noise::fractal;
use crate::color::Rgb;
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// How a pattern's two colours lie in space. N is the noise of [`Solid`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidKind {
    /// Clouds: ½ + ½ a N, cut to \[0, 1].
    Noise,
    /// Veins across the x axis: ½ + ½ sin 2π(f x + a N).
    Marble,
    /// Rings about the y axis: ½ + ½ sin 2π(f √(x² + z²) + a N).
    Wood,
}

/// A pattern that goes from one colour to another, as the ancestors of the scene language have it (MIT 6.837).
///
/// Its noise is that of `octaves` octaves, the first of `frequency` f \[1/length], each next one of twice the frequency and half the
/// height; `amplitude` a is what the noise is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Form.
    pub kind: SolidKind,
    /// Colours at 0 and at 1.
    pub colors: [Rgb; 2],
    /// Octaves of noise.
    pub octaves: u32,
    /// Of the first octave, and of veins and rings \[1/length].
    pub frequency: f64,
    /// What the noise is multiplied by.
    pub amplitude: f64,
    /// From the object's space to the pattern's.
    pub to_pattern: DAffine3,
}

impl Solid {
    /// The pattern at `p` of the object's space, over a ball of diameter `width`: noise loses its fine octaves, and a wave
    /// sin 2πs over a width w of s becomes sin 2πs · sin(πw)/(πw).
    #[must_use]
    pub fn at(&self, p: DVec3, width: f64) -> Rgb {
        let p = self.to_pattern.transform_point3(p) * self.frequency;
        let w = width * self.stretch() * self.frequency.abs();
        let noise = self.amplitude * fractal(p, w, self.octaves);
        let wave = |along: f64| {
            let phase = along + noise;
            if phase.is_finite() { 0.5 + 0.5 * libm::sin(2.0 * PI * (phase - phase.floor())) * blur(w) } else { 0.5 }
        };
        let t = match self.kind {
            SolidKind::Noise => (0.5 + 0.5 * noise).clamp(0.0, 1.0),
            SolidKind::Marble => wave(p.x),
            SolidKind::Wood => wave(libm::hypot(p.x, p.z)),
        };
        self.colors[0].lerp(self.colors[1], t as f32)
    }

    /// Half way: noise and waves are as often above as below.
    pub(super) fn mean(&self) -> Rgb {
        (self.colors[0] + self.colors[1]) * 0.5
    }

    /// How many times longer a length is in the pattern's space, at most.
    fn stretch(&self) -> f64 {
        let m = self.to_pattern.matrix3;
        m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length())
    }

    pub(super) fn grain(&self) -> f64 {
        let finest =
            self.frequency.abs() * self.stretch() * f64::from(1u32 << self.octaves.clamp(1, 31).saturating_sub(1));
        if finest > 0.0 { 1e-2 / finest } else { 1.0 }
    }
}

/// sin(πw)/(πw) up to its first zero, and 0 beyond, where the lobes would turn light and dark around.
fn blur(w: f64) -> f64 {
    if w < 1e-6 {
        1.0
    } else if w < 1.0 {
        libm::sin(PI * w) / (PI * w)
    } else {
        0.0
    }
}
