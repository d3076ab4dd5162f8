//! Prediction of the end of a render, from the error estimate of a pilot: a short trial render.

use super::driver::{EndReason, GIVE_UP_BIAS_FACTOR, MIN_PASSES_BEFORE_GIVING_UP, StopCriteria};
use super::error_estimate::{ErrorForecast, StopForecast};

/// Prediction of when and why a render ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedEnd {
    /// Reason for which the render is expected to end.
    pub reason: EndReason,
    /// Expected number of passes at the end.
    pub passes: u32,
    /// Expected relative error of the picture at the end, see
    /// [`ErrorEstimate`](super::error_estimate::ErrorEstimate).
    pub error: f64,
}

impl StopCriteria<'_> {
    /// Returns the expected end of a render whose passes take `pass_seconds` \[s] each; `None` if
    /// no criterion is expected to hold.
    ///
    /// `forecast` extrapolates the error of a pilot, which is a short trial render of the same
    /// scene with the same settings.
    #[must_use]
    pub fn expected_end(&self, forecast: &ErrorForecast, pass_seconds: f64) -> Option<ExpectedEnd> {
        // The render ends after the pass whose end is nearest to the limit, as in `end_reason`.
        let passes_in = |seconds: f64| (seconds / pass_seconds - 0.5).ceil().clamp(1.0, f64::from(u32::MAX)) as u32;
        let by_passes = self.max_passes.map(|passes| (EndReason::Passes, passes));
        let by_time = self.time_limit.map(|limit| {
            let time = limit.saturating_sub(self.time_before_passes);
            (EndReason::Time, passes_in(time.as_secs_f64()).max(self.min_passes))
        });
        let by_error = self.expected_end_by_error(forecast);
        // If two criteria hold after the same pass, the first one in `ends` counts, as in `render`.
        let ends = [by_passes, by_error, by_time];
        let (reason, passes) = ends.into_iter().flatten().min_by_key(|(_, passes)| *passes)?;
        Some(ExpectedEnd { reason, passes, error: forecast.error_after_passes(passes) })
    }

    fn expected_end_by_error(&self, forecast: &ErrorForecast) -> Option<(EndReason, u32)> {
        let target = self.target?;
        match forecast.stop_forecast(target.error, target.interval_confidence()) {
            StopForecast::Passes(range) => Some((EndReason::Target, range.median.max(self.min_passes))),
            StopForecast::Never { floor } if GIVE_UP_BIAS_FACTOR * floor > target.error => {
                let n = if self.has_no_pass_or_time_limit() {
                    MIN_PASSES_BEFORE_GIVING_UP
                } else if self.ends_at_bias_floor {
                    forecast.passes_to_reach_noise(target.error)?.max(MIN_PASSES_BEFORE_GIVING_UP)
                } else {
                    return None;
                };
                Some((EndReason::BiasFloor, n.max(self.min_passes)))
            }
            StopForecast::Never { .. } | StopForecast::TooFar { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests;
