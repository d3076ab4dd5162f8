//! Discrete distribution over finitely many items.

/// Discrete probability distribution over the indices `0..len`, sampled by inversion.
#[derive(Clone, Debug)]
pub struct DiscreteDistribution {
    /// Cumulative probabilities of the items; the last entry is 1.
    cumulative: Vec<f64>,
    total: f64,
}

/// Smallest relative weight that an item keeps: the smallest normal f32. A smaller weight counts
/// as 0, because its probability could round to 0, and samples are divided by their probability.
const MIN_PROBABILITY: f64 = f32::MIN_POSITIVE as f64;

impl DiscreteDistribution {
    /// Creates the distribution in which the probability of item i is wᵢ/Σw, for the given
    /// `weights` w.
    ///
    /// Weights below about 10⁻³⁸ of the sum count as 0. Returns `None` if there are no weights, if
    /// one is negative, or if their sum is 0 or not finite.
    #[must_use]
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut cumulative: Vec<f64> = weights.into_iter().collect();
        let total: f64 = cumulative.iter().sum();
        if cumulative.iter().any(|w| *w < 0.0) || !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        for c in &mut cumulative {
            // `probability` would round a smaller weight to zero, and samples are divided by their
            // probability.
            sum += if *c / total < MIN_PROBABILITY { 0.0 } else { *c };
            *c = sum;
        }
        for c in &mut cumulative {
            *c /= sum;
        }
        Some(Self { cumulative, total })
    }

    /// Sum of the weights that were given to [`DiscreteDistribution::new`].
    #[must_use]
    pub fn weight_sum(&self) -> f64 {
        self.total
    }

    /// Number of items.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cumulative.len()
    }

    /// Always false, because [`DiscreteDistribution::new`] returns `None` if there are no weights.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cumulative.is_empty()
    }

    /// Samples an item; returns its index and its probability, which is above 0.
    ///
    /// `u` is uniform in \[0, 1).
    #[inline]
    #[must_use]
    pub fn sample(&self, u: f32) -> (usize, f32) {
        let u = f64::from(u);
        let i = self.cumulative.partition_point(|c| *c <= u).min(self.cumulative.len() - 1);
        (i, self.probability(i))
    }

    /// Returns a new uniform number in \[0, 1), made from the number `u` that sampled item `i`.
    ///
    /// Item i is sampled by all u in an interval, whose length is the item's probability. The new
    /// number is the relative position of `u` in this interval.
    #[inline]
    #[must_use]
    pub fn remapped_sample(&self, u: f32, i: usize) -> f32 {
        let below = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let x = (f64::from(u) - below) / (self.cumulative[i] - below);
        (x as f32).clamp(0.0, 1.0 - f32::EPSILON / 2.0)
    }

    /// Inverse of sampling: returns the number u in \[0, 1) with which
    /// [`DiscreteDistribution::sample`] samples item `i`, and
    /// [`DiscreteDistribution::remapped_sample`] returns `within`, up to rounding.
    #[inline]
    #[must_use]
    pub fn inverse_sample(&self, i: usize, within: f32) -> f32 {
        let below = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let u = below + f64::from(within) * (self.cumulative[i] - below);
        (u as f32).clamp(0.0, 1.0 - f32::EPSILON / 2.0)
    }

    /// Probability of item `i`.
    #[inline]
    #[must_use]
    pub fn probability(&self, i: usize) -> f32 {
        let below = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        (self.cumulative[i] - below) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_become_probabilities() {
        let d = DiscreteDistribution::new([1.0, 0.0, 3.0]).unwrap();
        assert_eq!((d.len(), d.weight_sum()), (3, 4.0));
        assert_eq!(d.sample(0.0), (0, 0.25));
        assert_eq!(d.sample(0.25), (2, 0.75));
        assert_eq!(d.sample(1.0 - f32::EPSILON / 2.0), (2, 0.75));
    }

    #[test]
    fn distributions_refuse_invalid_weights() {
        assert!(DiscreteDistribution::new([]).is_none());
        assert!(DiscreteDistribution::new([0.0, 0.0]).is_none());
        assert!(DiscreteDistribution::new([1.0, -0.5]).is_none());
        assert!(DiscreteDistribution::new([f64::NAN]).is_none());
    }

    #[test]
    fn a_last_weight_of_zero_is_never_sampled() {
        let d = DiscreteDistribution::new([0.1, 0.2, 0.3, 0.0]).unwrap();
        assert!(d.sample(1.0 - f32::EPSILON / 2.0).1 > 0.0);
    }
}
