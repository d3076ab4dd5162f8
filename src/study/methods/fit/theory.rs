//! Convergence rates of error, noise and bias that theory predicts for each algorithm.

use super::slopes::least_squares_slope;
use crate::integrate::Algorithm;

/// Total error of a rendering method, or one of its two components: noise and bias.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorComponent {
    /// Root mean square error, with noise and bias.
    Error,
    /// Noise: standard deviation of the picture between seeds.
    Noise,
    /// Bias: error of the mean picture over infinitely many seeds.
    Bias,
}

/// Range of slopes that theory predicts for error, noise or bias over passes, in a log-log plot.
/// Both ends of the range are equal if the quantity follows a single power law.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SlopeRange {
    /// Steepest (most negative) slope.
    pub steepest: f64,
    /// Flattest (largest) slope.
    pub flattest: f64,
}

impl SlopeRange {
    fn single_slope_range(slope: f64) -> Self {
        Self { steepest: slope, flattest: slope }
    }

    fn enclosing_slope_range(self, o: Self) -> Self {
        Self { steepest: self.steepest.min(o.steepest), flattest: self.flattest.max(o.flattest) }
    }
}

/// Returns the range of slopes that theory predicts for error, noise or bias over `passes` in a
/// log-log plot; `None` if the quantity is zero.
///
/// - The noise of independent passes falls as n^−½.
/// - Photon noise and bias follow the gather radii (Knaus and Zwicker 2011). Let s(i) be the
///   squared radius of pass i, divided by that of the first pass: s(i + 1) =
///   s(i) (i + α) / (i + 1), where α is `alpha`. The mean of n passes has variance ∝ Σ 1/s(i)/n²
///   and bias ∝ Σ s(i)/n. For α = ⅔, noise and bias approach n^−⅓.
/// - In `sppm` and `hybrid`, camera paths add noise that falls as n^−½. The sum of this noise and
///   the photon noise follows no single power law, so its slope is a range.
/// - All passes of `ppm` share their camera paths, so the noise of these paths does not fall.
/// - In `hybrid`, later passes take less of the indirect light from photon estimates. So the bias
///   of indirect light falls up to twice as steeply as the bias of caustics.
/// - Bias stays constant with fixed radii (α = 1), and in algorithms that leave out light.
///
/// Measured slopes of light in media differ from the prediction by at most 0.1.
#[must_use]
pub fn predicted_convergence_slopes(
    algorithm: Algorithm,
    quantity: ErrorComponent,
    passes: &[u32],
    alpha: f64,
) -> Option<SlopeRange> {
    use Algorithm::{Distributed, Hybrid, Path, Pm, Ppm, Raycast, Sppm, Whitted};
    let independent = SlopeRange::single_slope_range(-0.5);
    let [variance, bias] = variance_and_bias_slopes(passes, alpha);
    let noise = match algorithm {
        Sppm | Hybrid => SlopeRange::single_slope_range(0.5 * variance).enclosing_slope_range(independent),
        // All passes of `ppm` share the camera paths, so more passes do not reduce the noise of
        // these paths. This noise still differs between seeds.
        Ppm => SlopeRange::single_slope_range(0.0).enclosing_slope_range(independent),
        Path | Pm | Distributed | Whitted | Raycast => independent,
    };
    let bias = match algorithm {
        Path => None,
        Sppm | Ppm => Some(SlopeRange::single_slope_range(bias)),
        // For indirect light, the weight of photon estimates falls as fast as their bias. So the
        // bias of indirect light falls twice as steeply.
        Hybrid => Some(SlopeRange { steepest: 2.0 * bias, flattest: bias }),
        Pm | Distributed | Whitted | Raycast => Some(SlopeRange::single_slope_range(0.0)),
    };
    match quantity {
        ErrorComponent::Noise => Some(noise),
        ErrorComponent::Bias => bias,
        ErrorComponent::Error => Some(bias.map_or(noise, |bias| noise.enclosing_slope_range(bias))),
    }
}

/// Returns the log-log slopes of variance and bias over `passes`, for the mean of passes with
/// shrinking gather radii (Knaus and Zwicker 2011).
///
/// Pass i + 1 has the squared radius of pass i times (i + α) / (i + 1), where α is `alpha`.
fn variance_and_bias_slopes(passes: &[u32], alpha: f64) -> [f64; 2] {
    let (mut squared_radius_ratio, mut ratio_sum, mut inverse_ratio_sum, mut made) = (1.0, 0.0, 0.0, 0u32);
    let mut logs: [Vec<f64>; 3] = Default::default();
    for &n in passes {
        while made < n {
            if made > 0 {
                squared_radius_ratio *= (f64::from(made) + alpha) / (f64::from(made) + 1.0);
            }
            ratio_sum += squared_radius_ratio;
            inverse_ratio_sum += 1.0 / squared_radius_ratio;
            made += 1;
        }
        let n = f64::from(n.max(1));
        for (logs, value) in logs.iter_mut().zip([n, inverse_ratio_sum / (n * n), ratio_sum / n]) {
            logs.push(libm::log(value));
        }
    }
    [least_squares_slope(&logs[0], &logs[1]), least_squares_slope(&logs[0], &logs[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::{DEFAULT_ALPHA, squared_radius_ratio};

    #[test]
    fn variance_and_bias_slopes_match_sums_of_radii() {
        let sum = |n: u32, of: fn(f64) -> f64| (0..n).map(|i| of(squared_radius_ratio(DEFAULT_ALPHA, i))).sum::<f64>();
        let [variance, bias] = variance_and_bias_slopes(&[16, 32], DEFAULT_ALPHA);
        let expected = [(sum(32, |s| 1.0 / s) / 4.0) / sum(16, |s| 1.0 / s), sum(32, |s| s) / 2.0 / sum(16, |s| s)];
        for (slope, ratio) in [variance, bias].into_iter().zip(expected) {
            assert!((slope - libm::log2(ratio)).abs() < 1e-12, "{slope} {ratio}");
        }
    }

    /// For α = ⅔, the slopes of noise and bias approach −⅓. Sums of i^⅓ and i^−⅓ differ from their
    /// integrals by a relative error of n^−⅔, which is 2·10⁻³ at n = 10⁴.
    #[test]
    fn noise_and_bias_approach_slope_minus_one_third() {
        let far: Vec<u32> = (0..4).map(|i| 10_000 << i).collect();
        for (quantity, steepest) in
            [(ErrorComponent::Noise, -0.5), (ErrorComponent::Bias, -1.0 / 3.0), (ErrorComponent::Error, -0.5)]
        {
            let law = predicted_convergence_slopes(Algorithm::Sppm, quantity, &far, DEFAULT_ALPHA).unwrap();
            assert!((law.flattest + 1.0 / 3.0).abs() < 4e-3 && (law.steepest - steepest).abs() < 4e-3, "{law:?}");
        }
        assert_eq!(
            predicted_convergence_slopes(Algorithm::Ppm, ErrorComponent::Noise, &far, DEFAULT_ALPHA).unwrap().flattest,
            0.0
        );
        let stays = predicted_convergence_slopes(Algorithm::Sppm, ErrorComponent::Error, &far, 1.0).unwrap();
        assert!((stays.steepest + 0.5).abs() < 1e-9 && stays.flattest.abs() < 1e-9);
    }

    #[test]
    fn predicted_slopes_of_mixed_noise_are_a_range() {
        let passes = [4, 8, 16, 32, 64];
        let law = |algorithm, quantity| predicted_convergence_slopes(algorithm, quantity, &passes, DEFAULT_ALPHA);
        let [variance, _] = variance_and_bias_slopes(&passes, DEFAULT_ALPHA);
        let mixed = Some(SlopeRange { steepest: -0.5, flattest: 0.5 * variance });
        for algorithm in [Algorithm::Hybrid, Algorithm::Sppm] {
            assert_eq!(law(algorithm, ErrorComponent::Noise), mixed);
        }
        assert_eq!(law(Algorithm::Path, ErrorComponent::Bias), None);
        assert_eq!(law(Algorithm::Path, ErrorComponent::Error), Some(SlopeRange::single_slope_range(-0.5)));
        assert_eq!(law(Algorithm::Pm, ErrorComponent::Error), Some(SlopeRange { steepest: -0.5, flattest: 0.0 }));
    }
}
