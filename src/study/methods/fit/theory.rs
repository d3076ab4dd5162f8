//! Convergence rates from theory.

use super::slopes::least_squares_slope;
use crate::integrate::Algorithm;

/// Quantity that converges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorComponent {
    /// Root of the mean squared error.
    Error,
    /// Noise: differs between seeds.
    Noise,
    /// Bias: common to all seeds.
    Bias,
}

/// Range of slopes; both ends are equal if one law applies.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SlopeRange {
    /// Steepest (most negative) slope.
    pub steepest: f64,
    /// Flattest slope.
    pub flattest: f64,
}

impl SlopeRange {
    fn single(slope: f64) -> Self {
        Self { steepest: slope, flattest: slope }
    }

    fn union(self, o: Self) -> Self {
        Self { steepest: self.steepest.min(o.steepest), flattest: self.flattest.max(o.flattest) }
    }
}

/// Predicted slope of a quantity over `passes` in log-log space; `None` if the quantity is zero.
///
/// Noise of independent passes falls as n^−½. With shrinking radii, pass i has variance 1/shrink(i)
/// and bias shrink(i) relative to the first. The mean of n passes then has Σ 1/shrink(i)/n² and Σ
/// shrink(i)/n (Knaus and Zwicker 2011). Both roots approach n^−⅓ for α = ⅔. Path noise adds the
/// first law, so measured slopes lie between. For `ppm`, the noise of shared camera paths stays.
/// With fixed radii, bias stays. Light that `distributed` and `whitted` leave out stays too.
/// The slopes of estimates in media differ from the laws above by at most ⅒.
#[must_use]
pub fn predicted_slopes(
    algorithm: Algorithm,
    quantity: ErrorComponent,
    passes: &[u32],
    alpha: f64,
) -> Option<SlopeRange> {
    use Algorithm::{Distributed, Hybrid, Path, Pm, Ppm, Raycast, Sppm, Whitted};
    let even = SlopeRange::single(-0.5);
    let [variance, bias] = variance_and_bias_slopes(passes, alpha);
    let noise = match algorithm {
        Sppm | Hybrid => SlopeRange::single(0.5 * variance).union(even),
        // Seeds differ by shared camera paths, which no pass replaces.
        Ppm => SlopeRange::single(0.0).union(even),
        Path | Pm | Distributed | Whitted | Raycast => even,
    };
    let bias = match algorithm {
        Path => None,
        Sppm | Ppm | Hybrid => Some(SlopeRange::single(bias)),
        Pm | Distributed | Whitted | Raycast => Some(SlopeRange::single(0.0)),
    };
    match quantity {
        ErrorComponent::Noise => Some(noise),
        ErrorComponent::Bias => bias,
        ErrorComponent::Error => Some(bias.map_or(noise, |bias| noise.union(bias))),
    }
}

/// Slopes of variance and bias of the mean of passes with shrinking radii.
fn variance_and_bias_slopes(passes: &[u32], alpha: f64) -> [f64; 2] {
    let (mut shrink, mut shrunk, mut grown, mut made) = (1.0, 0.0, 0.0, 0u32);
    let mut logs: [Vec<f64>; 3] = Default::default();
    for &n in passes {
        while made < n {
            if made > 0 {
                shrink *= (f64::from(made) + alpha) / (f64::from(made) + 1.0);
            }
            shrunk += shrink;
            grown += 1.0 / shrink;
            made += 1;
        }
        let n = f64::from(n.max(1));
        for (logs, value) in logs.iter_mut().zip([n, grown / (n * n), shrunk / n]) {
            logs.push(libm::log(value));
        }
    }
    [least_squares_slope(&logs[0], &logs[1]), least_squares_slope(&logs[0], &logs[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{ALPHA, shrink};

    #[test]
    fn radii_that_shrink_fall_by_their_sums() {
        let sum = |n: u32, of: fn(f64) -> f64| (0..n).map(|i| of(shrink(ALPHA, i))).sum::<f64>();
        let [variance, bias] = variance_and_bias_slopes(&[16, 32], ALPHA);
        let expected = [(sum(32, |s| 1.0 / s) / 4.0) / sum(16, |s| 1.0 / s), sum(32, |s| s) / 2.0 / sum(16, |s| s)];
        for (slope, ratio) in [variance, bias].into_iter().zip(expected) {
            assert!((slope - libm::log2(ratio)).abs() < 1e-12, "{slope} {ratio}");
        }
    }

    /// Sums of i^⅓ and i^−⅓ differ from their integrals by a factor of n^−⅔, 2·10⁻³ at 10⁴.
    #[test]
    fn far_out_both_roots_fall_as_a_third() {
        let far: Vec<u32> = (0..4).map(|i| 10_000 << i).collect();
        for (quantity, steepest) in
            [(ErrorComponent::Noise, -0.5), (ErrorComponent::Bias, -1.0 / 3.0), (ErrorComponent::Error, -0.5)]
        {
            let law = predicted_slopes(Algorithm::Sppm, quantity, &far, ALPHA).unwrap();
            assert!((law.flattest + 1.0 / 3.0).abs() < 4e-3 && (law.steepest - steepest).abs() < 4e-3, "{law:?}");
        }
        assert_eq!(predicted_slopes(Algorithm::Ppm, ErrorComponent::Noise, &far, ALPHA).unwrap().flattest, 0.0);
        let stays = predicted_slopes(Algorithm::Sppm, ErrorComponent::Error, &far, 1.0).unwrap();
        assert!((stays.steepest + 0.5).abs() < 1e-9 && stays.flattest.abs() < 1e-9);
    }

    #[test]
    fn mixtures_lie_between() {
        let passes = [4, 8, 16, 32, 64];
        let law = |algorithm, quantity| predicted_slopes(algorithm, quantity, &passes, ALPHA);
        let [variance, _] = variance_and_bias_slopes(&passes, ALPHA);
        for algorithm in [Algorithm::Hybrid, Algorithm::Sppm] {
            assert_eq!(
                law(algorithm, ErrorComponent::Noise),
                Some(SlopeRange { steepest: -0.5, flattest: 0.5 * variance })
            );
        }
        assert_eq!(law(Algorithm::Path, ErrorComponent::Bias), None);
        assert_eq!(law(Algorithm::Path, ErrorComponent::Error), Some(SlopeRange::single(-0.5)));
        assert_eq!(law(Algorithm::Pm, ErrorComponent::Error), Some(SlopeRange { steepest: -0.5, flattest: 0.0 }));
    }
}
