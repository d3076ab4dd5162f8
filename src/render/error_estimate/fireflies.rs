//! Fireflies: pixels whose relative squared noise exceeds 1.

/// Number of classes of [`FireflyHistogram`]. Each class covers a factor of 2 of a pixel's relative
/// squared noise; the last class also holds all larger values.
const CLASS_COUNT: usize = 32;

/// Histogram of fireflies by their relative squared noise.
///
/// A firefly is a pixel with relative squared noise c > 1, caused by one rare bright sample. Error
/// estimates clamp c to 1. With m times as many passes, c falls to c/m², but m times as many pixels
/// have such a sample. The sum of min(1, c/m²) over these pixels first grows with m, and falls as
/// 1/m for large m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FireflyHistogram {
    /// Entry i is the fraction of all pixels that are fireflies of class i: those with a relative
    /// squared noise from 2^i to 2^(i + 1).
    fractions: [f64; CLASS_COUNT],
}

impl FireflyHistogram {
    /// Adds fireflies, pixels with relative squared noise `square` > 1, which make up the given
    /// `fraction` of all pixels.
    pub(super) fn add(&mut self, square: f64, fraction: f64) {
        let octave = libm::log2(square).clamp(0.0, (CLASS_COUNT - 1) as f64);
        self.fractions[octave as usize] += fraction;
    }

    /// Adds `other`, the histogram of other pixels of the same picture.
    pub(super) fn merge(&mut self, other: &Self) {
        self.fractions.iter_mut().zip(other.fractions).for_each(|(fraction, other)| *fraction += other);
    }

    /// Returns the contribution of fireflies to the mean relative squared error after the passes
    /// made so far. Each firefly counts as 1, so the contribution is the fraction of pixels that
    /// are fireflies.
    pub(super) fn squared_error_of_fireflies(&self) -> f64 {
        self.fractions.iter().sum()
    }

    /// Predicts the contribution of fireflies to the mean relative squared error after `factor`
    /// times as many passes as made so far. The result is at most 1, because each pixel counts at
    /// most 1.
    ///
    /// The result may grow with `factor` at first, because more passes find more rare bright
    /// samples.
    pub(super) fn firefly_squared_error_after(&self, factor: f64) -> f64 {
        let one = |(octave, part): (usize, &f64)| part * (libm::exp2(octave as f64 + 0.5) / (factor * factor)).min(1.0);
        (factor * self.fractions.iter().enumerate().map(one).sum::<f64>()).min(1.0)
    }
}
