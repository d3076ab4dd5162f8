//! Least-squares slopes of error over time or passes, with bootstrap intervals.

use crate::sampling::{Dimension, Key};
use crate::study::methods::{ConvergenceCheckpoint, MethodResult};

/// Limit of the fit: a line is fitted only to checkpoints (measurements after a number of passes)
/// with at least 1/`MAX_TAIL_PASS_RATIO` of the passes of the last checkpoint.
const MAX_TAIL_PASS_RATIO: u32 = 16;

/// Smallest number of checkpoints to which a line is fitted. A line through two checkpoints would
/// fit exactly, even if the error followed no power law.
const MIN_CHECKPOINTS: usize = 3;

/// Number of bootstrap replicates from which the confidence interval of a slope is computed.
const BOOTSTRAP_REPLICATES: u64 = 1000;

/// Slope of a quantity (error, noise or bias) over time or passes in a log-log plot: the exponent
/// of its power law.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SlopeEstimate {
    /// Slope of the least-squares line through the last checkpoints (measurements after a number of
    /// passes).
    pub value: f64,
    /// 95 % confidence interval of `value`; `None` if the method was rendered with too few seeds,
    /// or if the errors of the seeds vary too much.
    #[serde(rename = "interval")]
    pub confidence_interval: Option<[f64; 2]>,
}

/// Fitted slopes of one quantity (error, noise or bias) over time and over passes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ConvergenceSlopes {
    /// Slope of the quantity (error, noise or bias) over processor time, in a log-log plot.
    pub by_time: SlopeEstimate,
    /// Slope of the quantity (error, noise or bias) over the number of passes, in a log-log plot.
    pub by_passes: SlopeEstimate,
}

/// Slopes of error, noise and bias, fitted to the last checkpoints of a method. A checkpoint is a
/// measurement after a certain number of passes.
///
/// The fit uses the checkpoints with at least 1/16 of the passes of the last checkpoint. The slopes
/// of a quantity are `None` if its estimate is zero or negative at one of these checkpoints.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ConvergenceFit {
    /// Number of passes of each fitted checkpoint.
    #[serde(rename = "passes")]
    pub checkpoint_passes: Vec<u32>,
    /// Slopes of the relative error; `None` if the estimated squared error is not positive at a
    /// fitted checkpoint.
    pub error: Option<ConvergenceSlopes>,
    /// Slopes of the relative noise; `None` if the estimated squared noise is not positive at a
    /// fitted checkpoint.
    pub noise: Option<ConvergenceSlopes>,
    /// Slopes of the relative bias; `None` if the estimated squared bias is not positive at a
    /// fitted checkpoint.
    pub bias: Option<ConvergenceSlopes>,
}

/// Fits slopes to the last checkpoints of a method; `None` if fewer than three checkpoints can be
/// fitted.
#[must_use]
pub fn fit_convergence(method: &MethodResult) -> Option<ConvergenceFit> {
    let tail = checkpoints_to_fit(&method.checkpoints);
    if tail.len() < MIN_CHECKPOINTS {
        return None;
    }
    let seeds = tail.iter().map(|c| c.relative_squared_errors.len()).min().unwrap_or(0);
    let has_noises = tail.iter().all(|c| c.squared_noises.len() >= seeds);
    let mean = |values: &[f64], weights: &[f64]| values.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>();
    // Noise and bias have confidence intervals only if the noise of each seed is known, so that
    // seeds can be resampled.
    let seeds_with_noise = if has_noises { seeds } else { 0 };
    let error = fit_convergence_slopes(tail, seeds, |c, weights| {
        weights.map_or_else(|| c.mean_relative_squared_error(), |w| mean(&c.relative_squared_errors, w))
    });
    let noise = fit_convergence_slopes(tail, seeds_with_noise, |c, weights| {
        weights.map_or(c.squared_noise, |w| mean(&c.squared_noises, w))
    });
    // The mean squared error is bias² + noise².
    let bias = fit_convergence_slopes(tail, seeds_with_noise, |c, weights| {
        weights.map_or(c.squared_bias, |w| mean(&c.relative_squared_errors, w) - mean(&c.squared_noises, w))
    });
    Some(ConvergenceFit { checkpoint_passes: tail.iter().map(|c| c.passes).collect(), error, noise, bias })
}

/// Returns the checkpoints to which lines are fitted: all from the first one that has a positive
/// time and at least 1/16 of the passes of the last checkpoint.
fn checkpoints_to_fit(checkpoints: &[ConvergenceCheckpoint]) -> &[ConvergenceCheckpoint] {
    let last = checkpoints.last().map_or(0, |c| c.passes);
    let early = |c: &&ConvergenceCheckpoint| {
        u64::from(c.passes) * u64::from(MAX_TAIL_PASS_RATIO) < u64::from(last) || c.cpu_seconds <= 0.0
    };
    &checkpoints[checkpoints.iter().take_while(early).count()..]
}

/// Fits log-log slopes of one quantity (error, noise or bias) over time and over passes, through
/// the checkpoints `tail`. Returns `None` if the quantity is not positive at one of them.
///
/// `square` returns the squared quantity at a checkpoint, as a mean over seeds. Its second argument
/// holds the weights of the seeds in this mean; `None` means equal weights.
///
/// Bootstrap replicates with random weights of the seeds give the confidence intervals. The slopes
/// have no intervals with fewer than two `seeds`, or if more than 2.5 % of the replicates cannot be
/// fitted.
fn fit_convergence_slopes(
    tail: &[ConvergenceCheckpoint],
    seeds: usize,
    square: impl Fn(&ConvergenceCheckpoint, Option<&[f64]>) -> f64,
) -> Option<ConvergenceSlopes> {
    let times: Vec<f64> = tail.iter().map(|c| libm::log(c.cpu_seconds)).collect();
    let passes: Vec<f64> = tail.iter().map(|c| libm::log(f64::from(c.passes))).collect();
    let fit_slopes = |weights: Option<&[f64]>| {
        let logs = tail.iter().map(|c| Some(square(c, weights)).filter(|s| *s > 0.0).map(|s| 0.5 * libm::log(s)));
        let logs: Vec<f64> = logs.collect::<Option<_>>()?;
        Some([least_squares_slope(&times, &logs), least_squares_slope(&passes, &logs)])
    };
    let [by_time, by_passes] = fit_slopes(None)?;
    let replicates: Vec<[f64; 2]> = (0..BOOTSTRAP_REPLICATES)
        .filter_map(|replicate| fit_slopes(Some(&bootstrap_seed_weights(replicate, seeds))))
        .collect();
    // Replicates whose `square` is not positive at a checkpoint are missing from `replicates`. A
    // confidence interval needs 97.5 % of all replicates.
    let has_interval = seeds >= 2 && replicates.len() as u64 * 40 >= BOOTSTRAP_REPLICATES * 39;
    let slope = |value: f64, axis: usize| {
        let interval = has_interval.then(|| {
            let half_width = bootstrap_interval_factor(seeds) * standard_deviation(replicates.iter().map(|r| r[axis]));
            [value - half_width, value + half_width]
        });
        SlopeEstimate { value, confidence_interval: interval }
    };
    Some(ConvergenceSlopes { by_time: slope(by_time, 0), by_passes: slope(by_passes, 1) })
}

/// Returns the weight of each seed in bootstrap replicate number `replicate`: `seeds` seeds are
/// drawn with replacement, and the weight of a seed is the fraction of draws that chose it.
fn bootstrap_seed_weights(replicate: u64, seeds: usize) -> Vec<f64> {
    let key = Key::new(0xb007_57a9).child_key(replicate);
    let mut weights = vec![0.0; seeds];
    for draw in 0..seeds {
        weights[(key.child_key(draw as u64).random_bits(Dimension::ReceiverBranch) % seeds as u64) as usize] +=
            1.0 / seeds as f64;
    }
    weights
}

/// Returns the slope of the least-squares line through the points (`x`, `y`).
pub(super) fn least_squares_slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (xy, xx) =
        x.iter().zip(y).fold((0.0, 0.0), |(xy, xx), (x, y)| (xy + (x - mx) * (y - my), xx + (x - mx) * (x - mx)));
    xy / xx
}

fn standard_deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0)).sqrt()
}

/// Returns the factor of bootstrap intervals: the half-width of a 95 % confidence interval, divided
/// by the standard deviation of the bootstrap replicates.
///
/// For S seeds, the factor is the 97.5 % quantile of Student's t distribution times √(S/(S − 1)).
/// The root corrects the variance of the bootstrap, which has the divisor S instead of S − 1
/// (Hesterberg 2015, section 3.1).
fn bootstrap_interval_factor(seeds: usize) -> f64 {
    let degrees = seeds as f64 - 1.0;
    student_t_quantile_975(seeds - 1) * (seeds as f64 / degrees).sqrt()
}

/// Returns the 97.5 % quantile of Student's t distribution with `degrees` degrees of freedom.
pub(super) fn student_t_quantile_975(degrees: usize) -> f64 {
    const SMALL_SAMPLE_QUANTILES: [f64; 10] =
        [12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281];
    let (z, n) = (1.959_964_f64, degrees as f64);
    let (z3, z5) = (z * z * z, z * z * z * z * z);
    // Series of Abramowitz and Stegun 1964, equation 26.7.5, for 11 and more degrees of freedom.
    // Its next term is then below 10⁻³.
    let many = z
        + (z3 + z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
        + (3.0 * z5 * z * z + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n * n * n);
    SMALL_SAMPLE_QUANTILES.get(degrees.wrapping_sub(1)).copied().unwrap_or(many)
}

/// Returns the 95 % confidence interval of the mean of `values` by Student's t distribution; `None`
/// for fewer than two values.
#[must_use]
pub fn mean_confidence_interval(values: &[f64]) -> Option<[f64; 2]> {
    let n = values.len();
    if n < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let half = student_t_quantile_975(n - 1) * standard_deviation(values.iter().copied()) / (n as f64).sqrt();
    Some([mean - half, mean + half])
}

/// Returns the 95 % confidence interval of the squared relative bias at a checkpoint. `None` with
/// fewer than two seeds, or if the noise is known only as a mean over seeds.
pub(super) fn squared_bias_interval(checkpoint: &ConvergenceCheckpoint) -> Option<[f64; 2]> {
    let ConvergenceCheckpoint { relative_squared_errors: squared_errors, squared_noises, .. } = checkpoint;
    (squared_errors.len() == squared_noises.len())
        .then(|| squared_errors.iter().zip(squared_noises).map(|(s, n)| s - n).collect::<Vec<_>>())
        .and_then(|parts| mean_confidence_interval(&parts))
}
