//! Fireflies: pixels whose relative squared noise exceeds the limit of 1.

/// Number of size classes; the last one also holds everything larger.
const OCTAVES: usize = 32;

/// Fraction of the picture covered by fireflies, by brightness.
///
/// The relative squared noise c > 1 of such a pixel is clamped to 1. In one pixel it falls as 1/n²
/// until another pass finds similar light. Meanwhile m times as many passes produce fireflies in m
/// times as many pixels, each with min(1, c/m²). Their sum grows at first. It falls as 1/m once
/// they have faded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Fireflies {
    /// Fraction of the picture covered by fireflies, by ⌊log₂ c⌋ of their relative squared noise c.
    fractions: [f64; OCTAVES],
}

impl Fireflies {
    /// Adds `fraction` of the picture with relative squared noise `square` > 1.
    pub(super) fn add(&mut self, square: f64, fraction: f64) {
        let octave = libm::log2(square).clamp(0.0, (OCTAVES - 1) as f64);
        self.fractions[octave as usize] += fraction;
    }

    /// Contribution to the mean squared error of the picture after the passes so far.
    pub(super) fn current_squared_error(&self) -> f64 {
        self.fractions.iter().sum()
    }

    /// Contribution to the mean squared error after `factor` times as many passes; at most 1.
    pub(super) fn squared_error_after(&self, factor: f64) -> f64 {
        let one = |(octave, part): (usize, &f64)| part * (libm::exp2(octave as f64 + 0.5) / (factor * factor)).min(1.0);
        (factor * self.fractions.iter().enumerate().map(one).sum::<f64>()).min(1.0)
    }
}
