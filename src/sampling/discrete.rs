//! Choice among finitely many things by weight.

/// A discrete distribution over `0..len`, chosen by inversion of its cumulative weights.
#[derive(Clone, Debug)]
pub struct Discrete {
    /// Cumulative probabilities, the last one 1.
    cumulative: Vec<f64>,
    total: f64,
}

/// Part of the whole under which a thing is never drawn: the least normal number of f32.
const LEAST: f64 = f32::MIN_POSITIVE as f64;

impl Discrete {
    /// Weights to probabilities; those below 10⁻³⁸ of the sum count as zero. `None` where there is nothing to choose: no weights, or a sum of
    /// zero or not finite, or a negative weight.
    #[must_use]
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut cumulative: Vec<f64> = weights.into_iter().collect();
        let total: f64 = cumulative.iter().sum();
        if cumulative.iter().any(|w| *w < 0.0) || !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        for c in &mut cumulative {
            // `probability` could not tell a smaller part from zero, and what is drawn is divided by it.
            sum += if *c / total < LEAST { 0.0 } else { *c };
            *c = sum;
        }
        for c in &mut cumulative {
            *c /= sum;
        }
        Some(Self { cumulative, total })
    }

    /// The sum of the weights.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.total
    }

    /// How many things there are to choose from.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cumulative.len()
    }

    /// Always false: an empty distribution cannot be made.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cumulative.is_empty()
    }

    /// The thing that `u` in \[0, 1) falls on, and its probability, which is never zero.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: f32) -> (usize, f32) {
        let u = f64::from(u);
        let i = self.cumulative.partition_point(|c| *c <= u).min(self.cumulative.len() - 1);
        (i, self.probability(i))
    }

    /// Where in the interval of thing `i` the number `u` that chose it fell: uniform in \[0, 1) again.
    #[inline]
    #[must_use]
    pub fn remainder(&self, u: f32, i: usize) -> f32 {
        let below = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let x = (f64::from(u) - below) / (self.cumulative[i] - below);
        (x as f32).clamp(0.0, 1.0 - f32::EPSILON / 2.0)
    }

    /// The probability of thing `i`.
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
        let d = Discrete::new([1.0, 0.0, 3.0]).unwrap();
        assert_eq!((d.len(), d.total()), (3, 4.0));
        assert_eq!(d.sample(0.0), (0, 0.25));
        assert_eq!(d.sample(0.25), (2, 0.75));
        assert_eq!(d.sample(1.0 - f32::EPSILON / 2.0), (2, 0.75));
    }

    #[test]
    fn nothing_is_chosen_from_nothing() {
        assert!(Discrete::new([]).is_none());
        assert!(Discrete::new([0.0, 0.0]).is_none());
        assert!(Discrete::new([1.0, -0.5]).is_none());
        assert!(Discrete::new([f64::NAN]).is_none());
    }

    #[test]
    fn a_last_weight_of_zero_is_never_chosen() {
        let d = Discrete::new([0.1, 0.2, 0.3, 0.0]).unwrap();
        assert!(d.sample(1.0 - f32::EPSILON / 2.0).1 > 0.0);
    }
}
