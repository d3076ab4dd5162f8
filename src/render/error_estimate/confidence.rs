//! Confidence level of error intervals: the probability that an interval contains the true error.

use serde::Serialize;

/// Confidence level: the probability in (0, 1) that an error interval contains the true error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Confidence(f64);

impl Confidence {
    /// Smallest confidence: 10⁻⁹. An interval of this confidence has practically no width.
    pub const LEAST: Self = Self(1e-9);

    /// Returns the confidence of the given `probability`; `None` unless 0 < `probability` < 1.
    #[must_use]
    pub fn new(probability: f64) -> Option<Self> {
        (probability > 0.0 && probability < 1.0).then_some(Self(probability))
    }

    /// Returns the probability, in (0, 1), that the interval contains the true error.
    #[must_use]
    pub fn probability(self) -> f64 {
        self.0
    }

    /// Returns the number w for which a Gaussian variate lies within w standard deviations of its
    /// mean with this probability: 1.645 for 90 %.
    #[must_use]
    pub fn gaussian_half_width(self) -> f64 {
        // 60 bisections reach f64 precision. Beyond 40 deviations the tail underflows.
        let (mut low, mut high) = (0.0, 40.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if libm::erf(middle * std::f64::consts::FRAC_1_SQRT_2) < self.0 { low = middle } else { high = middle }
        }
        high
    }
}

impl Default for Confidence {
    /// Returns a confidence of 90 %.
    fn default() -> Self {
        Self(0.9)
    }
}
