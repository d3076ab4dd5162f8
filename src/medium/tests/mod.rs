//! Tests of media against closed forms.
//!
//! Random numbers come from fixed random keys, so results are deterministic. Tolerances are five
//! standard errors of the mean; a correct estimate exceeds them with probability 6·10⁻⁷.

mod distance_samples;
mod extremes;
mod grids;
mod phase_functions;
mod random_walks;

use super::*;
use crate::sampling::{Key, Purpose};
use rand::rngs::SmallRng;

fn test_rng(n: u64) -> SmallRng {
    Key::new(23).purpose_key(Purpose::Test).child_key(n).rng()
}

/// Running mean and variance of each channel.
#[derive(Default)]
struct RunningMean {
    n: f64,
    sum: DVec3,
    squares: DVec3,
}

impl RunningMean {
    fn add_sample(&mut self, x: DVec3) {
        self.n += 1.0;
        self.sum += x;
        self.squares += x * x;
    }

    /// Asserts that the mean is within five standard errors of `truth`, plus 10⁻⁶ for the rounding
    /// of f32 weights.
    fn assert_near(&self, truth: DVec3, what: &str) {
        self.assert_near_with_value_bound(truth, DVec3::ZERO, what);
    }

    /// Asserts that the mean agrees with `truth`, for values that may be rare and large. `most` is
    /// an upper bound of the values.
    ///
    /// The tolerance is five standard errors plus 29·most/n (empirical Bernstein bound of Maurer
    /// and Pontil 2009, ln(2/δ) = 12.5).
    fn assert_near_with_value_bound(&self, truth: DVec3, most: DVec3, what: &str) {
        let mean = self.sum / self.n;
        for i in 0..3 {
            let error = ((self.squares[i] / self.n - mean[i] * mean[i]).max(0.0) / self.n).sqrt();
            let off = (mean[i] - truth[i]).abs();
            assert!(
                off <= 5.0 * error + 29.0 * most[i] / self.n + 1e-6 * truth[i].abs(),
                "{what}[{i}]: {} ± {error}, not {}",
                mean[i],
                truth[i]
            );
        }
    }
}
