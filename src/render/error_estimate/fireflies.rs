//! Fireflies: pixels whose relative squared noise exceeds 1.

/// Number of brightness classes. The last one also holds all brighter fireflies.
const OCTAVES: usize = 32;

/// Histogram of fireflies by brightness.
///
/// A firefly has relative squared noise c > 1, which error estimates clamp to 1. It stems from one
/// rare bright sample. With m times as many passes, its c falls to c/m², but m times as many pixels
/// have such a sample. The sum of min(1, c/m²) over these pixels grows with m at first, and falls
/// as 1/m for large m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Fireflies {
    /// Fraction of pixels that are fireflies, for each value of ⌊log₂ c⌋.
    fractions: [f64; OCTAVES],
}

impl Fireflies {
    /// Adds fireflies of relative squared noise `square` > 1 that cover `fraction` of the pixels.
    pub(super) fn add(&mut self, square: f64, fraction: f64) {
        let octave = libm::log2(square).clamp(0.0, (OCTAVES - 1) as f64);
        self.fractions[octave as usize] += fraction;
    }

    /// Contribution of fireflies to the mean squared error after the passes so far.
    pub(super) fn squared_error_of_fireflies(&self) -> f64 {
        self.fractions.iter().sum()
    }

    /// Contribution of fireflies to the mean squared error after `factor` times as many passes; at
    /// most 1.
    pub(super) fn squared_error_after(&self, factor: f64) -> f64 {
        let one = |(octave, part): (usize, &f64)| part * (libm::exp2(octave as f64 + 0.5) / (factor * factor)).min(1.0);
        (factor * self.fractions.iter().enumerate().map(one).sum::<f64>()).min(1.0)
    }
}
