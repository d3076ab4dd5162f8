//! Solid textures: clouds, veins and rings in space.

use super::noise::fractal_noise;
use crate::color::Rgb;
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// The pattern of a [`SolidTexture`], a function of position with values in \[0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidPattern {
    /// Clouds: ½ + ½·amplitude·noise, clamped to \[0, 1].
    Noise,
    /// Veins across the x axis: ½ + ½ sin 2π(frequency·x + amplitude·noise).
    Marble,
    /// Rings about the y axis: ½ + ½ sin 2π(frequency·√(x² + z²) + amplitude·noise).
    Wood,
}

/// A solid texture: a pattern in space that blends two colours, from the scene language of MIT
/// course 6.837.
///
/// The noise is a sum of octaves. Each has twice the frequency and half the amplitude of the one
/// before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidTexture {
    /// The pattern.
    pub kind: SolidPattern,
    /// Colours at 0 and at 1.
    pub colors: [Rgb; 2],
    /// Number of octaves of noise.
    pub octaves: u32,
    /// Frequency of the first octave, and of veins and rings \[1/length].
    pub frequency: f64,
    /// Factor of the noise.
    pub amplitude: f64,
    /// From object space to pattern space.
    pub to_pattern: DAffine3,
}

impl SolidTexture {
    /// Mean colour over a ball of diameter `width` around `p` in object space.
    ///
    /// Fine octaves of the noise fade with the width. The mean of a wave sin 2πs over a width w of
    /// s is sin 2πs · sin(πw)/(πw).
    #[must_use]
    pub fn color_at(&self, p: DVec3, width: f64) -> Rgb {
        let p = self.to_pattern.transform_point3(p) * self.frequency;
        let w = width * self.max_scale() * self.frequency.abs();
        let noise = self.amplitude * fractal_noise(p, w, self.octaves);
        let wave = |along: f64| {
            let phase = along + noise;
            if phase.is_finite() {
                0.5 + 0.5 * libm::sin(2.0 * PI * (phase - phase.floor())) * sinc_blur(w)
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

    /// The mean of both colours: noise and waves are symmetric.
    pub(super) fn mean(&self) -> Rgb {
        (self.colors[0] + self.colors[1]) * 0.5
    }

    /// Length of the longest image of a unit coordinate axis: the scale from object space to
    /// pattern space.
    fn max_scale(&self) -> f64 {
        let m = self.to_pattern.matrix3;
        m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length())
    }

    pub(super) fn bump_step(&self) -> f64 {
        let finest =
            self.frequency.abs() * self.max_scale() * f64::from(1u32 << self.octaves.clamp(1, 31).saturating_sub(1));
        if finest > 0.0 { 1e-2 / finest } else { 1.0 }
    }
}

/// sin(πw)/(πw) up to its first zero, and 0 beyond, where its lobes would invert the pattern.
fn sinc_blur(w: f64) -> f64 {
    if w < 1e-6 {
        1.0
    } else if w < 1.0 {
        libm::sin(PI * w) / (PI * w)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn test_solid(kind: SolidPattern, amplitude: f64, to_pattern: DAffine3) -> SolidTexture {
        SolidTexture { kind, colors: [Rgb::ZERO, Rgb::ONE], octaves: 3, frequency: 2.0, amplitude, to_pattern }
    }

    #[test]
    fn veins_and_rings_have_their_frequency_and_phase() {
        let marble = test_solid(SolidPattern::Marble, 0.0, DAffine3::IDENTITY);
        let wood = test_solid(SolidPattern::Wood, 0.0, DAffine3::IDENTITY);
        // Two waves a length: the maximum is at an eighth.
        for (solid, p) in [(marble, DVec3::new(0.125, 9.0, 3.0)), (wood, DVec3::new(0.075, 9.0, 0.1))] {
            assert!((solid.color_at(p, 0.0).x - 1.0).abs() < 1e-6);
        }
        let turned = test_solid(
            SolidPattern::Marble,
            0.0,
            DAffine3::from_quat(DQuat::from_rotation_z(-std::f64::consts::FRAC_PI_2)),
        );
        assert!((turned.color_at(DVec3::new(9.0, 0.125, 3.0), 0.0).x - 1.0).abs() < 1e-6);
    }

    /// Expected: the mean of the wave over a box of width w around p, by n midpoints; the error is
    /// below (w/n)².
    #[test]
    fn wide_footprints_average_the_wave() {
        let marble = test_solid(SolidPattern::Marble, 0.0, DAffine3::IDENTITY);
        let (p, width, n) = (0.1, 0.3, 1000);
        let at = |i: i32| marble.color_at(DVec3::X * (p + width * ((f64::from(i) + 0.5) / f64::from(n) - 0.5)), 0.0).x;
        let mean = (0..n).map(|i| f64::from(at(i))).sum::<f64>() / f64::from(n);
        assert!((f64::from(marble.color_at(DVec3::X * p, width).x) - mean).abs() < 1e-6);
        assert_eq!(marble.color_at(DVec3::X * p, 10.0), Rgb::splat(0.5));
    }

    /// Noise is symmetric: over n points the mean has an error below 5/(2√n), as values lie in [0,
    /// 1].
    #[test]
    fn patterns_have_their_stated_mean() {
        let n = 50_000;
        for kind in [SolidPattern::Noise, SolidPattern::Marble, SolidPattern::Wood] {
            let solid = test_solid(kind, 1.5, DAffine3::IDENTITY);
            let p = |i: u32| DVec3::new(6.180_34, 4.142_14, 7.320_51) * f64::from(i) - 1e5;
            let mean = (0..n).map(|i| f64::from(solid.color_at(p(i), 0.0).x)).sum::<f64>() / f64::from(n);
            assert!((mean - f64::from(solid.mean().x)).abs() < 2.5 / f64::from(n).sqrt(), "{kind:?}: {mean}");
            assert!(solid.color_at(DVec3::splat(f64::INFINITY), 0.0).is_finite());
        }
    }
}
