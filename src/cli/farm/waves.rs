//! Size of the next wave of jobs, for a farm render that stops at an error.

use super::division::ShardDivision;
use crate::cli::interrupt::INTERRUPTED;
use crate::render::error_estimate::{BiasPart, StopForecast};
use crate::render::{EndReason, ErrorTarget, PassTimes, RenderResult, StopCriteria};

/// Decision after a wave of jobs: another wave, or the reason why none follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WaveDecision {
    /// Another wave of shards follows. Holds the division of all passes, including those of that
    /// wave.
    Grow(ShardDivision),
    /// No further wave: the error is at most the target.
    TargetReached,
    /// No further wave: bias keeps the error above the target after any number of passes. Holds the
    /// largest part of this bias.
    TargetUnreachable(BiasPart),
    /// No further wave: the total number of passes would exceed `--max-passes`.
    TooManyPasses,
}

/// Decides whether another wave of jobs follows. `rendered` holds the passes so far, and `division`
/// is their division into shards. All waves together make at most `most` passes.
///
/// A wave has at most as many passes as all earlier ones together, because a forecast from few
/// passes is uncertain.
pub(super) fn decide_next_wave(
    rendered: &RenderResult,
    division: ShardDivision,
    target: ErrorTarget,
    most: u32,
) -> WaveDecision {
    let estimated = rendered.estimate_error(Some(target));
    let stop = StopCriteria { target: Some(target), ..StopCriteria::unlimited(&INTERRUPTED) };
    match stop.end_reason(rendered.film.passes(), estimated.as_ref(), PassTimes::default()) {
        Some(EndReason::Target) => return WaveDecision::TargetReached,
        Some(EndReason::BiasFloor) => {
            if let Some(part) = estimated.and_then(|(_, forecast)| forecast.largest_remaining_bias()) {
                return WaveDecision::TargetUnreachable(part);
            }
        }
        Some(EndReason::Passes | EndReason::Time | EndReason::Interrupted) | None => {}
    }
    let forecast = estimated.map(|(_, forecast)| forecast.stop_forecast(target.error, target.interval_confidence()));
    let wanted = match forecast {
        Some(StopForecast::Passes(range)) => range.median.saturating_sub(division.passes),
        Some(StopForecast::Never { .. } | StopForecast::TooFar { .. }) | None => u32::MAX,
    };
    let size = division.passes / division.shards;
    let shards = wanted.div_ceil(size).clamp(1, division.shards);
    // Near the limit `most` of passes, only a smaller wave may fit.
    let fitting = shards.min(most.saturating_sub(division.passes) / size);
    match division.with_more_shards(fitting, most) {
        Some(larger) if fitting > 0 => WaveDecision::Grow(larger),
        _ => WaveDecision::TooManyPasses,
    }
}
