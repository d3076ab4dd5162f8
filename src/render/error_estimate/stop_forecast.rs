//! Forecast of the pass after which a render reaches an error target.
//!
//! A render ends once the upper end of its error interval is at most the target. The forecast is a
//! Monte Carlo simulation of 64 imagined renders that follow this rule; no picture is rendered.
//! Each imagined render has one [`ForecastDraw`], which gives values to the unknown quantities: the
//! expected noise, the expected blur, the exponent of the decay of blur, and the noise of later
//! blur estimates. From these, the forecast computes the upper end after each later pass, and so
//! the last pass of the imagined render.
//!
//! Blur is the bias of photon density estimates. D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for
//! the density estimate L(r) with gather radius r. ‖D₀‖² and ‖D₁‖² are their mean squares over the
//! picture. The blur is extrapolated from D₀ and D₁, see [`NestedDifferenceMoments`].

use super::blur::{BlurEstimate, NestedDifferenceMoments, PRODUCT_RATIO_AT_LIGHT_EDGE};
use super::confidence::Confidence;
use super::disc_area_sums::DiscAreaSums;
use super::estimator::MIN_ERROR_ESTIMATE_PASSES;
use super::forecast::{ErrorForecast, MAX_FORECAST_PASSES};
use super::schedule::EstimateSchedule;
use super::squared_error::SquaredErrorParts;
use std::sync::LazyLock;

/// Probability that the number of passes at which a render ends lies in the forecast [`PassRange`].
pub const RANGE_PROBABILITY: f64 = 0.8;

/// Largest number of passes that a forecast considers, divided by the number of passes made so far.
const MAX_EXTRAPOLATION: u32 = 1000;

/// Number of imagined renders of a forecast. Each is a simulated run of the render, with its own
/// random values of the unknown quantities.
const DRAW_COUNT: usize = 64;

/// Relative standard deviation of the error in the predicted noise variance after many more passes.
/// The error is due to the forecast's inexact model of noise.
const NOISE_MODEL_DEVIATION: f64 = 0.2;

/// Exponent e of the prior for the unknown blur: ‖D₀‖² has the prior density (‖D₀‖²)^−e. D₀ = L(r)
/// − L(r/√2), for the density estimate L(r) with gather radius r.
///
/// With e = 0, large blur is likely while noise still hides it. With e = 1, all probability is at
/// zero blur.
const PRIOR_EXPONENT: f64 = 0.5;

/// Possible exponents p of the decay of blur. Blur is proportional to the gather disc area to the
/// power p: ¼ at edges, 1 in smooth light. All are equally likely a priori.
const BLUR_EXPONENTS: [f64; 5] = [0.25, 0.4375, 0.625, 0.8125, 1.0];

/// Weight that is added to the relative likelihood of each exponent of [`BLUR_EXPONENTS`], so that
/// none is excluded. The most likely exponent has the likelihood 1.
const ADDED_EXPONENT_WEIGHT: f64 = 1e-3;

/// Forecast of the number of passes after which a render reaches its error target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopForecast {
    /// The target is reached after a number of passes in this range.
    Passes(PassRange),
    /// The target is never reached, because bias keeps the error above it.
    Never {
        /// Relative bias that remains after any number of passes.
        floor: f64,
    },
    /// The target is reached after more passes than can be predicted from the passes made so far.
    TooFar {
        /// Lower bound of the number of passes: with a probability of at most 10 %, the render ends
        /// after fewer passes.
        at_least: u32,
    },
}

/// Predicted range of the number of passes at which the render ends. The true number lies in the
/// range with the probability [`RANGE_PROBABILITY`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassRange {
    /// Lower end of the range: the 10 % quantile.
    pub low: u32,
    /// Median of the predicted number of passes.
    pub median: u32,
    /// Upper end of the range: the 90 % quantile; `None` if this end is too far to predict.
    pub high: Option<u32>,
}

/// Random numbers for one imagined render of a forecast (a simulated run of the render), one for
/// each unknown quantity.
struct ForecastDraw {
    /// Standard normal variate that determines the expected noise of the picture.
    noise_variate: f64,
    /// Uniform variate that determines the exponent of [`BLUR_EXPONENTS`] by which blur decays.
    exponent_variate: f64,
    /// Uniform variate that determines the expected blur of the picture.
    blur_variate: f64,
    /// Standard normal variate that determines the noise of blur estimates after later passes.
    later_blur_variate: f64,
}

/// Unknown quantities of the blur (bias of photon density estimates), as drawn for one imagined
/// render of a forecast.
#[derive(Clone, Copy)]
struct DrawnBlur {
    /// Index in [`BLUR_EXPONENTS`] of the exponent by which blur decays.
    exponent_index: usize,
    /// Expected ‖D₀‖² after the passes made so far: the mean square over the picture of D₀ = L(r) −
    /// L(r/√2), for the density estimate L(r) with gather radius r.
    d0_squared: f64,
}

/// The [`DRAW_COUNT`] draws of every forecast. The values of `noise_variate` are stratified. The
/// other three numbers are points of a quasirandom additive recurrence (Roberts 2018, "The
/// unreasonable effectiveness of quasirandom sequences").
static ALL_DRAWS: LazyLock<Vec<ForecastDraw>> = LazyLock::new(|| {
    // Positive root of x⁴ = x + 1.
    let root: f64 = 1.220_744_084_605_759_5;
    let steps = [1.0 / root, 1.0 / (root * root), 1.0 / (root * root * root)];
    let draw = |i: usize| {
        let [exponent_choice, blur, later_blur] = steps.map(|step| (0.5 + i as f64 * step).fract());
        let noise = (i as f64 + 0.5) / DRAW_COUNT as f64;
        ForecastDraw {
            noise_variate: normal_quantile(noise),
            exponent_variate: exponent_choice,
            blur_variate: blur,
            later_blur_variate: normal_quantile(later_blur),
        }
    };
    (0..DRAW_COUNT).map(draw).collect()
});

/// Returns the quantile of the standard normal distribution at `probability` in (0, 1): −1.96 at
/// 0.025.
fn normal_quantile(probability: f64) -> f64 {
    let half_width = Confidence::new((2.0 * probability - 1.0).abs()).map_or(0.0, Confidence::gaussian_half_width);
    half_width.copysign(probability - 0.5)
}

impl ErrorForecast {
    /// Predicts the number of passes after which the upper end of a render's error interval is at
    /// most `target`, so that the render ends.
    ///
    /// `confidence` is the confidence of the interval. The render is assumed to estimate its error
    /// after the passes of [`EstimateSchedule`].
    #[must_use]
    pub fn stop_forecast(&self, target: f64, confidence: Confidence) -> StopForecast {
        if let Some(floor) = self.bias_floor().filter(|floor| *floor >= target) {
            return StopForecast::Never { floor };
        }
        let half_width = confidence.gaussian_half_width();
        let ends = self.ends_of_draws(target, half_width);
        let quantile = |fraction: f64| ends[(fraction * (DRAW_COUNT - 1) as f64).round() as usize];
        let tail = 0.5 * (1.0 - RANGE_PROBABILITY);
        let [low, median, high] = [tail, 0.5, 1.0 - tail].map(quantile);
        match (low, median) {
            (Some(low), Some(median)) => StopForecast::Passes(PassRange { low, median, high }),
            _ => StopForecast::TooFar { at_least: low.unwrap_or_else(|| self.max_imagined_passes()) },
        }
    }

    /// Returns the largest number of passes that this forecast considers: [`MAX_EXTRAPOLATION`]
    /// times the passes made so far, but at most [`MAX_FORECAST_PASSES`].
    fn max_imagined_passes(&self) -> u32 {
        self.estimate.passes.saturating_mul(MAX_EXTRAPOLATION).min(MAX_FORECAST_PASSES)
    }

    /// Returns the numbers of passes after which the imagined renders end, in ascending order. Each
    /// imagined render is a simulated run with one draw of the unknown quantities.
    ///
    /// A render ends once the upper end of its error interval is at most `target`. `half_width` is
    /// the half width of the interval, in standard deviations of the squared error. Renders that
    /// end beyond [`max_imagined_passes`](Self::max_imagined_passes) come last, as `None`.
    fn ends_of_draws(&self, target: f64, half_width: f64) -> Vec<Option<u32>> {
        let made = self.estimate.passes;
        let ended = self.estimate.parts.error_interval(half_width).1 <= target;
        let possible = if ended { MIN_ERROR_ESTIMATE_PASSES..=made } else { made + 1..=self.max_imagined_passes() };
        let (weights, densities) = (self.cumulative_exponent_weights(), self.d0_squared_distribution());
        let mut sums = BLUR_EXPONENTS.map(|exponent| DiscAreaSums::new(self.alpha, exponent));
        let sums_so_far = BLUR_EXPONENTS.map(|exponent| DiscAreaSums::of_passes(self.alpha, exponent, made));
        let blurs = ALL_DRAWS.iter().map(|draw| DrawnBlur {
            exponent_index: cumulative_index(&weights, draw.exponent_variate),
            d0_squared: quantile_at(&densities, draw.blur_variate),
        });
        let blurs: Vec<DrawnBlur> = blurs.collect();
        let mut ends = vec![None; DRAW_COUNT];
        let due = EstimateSchedule::due_passes().skip_while(|n| n < possible.start());
        for passes in due.take_while(|n| possible.contains(n)) {
            sums.iter_mut().for_each(|sums| sums.advance_to(passes));
            for ((end, draw), blur) in ends.iter_mut().zip(ALL_DRAWS.iter()).zip(&blurs) {
                if end.is_none() {
                    let index = blur.exponent_index;
                    let parts = self.imagined_parts(draw, *blur, &sums[index], &sums_so_far[index]);
                    *end = (parts.error_interval(half_width).1 <= target).then_some(passes);
                }
            }
            if ends.iter().all(Option::is_some) {
                break;
            }
        }
        // A render that has reached its target ended no later than after the passes made so far.
        if ended {
            ends.iter_mut().for_each(|end| *end = end.or(Some(made)));
        }
        ends.sort_by_key(|end| end.unwrap_or(u32::MAX));
        ends
    }

    /// Returns the parts of the squared error that an imagined render would estimate after
    /// `sums.passes` passes. The imagined render is a simulated run with the random numbers `draw`.
    ///
    /// `sums` holds the disc areas of these passes, and `sums_so_far` those of the passes made so
    /// far. `blur.d0_squared` is the expected ‖D₀‖² after the passes made so far. ‖D₀‖² is the mean
    /// square over the picture of D₀ = L(r) − L(r/√2), for the density estimate L(r) with gather
    /// radius r.
    fn imagined_parts(
        &self,
        draw: &ForecastDraw,
        blur: DrawnBlur,
        sums: &DiscAreaSums,
        sums_so_far: &DiscAreaSums,
    ) -> SquaredErrorParts {
        let parts = &self.estimate.parts;
        let (n, made) = (f64::from(sums.passes), f64::from(sums_so_far.passes));
        let distance = 1.0 - n.min(made) / n.max(made);
        let deviation = (parts.noise_estimate_relative_variance
            + NOISE_MODEL_DEVIATION * NOISE_MODEL_DEVIATION * distance * distance)
            .sqrt();
        let noise = self.squared_noise(sums) * libm::exp(draw.noise_variate * deviation);
        let blur = self.imagined_blur(draw, blur, sums, sums_so_far);
        SquaredErrorParts {
            noise,
            noise_estimate_relative_variance: parts.noise_estimate_relative_variance * made / n,
            blur: blur.squared_blur,
            blur_variance: blur.squared_blur_variance,
            shared_paths_variance: parts.shared_paths_variance * made / n,
            clamping_variance: parts.clamping_variance * made / n,
            ..*parts
        }
    }

    /// Returns the blur that an imagined render would estimate after `sums.passes` passes. The
    /// imagined render is a simulated run with the random numbers `draw`.
    ///
    /// Blur is the bias of photon density estimates. `sums` holds the disc areas of these passes,
    /// and `sums_so_far` those of the passes made so far. `blur.d0_squared` is the expected ‖D₀‖²
    /// after the passes made so far. ‖D₀‖² is the mean square over the picture of D₀ = L(r) −
    /// L(r/√2), for the density estimate L(r) with gather radius r.
    fn imagined_blur(
        &self,
        draw: &ForecastDraw,
        blur: DrawnBlur,
        sums: &DiscAreaSums,
        sums_so_far: &DiscAreaSums,
    ) -> BlurEstimate {
        let measured = &self.estimate.difference_moments;
        if measured.d0_variance <= 0.0 && blur.d0_squared <= 0.0 {
            return BlurEstimate::default();
        }
        let n = f64::from(sums.passes);
        let decay = (sums.area_power_sum / n) / (sums_so_far.area_power_sum / f64::from(sums_so_far.passes));
        let growth = (sums.inverse_area_sum / n) / (sums_so_far.inverse_area_sum / f64::from(sums_so_far.passes));
        let (expected, variance) = (blur.d0_squared * decay * decay, measured.d0_variance * growth);
        let d0_squared_variance = NestedDifferenceMoments::d0_squared_variance(
            expected,
            variance,
            measured.squared_noise_relative_variance,
            n,
        );
        let d0_squared = expected + draw.later_blur_variate * d0_squared_variance.sqrt();
        let squared = squared_difference_ratio(BLUR_EXPONENTS[blur.exponent_index]);
        let smooth_to_edge = (squared - 0.25) / (squared_difference_ratio(BLUR_EXPONENTS[0]) - 0.25);
        let correlation = 0.5 + (PRODUCT_RATIO_AT_LIGHT_EDGE - 0.5) * smooth_to_edge;
        let trust = measured.measurement_weight();
        let correlation =
            if trust > 0.0 { correlation + trust * (measured.product_ratio() - correlation) } else { correlation };
        BlurEstimate::from_differences(&NestedDifferenceMoments {
            d0_squared,
            d0_d1: correlation * d0_squared,
            d1_squared: squared * d0_squared,
            d0_variance: variance,
            d0_squared_variance,
            squared_noise_relative_variance: measured.squared_noise_relative_variance,
        })
    }

    /// Returns the cumulative probabilities of the exponents [`BLUR_EXPONENTS`], given the measured
    /// blur. The probabilities are not normalized, so the last one need not be 1.
    ///
    /// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather
    /// radius r. An exponent p predicts ‖D₁‖² = 2^(−2p) ‖D₀‖². The difference between this
    /// prediction and the measured ‖D₁‖² gives the likelihood of p. The estimates of ‖D₁‖² and
    /// ‖D₀‖² have about the same variance.
    fn cumulative_exponent_weights(&self) -> [f64; BLUR_EXPONENTS.len()] {
        let measured = &self.estimate.difference_moments;
        // Least variance of the difference. It lets a noise-free measured ratio that lies between
        // the ratios of two neighboring exponents fit both exponents.
        let rounding = 1e-4 * measured.d0_squared * measured.d0_squared;
        let square = |exponent: f64| {
            let ratio = squared_difference_ratio(exponent);
            let difference = measured.d1_squared - ratio * measured.d0_squared;
            let variance = (1.0 + ratio * ratio) * measured.d0_squared_variance + rounding;
            if variance > 0.0 { difference * difference / variance } else { 0.0 }
        };
        let squares = BLUR_EXPONENTS.map(square);
        let least = squares.into_iter().fold(f64::INFINITY, f64::min);
        let mut sum = 0.0;
        squares.map(|square| {
            sum += libm::exp(-0.5 * (square - least)) + ADDED_EXPONENT_WEIGHT;
            sum
        })
    }

    /// Returns the posterior distribution of the expected ‖D₀‖², given its measurement: pairs
    /// (value, cumulative probability) in ascending order. The probabilities are not normalized, so
    /// the last one need not be 1.
    ///
    /// D₀ = L(r) − L(r/√2), for the density estimate L(r) with gather radius r. The measured ‖D₀‖²
    /// has Gaussian noise. Its prior density is a power law ([`PRIOR_EXPONENT`]).
    fn d0_squared_distribution(&self) -> Vec<(f64, f64)> {
        const VALUES: i32 = 80;
        const LEAST: f64 = 1e-3;
        let measured = &self.estimate.difference_moments;
        let (d0_squared, deviation) = (measured.d0_squared.max(0.0), measured.d0_squared_variance.sqrt());
        if deviation <= 0.0 {
            return vec![(d0_squared, 1.0)];
        }
        let most = d0_squared / deviation + 5.0;
        let factor = libm::pow(most / LEAST, 1.0 / f64::from(VALUES - 1));
        let (mut low, mut high, mut sum) = (0.0, LEAST, 0.0);
        let mut quantiles = vec![(0.0, 0.0)];
        for _ in 0..VALUES {
            let middle = 0.5 * (low + high);
            let off = middle - measured.d0_squared / deviation;
            sum += libm::exp(-0.5 * off * off) * libm::pow(middle, -PRIOR_EXPONENT) * (high - low);
            quantiles.push((high * deviation, sum));
            (low, high) = (high, high * factor);
        }
        quantiles
    }
}

/// Returns ‖D₁‖² / ‖D₀‖² if blur is proportional to the gather disc area to the power `exponent`.
///
/// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather radius
/// r.
fn squared_difference_ratio(exponent: f64) -> f64 {
    libm::exp2(-2.0 * exponent)
}

/// Returns the first index at which the cumulative weight exceeds `uniform` times the total weight.
fn cumulative_index(cumulative: &[f64], uniform: f64) -> usize {
    let total = cumulative.last().copied().unwrap_or(0.0);
    cumulative.partition_point(|weight| *weight <= uniform * total).min(cumulative.len() - 1)
}

/// Returns the value at which the cumulative weight is `uniform` times the total weight, by linear
/// interpolation. `quantiles` holds pairs (value, cumulative weight).
fn quantile_at(quantiles: &[(f64, f64)], uniform: f64) -> f64 {
    let total = quantiles.last().map_or(0.0, |last| last.1);
    let above = quantiles.partition_point(|(_, weight)| *weight <= uniform * total).min(quantiles.len() - 1);
    let (value, weight) = quantiles[above];
    let (below, below_weight) = quantiles[above.saturating_sub(1)];
    if weight > below_weight {
        below + (value - below) * (uniform * total - below_weight) / (weight - below_weight)
    } else {
        value
    }
}

#[cfg(test)]
mod tests;
