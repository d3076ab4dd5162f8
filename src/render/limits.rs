//! Limits of a render that a user sets, with defaults if no limit is set.

use super::driver::{ErrorTarget, StopCriteria};
use super::error_estimate::Confidence;
use crate::integrate::{Algorithm, Integrator};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Estimated relative error at which a render without limits ends.
pub const DEFAULT_TARGET_ERROR: f64 = 0.03;

/// Estimated relative error at which a preview ends.
pub const PREVIEW_TARGET_ERROR: f64 = 0.1;

/// Wall time after which a render without limits ends: five minutes.
pub const DEFAULT_TIME_LIMIT: Duration = Duration::from_secs(5 * 60);

/// Limits of a render. The render ends at the first limit that it reaches.
///
/// Without `max_passes`, `time_limit` and `target_error`, the render ends after
/// [`DEFAULT_TIME_LIMIT`], or when its error has fallen to [`DEFAULT_TARGET_ERROR`] (a preview:
/// [`PREVIEW_TARGET_ERROR`]). If bias alone keeps the error above this default target, the render
/// ends once its noise is at most the target.
///
/// A render without error estimates ignores `target_error` and `preview`. Without `max_passes` and
/// `time_limit`, it makes [`Algorithm::default_passes`] passes. Ray casting makes
/// [`Algorithm::default_passes`] passes even with a `time_limit`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderLimits {
    /// Largest number of passes; `None` for no limit.
    pub max_passes: Option<u32>,
    /// Wall time of the render; `None` for no limit. See [`StopCriteria::time_limit`].
    pub time_limit: Option<Duration>,
    /// Estimated relative error at which the render ends; `None` for no limit. See [`ErrorTarget`].
    pub target_error: Option<f64>,
    /// Required probability that the true error is at most the target error, when the render ends
    /// because of that target.
    pub confidence: Confidence,
    /// True for a preview, which ends at [`PREVIEW_TARGET_ERROR`] unless `target_error` is set.
    pub preview: bool,
}

impl RenderLimits {
    /// True if no limit is set, so that the defaults decide when the render ends.
    #[must_use]
    pub fn are_default(&self) -> bool {
        self.max_passes.is_none() && self.time_limit.is_none() && self.target_error.is_none()
    }

    /// Converts the limits to the stop criteria of a render by `integrator`, which `algorithm`
    /// prepared.
    ///
    /// Errors are estimated if [`Integrator::estimates_error`] is true.
    #[must_use]
    pub fn stop_criteria<'a>(
        &self,
        algorithm: Algorithm,
        integrator: &dyn Integrator,
        interrupted: &'a AtomicBool,
    ) -> StopCriteria<'a> {
        let mut stop = StopCriteria {
            max_passes: self.max_passes,
            time_limit: self.time_limit,
            ..StopCriteria::unlimited(interrupted)
        };
        if !integrator.estimates_error() {
            // A second pass of ray casting would repeat the first.
            if self.time_limit.is_none() || algorithm == Algorithm::Raycast {
                stop.max_passes = self.max_passes.or(Some(algorithm.default_passes()));
            }
            return stop;
        }
        let default_error = match (self.preview, self.are_default()) {
            (true, _) => Some(PREVIEW_TARGET_ERROR),
            (false, true) => Some(DEFAULT_TARGET_ERROR),
            (false, false) => None,
        };
        let error = self.target_error.or(default_error);
        stop.target = error.map(|error| ErrorTarget { error, confidence: self.confidence });
        if self.are_default() {
            (stop.time_limit, stop.ends_at_bias_floor) = (Some(DEFAULT_TIME_LIMIT), true);
        }
        stop
    }
}

#[cfg(test)]
mod tests;
