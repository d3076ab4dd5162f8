//! The loop over passes, and when it ends.

use super::error_estimate::{Confidence, ErrorEstimate, ErrorEstimator, ErrorForecast, PassesNeeded};
use super::film::Film;
use crate::integrate::{Integrator, Monitor, PhotonReport, Seconds};
use crate::stats::Counters;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Conditions that end a render; the first one that holds after a pass ends it.
#[derive(Clone, Copy, Debug)]
pub struct StopCriteria<'a> {
    /// Passes before `time` and `target` may end the render; at least one pass is always made.
    pub min_passes: u32,
    /// Largest number of passes.
    pub passes: Option<u32>,
    /// Wall time; the pass in which it elapses is finished.
    pub time: Option<Duration>,
    /// Largest error.
    pub target: Option<ErrorTarget>,
    /// The render ends after the pass in which this becomes true.
    pub interrupted: &'a AtomicBool,
}

/// Requested error of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorTarget {
    /// Relative error (see [`ErrorEstimate`]).
    pub error: f64,
    /// Probability that the true error is at most `error`.
    pub confidence: Confidence,
}

impl ErrorTarget {
    /// Two-sided confidence whose upper end is the one-sided bound with the target's confidence.
    #[must_use]
    pub fn interval_confidence(self) -> Confidence {
        Confidence::new(2.0 * self.confidence.probability() - 1.0).unwrap_or(Confidence::LEAST)
    }
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EndReason {
    /// All passes were made.
    Passes,
    /// The time limit elapsed.
    Time,
    /// The error reached its target.
    Target,
    /// The target cannot be reached, and no other limit was set.
    Floor,
    /// The user interrupted it.
    Interrupted,
}

/// A finished render.
#[derive(Debug)]
pub struct RenderResult {
    /// Sum of all passes.
    pub film: Film,
    /// Error estimator of the passes; `None` if the integrator supports none or it is disabled.
    pub estimator: Option<ErrorEstimator>,
    /// Why the render ended.
    pub ended: EndReason,
    /// Work of all passes.
    pub counters: Counters,
    /// Wall time of all passes, by stage.
    pub seconds: Seconds,
    /// Photons of the global map.
    pub global: PhotonReport,
    /// Photons of the caustic map.
    pub caustic: PhotonReport,
    /// Wall time of the render.
    pub wall: Duration,
}

/// State of a render after a pass.
#[derive(Clone, Copy, Debug)]
pub struct PassProgress {
    /// Passes made.
    pub passes: u32,
    /// Error and its forecast; `None` if the error was not estimated after this pass.
    pub error: Option<(ErrorEstimate, ErrorForecast)>,
}

/// Growth of the number of passes between two error estimates. Each estimate costs a fraction of a
/// pass.
const ESTIMATE_EVERY: f64 = 1.05;

/// Passes before a render may give up its target, and the fraction of the floor that must exceed
/// it.
const GIVE_UP_PASSES: u32 = 16;
const GIVE_UP_MARGIN: f64 = 0.8;

/// Renders passes 0, 1, 2 … of an image of `size` pixels until a criterion of `stop` holds.
///
/// `after_pass` is called after each pass. The error is estimated if the integrator supports it.
pub fn render(
    integrator: &dyn Integrator,
    size: (u32, u32),
    stop: &StopCriteria<'_>,
    monitor: &dyn Monitor,
    mut after_pass: impl FnMut(&PassProgress),
) -> RenderResult {
    let start = Instant::now();
    let mut rendered = RenderResult {
        film: Film::new(size.0, size.1),
        estimator: integrator.nests_estimates().then(|| ErrorEstimator::new(integrator.radius_law())),
        ended: EndReason::Passes,
        counters: Counters::default(),
        seconds: Seconds::default(),
        global: PhotonReport::default(),
        caustic: PhotonReport::default(),
        wall: Duration::ZERO,
    };
    let mut next_estimate = 0.0;
    loop {
        let pass = integrator.pass(rendered.film.passes(), monitor);
        if let Some(estimator) = &mut rendered.estimator {
            estimator.add(&rendered.film, &pass);
        }
        rendered.film.add(&pass.image);
        rendered.counters += pass.counters;
        rendered.seconds += pass.seconds;
        rendered.global += pass.global;
        rendered.caustic += pass.caustic;
        let passes = rendered.film.passes();
        let error = rendered.estimator.as_ref().filter(|_| f64::from(passes) >= next_estimate).and_then(|estimator| {
            next_estimate = ESTIMATE_EVERY * f64::from(passes);
            let confidence = stop.target.map_or(Confidence::default(), ErrorTarget::interval_confidence);
            let estimate = estimator.estimate_with_confidence(&rendered.film, confidence);
            estimator.forecast(&estimate).map(|forecast| (estimate, forecast))
        });
        after_pass(&PassProgress { passes, error });
        let ended = if stop.interrupted.load(Ordering::Relaxed) {
            Some(EndReason::Interrupted)
        } else if stop.passes.is_some_and(|most| passes >= most) || passes == u32::MAX {
            Some(EndReason::Passes)
        } else if passes < stop.min_passes {
            None
        } else if stop.time.is_some_and(|most| start.elapsed() >= most) {
            Some(EndReason::Time)
        } else {
            error.and_then(|(estimate, forecast)| stop.end_reason_by_error(&estimate, &forecast))
        };
        if let Some(ended) = ended {
            rendered.ended = ended;
            rendered.wall = start.elapsed();
            return rendered;
        }
    }
}

impl StopCriteria<'_> {
    /// The reason to end the render because of its error, if any.
    fn end_reason_by_error(&self, estimate: &ErrorEstimate, forecast: &ErrorForecast) -> Option<EndReason> {
        let target = self.target?;
        if estimate.high <= target.error {
            return Some(EndReason::Target);
        }
        let PassesNeeded::Never { floor } = forecast.passes_to_reach(target.error) else { return None };
        let hopeless = estimate.passes >= GIVE_UP_PASSES && GIVE_UP_MARGIN * floor > target.error;
        (hopeless && self.passes.is_none() && self.time.is_none()).then_some(EndReason::Floor)
    }
}

#[cfg(test)]
mod tests;
