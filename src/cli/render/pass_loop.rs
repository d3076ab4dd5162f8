//! The passes of a render on the command line, with progress on the terminal.

use crate::cli::forecast_text;
use crate::cli::progress::ProgressDisplay;
use crate::integrate::Integrator;
use crate::render::error_estimate::{Confidence, StopForecast};
use crate::render::{ErrorTarget, PassProgress, RenderResult, StopCriteria, render};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Renders passes with the indices `numbers` and adds them to the result `before`. Ends when a
/// criterion of `stop` holds or all these passes are made. Shows progress.
///
/// Lines of progress in plain text show the time since `start`. `after_pass` is called after each
/// pass.
pub(super) fn render_passes(
    before: RenderResult,
    numbers: Range<u32>,
    stop: &StopCriteria<'_>,
    integrator: &dyn Integrator,
    start: Instant,
    progress: &ProgressDisplay,
    mut after_pass: impl FnMut(&PassProgress<'_>),
) -> RenderResult {
    let passes_before = before.film.passes();
    let (passes, target) = (stop.max_passes, stop.target);
    progress.set_pass_number(passes_before + 1, passes);
    // A render with an error target knows its remaining time only after the first error estimate.
    let time_left = stop.time_limit.map(|limit| limit.saturating_sub(stop.time_before_passes));
    progress.set_time_left(time_left.filter(|_| target.is_none()));
    let began = Instant::now();
    render(before, numbers, integrator, stop, progress, |standing| {
        let pass_seconds = began.elapsed().as_secs_f64() / f64::from(standing.passes - passes_before);
        let forecast = standing.error.as_ref().filter(|_| !progress.is_quiet()).map(|(estimate, forecast)| {
            // Without an error target, forecast when the error will be half of the present error.
            let half = ErrorTarget { error: 0.5 * estimate.error, confidence: Confidence::default() };
            let target = target.unwrap_or(half);
            (estimate, target, forecast.stop_forecast(target.error, target.interval_confidence()))
        });
        let error = forecast.as_ref().map(|(estimate, target, forecast)| {
            format!(
                "error {}{}",
                forecast_text::error_text(estimate),
                forecast_text::time_to_target_text(estimate, *target, *forecast, pass_seconds)
            )
        });
        if progress.uses_plain_lines() {
            let of = passes.map_or(String::new(), |n| format!("/{n}"));
            let error = error.as_ref().map_or(String::new(), |error| format!(": {error}"));
            let elapsed = start.elapsed().as_secs_f64();
            progress.print_line(&format!("pass {}{of} after {elapsed:.1} s{error}", standing.passes));
        }
        // After a pass without an error estimate, keep showing the previous remaining time.
        let forecast = forecast.map(|(_, _, forecast)| forecast);
        if let Some(left) = time_until_stop(stop, standing.passes, forecast, began.elapsed(), pass_seconds) {
            progress.set_time_left(Some(left));
        }
        error.into_iter().for_each(|note| progress.set_progress_note(note));
        after_pass(standing);
        if standing.end_reason.is_none() {
            progress.set_pass_number(standing.passes + 1, passes);
        }
    })
}

/// Returns the expected time until the first stop criterion holds. Returns `None` if this time is
/// unknown. For example, there is an error target, but the last pass did not estimate the error.
///
/// `passes` is the number of passes so far. `elapsed` is the time since the first pass of this run
/// began. `pass_seconds` is the mean time of a pass of this run \[s]. `forecast` predicts the
/// number of passes that reach the error target; ignored if `stop` has no target.
fn time_until_stop(
    stop: &StopCriteria<'_>,
    passes: u32,
    forecast: Option<StopForecast>,
    elapsed: Duration,
    pass_seconds: f64,
) -> Option<Duration> {
    if stop.target.is_some() && forecast.is_none() {
        return None;
    }
    let seconds_to_pass = |n: u32| f64::from(n.saturating_sub(passes)) * pass_seconds;
    let by_target = forecast.filter(|_| stop.target.is_some()).and_then(|forecast| match forecast {
        StopForecast::Passes(range) => Some(seconds_to_pass(range.median)),
        StopForecast::Never { .. } | StopForecast::TooFar { .. } => None,
    });
    let elapsed = stop.time_before_passes + elapsed;
    let by_time = stop.time_limit.map(|time| time.saturating_sub(elapsed).as_secs_f64());
    let all = [stop.max_passes.map(seconds_to_pass), by_time, by_target];
    let least = all.into_iter().flatten().min_by(f64::total_cmp)?;
    Duration::try_from_secs_f64(least).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::integrate::{Algorithm, Settings};
    use crate::scene::SceneBuilder;
    use glam::DVec3;
    use indicatif::ProgressBar;
    use std::sync::Mutex;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn pass_number_stays_within_the_pass_limit() {
        let camera = Camera::perspective(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.7, 2, 2).unwrap();
        let scene = SceneBuilder::new().build(camera).unwrap();
        let integrator = Algorithm::Path.prepare(&scene, Settings::default());
        let interrupted = AtomicBool::new(false);
        let stop = StopCriteria { max_passes: Some(2), ..StopCriteria::unlimited(&interrupted) };
        let before = RenderResult::without_passes(integrator.as_ref(), (2, 2));
        let progress = ProgressDisplay::Bar(ProgressBar::hidden(), Mutex::default());
        render_passes(before, 0..u32::MAX, &stop, integrator.as_ref(), Instant::now(), &progress, |_| {});
        let ProgressDisplay::Bar(_, labels) = progress else { unreachable!() };
        assert_eq!(labels.into_inner().unwrap().work, "pass 2/2");
    }

    #[test]
    fn the_first_stop_condition_sets_the_time_left() {
        let interrupted = AtomicBool::new(false);
        let limits = |passes: Option<u32>, time: Option<u64>| {
            let time = time.map(Duration::from_secs);
            StopCriteria { max_passes: passes, time_limit: time, ..StopCriteria::unlimited(&interrupted) }
        };
        let left_of = |stop: StopCriteria<'_>| {
            time_until_stop(&stop, 4, None, Duration::from_secs(8), 2.0).map(|left| left.as_secs())
        };
        let left = |passes, time| left_of(limits(passes, time));
        assert_eq!(left(Some(10), None), Some(12));
        assert_eq!(left(None, Some(10)), Some(2));
        assert_eq!(left(Some(10), Some(10)), Some(2));
        assert_eq!((left(None, None), left(None, Some(1))), (None, Some(0)));
        let late = StopCriteria { time_before_passes: Duration::from_secs(1), ..limits(None, Some(10)) };
        assert_eq!(left_of(late), Some(1));
        let target = Some(ErrorTarget { error: 0.03, confidence: Confidence::default() });
        assert_eq!(left_of(StopCriteria { target, ..limits(Some(10), Some(10)) }), None);
    }
}
