//! Time in which methods reach an error, and the method with the smallest error after a time.

use super::slopes::{ConvergenceFit, SlopeEstimate};
use super::verdict::ConvergenceVerdict;
use crate::study::methods::{ConvergenceCheckpoint, MethodResult, MethodStudyResult};

/// Limit of extrapolation: a predicted time counts as unknown if it exceeds this factor times the
/// processor time of the method's last checkpoint.
///
/// The confidence interval of a predicted time p is also limited: to at least p divided by this
/// factor, and at most p times this factor.
pub const MAX_EXTRAPOLATION_FACTOR: f64 = 1000.0;

/// Assumed log-log slope of noise over time if no slope could be fitted. The noise of a mean of n
/// independent passes falls as n^−½.
const DEFAULT_NOISE_SLOPE: f64 = -0.5;

/// Time and work that a method takes to reach a given error.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RenderEffort {
    /// Processor time of the passes, without preparation \[s].
    #[serde(rename = "seconds")]
    pub cpu_seconds: f64,
    /// Number of passes; not a whole number if it is interpolated.
    pub passes: f64,
    /// Number of emitted photon paths.
    #[serde(rename = "photons")]
    pub photon_paths: f64,
}

impl RenderEffort {
    fn effort_at_checkpoint(checkpoint: &ConvergenceCheckpoint) -> Self {
        Self {
            cpu_seconds: checkpoint.cpu_seconds,
            passes: f64::from(checkpoint.passes),
            photon_paths: checkpoint.photon_paths,
        }
    }

    fn scaled_by(self, factor: f64) -> Self {
        Self {
            cpu_seconds: self.cpu_seconds * factor,
            passes: self.passes * factor,
            photon_paths: self.photon_paths * factor,
        }
    }

    /// Interpolates each number between `a` (`t` = 0) and `b` (`t` = 1): logarithmically if both
    /// numbers are positive, else linearly.
    fn interpolate_effort(a: Self, b: Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| if a > 0.0 && b > 0.0 { a * libm::pow(b / a, t) } else { a + (b - a) * t };
        Self {
            cpu_seconds: mix(a.cpu_seconds, b.cpu_seconds),
            passes: mix(a.passes, b.passes),
            photon_paths: mix(a.photon_paths, b.photon_paths),
        }
    }
}

/// Time and work to reach a given error: measured, predicted, or a reason why they are not known.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(tag = "how", rename_all = "lowercase")]
pub enum TimeToError {
    /// The method reaches the given error already at its first checkpoint. Holds the time and work
    /// of that checkpoint, which are upper bounds.
    Within(RenderEffort),
    /// The method reaches the given error between two checkpoints. Holds time and work,
    /// interpolated between the last checkpoint with a larger error and the checkpoint after it.
    Measured(RenderEffort),
    /// The method has not yet reached the given error at its last checkpoint. Holds time and work,
    /// extrapolated from that checkpoint by the fitted slope.
    Predicted {
        /// Time and work at which the extrapolated error equals the given error.
        effort: RenderEffort,
        /// Confidence interval of the predicted processor time \[s]. Each end of the slope's
        /// confidence interval gives one end of this interval; `None` if the slope has no interval.
        ///
        /// The interval is limited to the time of `effort`, divided and multiplied by
        /// [`MAX_EXTRAPOLATION_FACTOR`].
        #[serde(rename = "seconds")]
        cpu_seconds_interval: Option<[f64; 2]>,
    },
    /// The method never reaches the given error, because a bias remains that is at least as large.
    Never {
        /// Relative bias that remains after any number of passes.
        floor: f64,
    },
    /// Time and work are unknown. No slope is fitted, the error of the method does not fall, or the
    /// predicted time exceeds a limit: [`MAX_EXTRAPOLATION_FACTOR`] times the time of the last
    /// checkpoint.
    Unknown,
}

/// Returns the time and work after which the relative error of `method` is at most `error` and
/// stays there.
///
/// `fit` holds the fitted slopes of `method`. `verdict` tells how the error of `method` falls, and
/// whether a bias remains.
#[must_use]
pub fn time_to_error(
    method: &MethodResult,
    fit: Option<&ConvergenceFit>,
    verdict: &ConvergenceVerdict,
    error: f64,
) -> TimeToError {
    let checkpoints = &method.checkpoints;
    let above = |c: &ConvergenceCheckpoint| c.mean_relative_squared_error() > error * error;
    let Some(last_above) = checkpoints.iter().rposition(above) else {
        return checkpoints
            .first()
            .map_or(TimeToError::Unknown, |first| TimeToError::Within(RenderEffort::effort_at_checkpoint(first)));
    };
    let before = &checkpoints[last_above];
    let Some(after) = checkpoints.get(last_above + 1) else {
        return extrapolate_time_to_error(before, fit, verdict, error);
    };
    let [log_before, log_after] = [before, after].map(|c| 0.5 * libm::log(c.mean_relative_squared_error()));
    // If the squared error at `after` is not positive, its logarithm is unknown. Then take the time
    // and work of `after`.
    let t = if log_after.is_finite() { (log_before - libm::log(error)) / (log_before - log_after) } else { 1.0 };
    TimeToError::Measured(RenderEffort::interpolate_effort(
        RenderEffort::effort_at_checkpoint(before),
        RenderEffort::effort_at_checkpoint(after),
        t,
    ))
}

fn extrapolate_time_to_error(
    last: &ConvergenceCheckpoint,
    fit: Option<&ConvergenceFit>,
    verdict: &ConvergenceVerdict,
    error: f64,
) -> TimeToError {
    let floor = match verdict {
        ConvergenceVerdict::Plateau { floor, .. } => Some(*floor),
        ConvergenceVerdict::Expected { bias_floor, .. } => *bias_floor,
        ConvergenceVerdict::TooFewCheckpoints
        | ConvergenceVerdict::ErrorTooSmall { .. }
        | ConvergenceVerdict::NoInterval { .. }
        | ConvergenceVerdict::Undecided { .. }
        | ConvergenceVerdict::BiasHidden { .. }
        | ConvergenceVerdict::Slower { .. }
        | ConvergenceVerdict::Faster { .. } => None,
    };
    if let Some(floor) = floor.filter(|floor| *floor >= error) {
        return TimeToError::Never { floor };
    }
    // If a constant bias remains, only the noise falls: extrapolate the noise alone.
    let (slopes, square, target) = match floor {
        Some(floor) => (
            fit.and_then(|fit| fit.noise),
            last.mean_relative_squared_error() - floor * floor,
            error * error - floor * floor,
        ),
        None => (fit.and_then(|fit| fit.error), last.mean_relative_squared_error(), error * error),
    };
    let slope = match (slopes, floor) {
        (Some(slopes), _) => slopes.by_time,
        (None, Some(_)) => SlopeEstimate { value: DEFAULT_NOISE_SLOPE, confidence_interval: None },
        (None, None) => return TimeToError::Unknown,
    };
    let ratio = (square / target).max(1.0).sqrt();
    let factor = |slope: f64| if slope < 0.0 { libm::pow(ratio, -1.0 / slope) } else { f64::INFINITY };
    let predicted = factor(slope.value);
    if predicted > MAX_EXTRAPOLATION_FACTOR {
        return TimeToError::Unknown;
    }
    let limits = [predicted / MAX_EXTRAPOLATION_FACTOR, predicted * MAX_EXTRAPOLATION_FACTOR]
        .map(|factor| last.cpu_seconds * factor);
    let end = |slope: f64| (last.cpu_seconds * factor(slope)).clamp(limits[0], limits[1]);
    let effort = RenderEffort::effort_at_checkpoint(last).scaled_by(predicted);
    TimeToError::Predicted { effort, cpu_seconds_interval: slope.confidence_interval.map(|ends| ends.map(end)) }
}

/// Returns the time and work after which the error of `method` is 1/10 of its error at the last
/// checkpoint. The result is extrapolated from that checkpoint.
#[must_use]
pub fn time_to_tenth_of_error(
    method: &MethodResult,
    fit: Option<&ConvergenceFit>,
    verdict: &ConvergenceVerdict,
) -> TimeToError {
    match method.checkpoints.last() {
        Some(last) if last.mean_relative_squared_error() > 0.0 => {
            extrapolate_time_to_error(last, fit, verdict, 0.1 * last.mean_relative_squared_error().sqrt())
        }
        _ => TimeToError::Unknown,
    }
}

/// Returns the relative error of `method` after `seconds` of processor time, interpolated between
/// checkpoints or extrapolated from the last one.
///
/// `None` in three cases. The time is before the first checkpoint. The time is after the last
/// checkpoint, and no slope of the error is fitted. The estimated squared error of a checkpoint
/// that is needed is not positive.
#[must_use]
pub fn error_after_cpu_seconds(method: &MethodResult, fit: Option<&ConvergenceFit>, seconds: f64) -> Option<f64> {
    let error = |c: &ConvergenceCheckpoint| Some(c.mean_relative_squared_error()).filter(|s| *s > 0.0).map(f64::sqrt);
    let after = method.checkpoints.iter().position(|c| c.cpu_seconds >= seconds);
    let last = method.checkpoints.last()?;
    match after {
        Some(i) if method.checkpoints[i].cpu_seconds == seconds => error(&method.checkpoints[i]),
        Some(0) => None,
        Some(i) => {
            let [a, b] = [&method.checkpoints[i - 1], &method.checkpoints[i]];
            let (ea, eb) = (error(a)?, error(b)?);
            Some(ea * libm::pow(eb / ea, libm::log(seconds / a.cpu_seconds) / libm::log(b.cpu_seconds / a.cpu_seconds)))
        }
        None => {
            let slope = fit?.error?.by_time.value.min(0.0);
            Some(error(last)? * libm::pow(seconds / last.cpu_seconds, slope))
        }
    }
}

/// Checkpoint (measurement of a method after a number of passes) on the Pareto front of time and
/// error: every other checkpoint, of any method, takes more time or has a larger error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ParetoPoint {
    /// Index of the method in the list of the study's methods.
    #[serde(rename = "method")]
    pub method_index: usize,
    /// Index of the checkpoint in [`MethodResult::checkpoints`].
    #[serde(rename = "checkpoint")]
    pub checkpoint_index: usize,
}

/// Returns the Pareto front of error and time over the checkpoints of all methods, in the order of
/// time.
///
/// Checkpoints whose estimated squared error is not positive are left out.
#[must_use]
pub fn pareto_front(methods: &[MethodResult]) -> Vec<ParetoPoint> {
    let mut all: Vec<(f64, f64, ParetoPoint)> = Vec::new();
    for (method_index, method) in methods.iter().enumerate() {
        let points = method.checkpoints.iter().enumerate().filter(|(_, c)| c.mean_relative_squared_error() > 0.0);
        all.extend(points.map(|(checkpoint_index, c)| {
            (c.cpu_seconds, c.mean_relative_squared_error(), ParetoPoint { method_index, checkpoint_index })
        }));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    all.retain(|(_, square, _)| {
        let better = *square < least;
        least = least.min(*square);
        better
    });
    all.into_iter().map(|(_, _, point)| point).collect()
}

/// Recommended method: the method with the smallest expected error after the time budget of a
/// study.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MethodRecommendation {
    /// Index of the method in the list of the study's methods.
    #[serde(rename = "method")]
    pub method_index: usize,
    /// Relative error that the method is expected to have after the time budget.
    #[serde(rename = "error")]
    pub expected_error: f64,
    /// Indices of the methods, other than `method_index`, whose expected error is at most 10 %
    /// larger than `expected_error`.
    #[serde(rename = "alike")]
    pub similar_method_indices: Vec<usize>,
}

/// Returns the method with the smallest expected error after the time budget of the study; `None`
/// if no error is known.
///
/// `fits` holds the fitted slopes of each method of `result`.
#[must_use]
pub fn recommend_method(result: &MethodStudyResult, fits: &[Option<ConvergenceFit>]) -> Option<MethodRecommendation> {
    let errors: Vec<(usize, f64)> = result
        .methods
        .iter()
        .zip(fits)
        .enumerate()
        .filter_map(|(i, (method, fit))| {
            Some((i, error_after_cpu_seconds(method, fit.as_ref(), result.max_cpu_seconds_per_seed)?))
        })
        .collect();
    let (method, error) = errors.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let alike = errors.iter().filter(|(i, e)| *i != method && *e <= 1.1 * error).map(|(i, _)| *i).collect();
    Some(MethodRecommendation { method_index: method, expected_error: error, similar_method_indices: alike })
}
