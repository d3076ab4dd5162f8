//! Solid textures: clouds, marble veins and wood rings as functions of object-space position.

use super::noise::fractal_noise;
use crate::color::Rgb;
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// The pattern of a [`SolidTexture`]: a function of position with values in \[0, 1].
///
/// x, y and z are coordinates in pattern space. The frequency, the amplitude and the octaves of the
/// noise are fields of [`SolidTexture`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidPattern {
    /// Clouds: ½ + ½·amplitude·noise, clamped to \[0, 1].
    Noise,
    /// Veins across the x axis: ½ + ½ sin 2π(frequency·x + amplitude·noise).
    Marble,
    /// Rings about the y axis: ½ + ½ sin 2π(frequency·√(x² + z²) + amplitude·noise).
    Wood,
}

/// A solid texture: a pattern in space that blends two colors.
///
/// The patterns come from the scene format of MIT course 6.837. Their noise is fractal gradient
/// noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidTexture {
    /// Function of position that gives the blend weight of the second color.
    pub kind: SolidPattern,
    /// Colors for pattern values 0 and 1.
    pub colors: [Rgb; 2],
    /// Number of octaves of noise; each has twice the frequency and half the amplitude of the one
    /// before.
    pub octaves: u32,
    /// Frequency of the first octave of noise, and of veins and rings \[1/pattern-space length].
    pub frequency: f64,
    /// Factor on the noise: the contrast of clouds, or the displacement of veins and rings in
    /// wavelengths.
    pub amplitude: f64,
    /// Affine map from object space to pattern space, in which the pattern is defined.
    pub object_to_pattern: DAffine3,
}

impl SolidTexture {
    /// Mean color over a ball of diameter `width` around `p`, both in object space.
    ///
    /// Fine octaves of the noise fade as the width grows. The mean of a wave sin 2πs over an
    /// interval of s with the width w is sin 2πs · sin(πw)/(πw).
    #[must_use]
    pub fn color_at(&self, p: DVec3, width: f64) -> Rgb {
        let p = self.object_to_pattern.transform_point3(p) * self.frequency;
        let w = width * self.max_scale() * self.frequency.abs();
        let noise = self.amplitude * fractal_noise(p, w, self.octaves);
        let wave = |along: f64| {
            let phase = along + noise;
            if phase.is_finite() {
                0.5 + 0.5 * libm::sin(2.0 * PI * (phase - phase.floor())) * sinc_attenuation(w)
            } else {
                0.5
            }
        };
        let t = match self.kind {
            SolidPattern::Noise => (0.5 + 0.5 * noise).clamp(0.0, 1.0),
            SolidPattern::Marble => wave(p.x),
            SolidPattern::Wood => wave(libm::hypot(p.x, p.z)),
        };
        self.colors[0].lerp(self.colors[1], t as f32)
    }

    /// Mean color over all space: the mean of both colors, because pattern values are symmetric
    /// about ½.
    pub(super) fn mean(&self) -> Rgb {
        (self.colors[0] + self.colors[1]) * 0.5
    }

    /// Largest factor from object-space to pattern-space lengths, approximately: the length of the
    /// longest of the three transformed unit axes.
    fn max_scale(&self) -> f64 {
        let m = self.object_to_pattern.matrix3;
        m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length())
    }

    /// Step of the finite differences of bump maps \[object-space length].
    ///
    /// The step is a hundredth of the wavelength of the finest octave, or 1 if the pattern is
    /// constant.
    pub(super) fn finest_bump_step(&self) -> f64 {
        let finest =
            self.frequency.abs() * self.max_scale() * f64::from(1u32 << self.octaves.clamp(1, 31).saturating_sub(1));
        if finest > 0.0 { 1e-2 / finest } else { 1.0 }
    }
}

/// Factor by which averaging over width `w`, in wavelengths, reduces the amplitude of a sine wave.
///
/// The factor is sin(πw)/(πw) up to w = 1. For larger w, it is 0, because negative lobes would
/// invert the pattern.
fn sinc_attenuation(w: f64) -> f64 {
    if w < 1e-6 {
        1.0
    } else if w < 1.0 {
        libm::sin(PI * w) / (PI * w)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests;
