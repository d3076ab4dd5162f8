//! The render loop over passes, and the criteria that end it.

use super::error_estimate::{Confidence, ErrorEstimate, ErrorEstimator, ErrorForecast, EstimateSchedule};
use super::film::Film;
use super::merge_error::MergeError;
use super::pass_set::PassSet;
use crate::integrate::{Integrator, LightGroup, PhotonReport, ProgressMonitor, StageTimes};
use crate::stats::Counters;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Criteria that end a render, checked after each pass. The first criterion that holds ends it.
#[derive(Clone, Copy, Debug)]
pub struct StopCriteria<'a> {
    /// Minimum number of passes. Until then, neither `time_limit` nor `target` ends the render.
    pub min_passes: u32,
    /// Largest number of passes; `None` for no limit.
    pub max_passes: Option<u32>,
    /// Wall time of the render; `None` for no limit.
    ///
    /// The render ends after the pass whose end is nearest to the limit. The next pass is expected
    /// to take the mean time of the passes so far.
    pub time_limit: Option<Duration>,
    /// Wall time spent before the first pass, on loading and on pilots (small simulations before
    /// the first pass). This time counts towards `time_limit`.
    pub time_before_passes: Duration,
    /// Error target at which the render ends; `None` for no target.
    pub target: Option<ErrorTarget>,
    /// True to end the render when its noise is at most `target`, but bias alone keeps the error
    /// above `target`.
    ///
    /// A render without limits of passes and time ignores this flag: it always ends if bias keeps
    /// the error above `target`, whatever its noise. In all cases, the render makes at least 16
    /// passes, and ends only if 0.8 times the bias exceeds the target.
    pub ends_at_bias_floor: bool,
    /// Flag that another thread sets to end the render after the current pass.
    pub interrupted: &'a AtomicBool,
}

/// Error target of a render: the render ends once its estimated error is at most `error`, with the
/// probability `confidence`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorTarget {
    /// Relative error, see [`ErrorEstimate`]; 0.01 is 1 %.
    pub error: f64,
    /// Required probability that the true error is at most `error`.
    pub confidence: Confidence,
}

impl ErrorTarget {
    /// Returns the confidence of the two-sided error interval whose upper end exceeds the true
    /// error with the probability `self.confidence`.
    ///
    /// For the one-sided probability p, the two-sided confidence is 2p − 1; for p ≤ ½, it is
    /// [`Confidence::LEAST`].
    #[must_use]
    pub fn interval_confidence(self) -> Confidence {
        Confidence::new(2.0 * self.confidence.probability() - 1.0).unwrap_or(Confidence::LEAST)
    }
}

/// Reason why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EndReason {
    /// The largest number of passes was reached, or all requested passes are rendered.
    Passes,
    /// The time limit was reached: a further pass would not end nearer to the limit.
    Time,
    /// The error target was reached.
    Target,
    /// The error target cannot be reached, because bias exceeds it and more passes do not reduce
    /// the bias.
    #[serde(rename = "floor")]
    BiasFloor,
    /// The user interrupted the render.
    Interrupted,
}

/// Result of a render, or its state after some passes: film, error estimator, counts and times.
#[derive(Debug, Serialize, Deserialize)]
pub struct RenderResult {
    /// Numbers of the passes in `film`, counted from 0.
    pub pass_numbers: PassSet,
    /// Film: for each pixel, the sum of its colors in all passes. The mean over the passes is the
    /// picture.
    pub film: Film,
    /// Error estimator to which the passes were added; `None` if
    /// [`Integrator::estimates_error`] is false.
    pub estimator: Option<ErrorEstimator>,
    /// Films of the light groups, in the order of [`LightGroup::ALL`]. Their mean pictures add up
    /// to the picture. The list is empty unless [`Integrator::groups_light`] is true.
    pub light_group_films: Vec<Film>,
    /// Film of the radiance that clamping removed; `None` without clamping.
    pub clamping_loss_film: Option<Film>,
    /// Reason why the render ended; meaningless while it continues.
    pub end_reason: EndReason,
    /// Counts of rays and density estimates of all passes.
    pub counters: Counters,
    /// Wall time of all passes \[s], by stage.
    pub seconds: StageTimes,
    /// Counts and flux of unaimed photon paths, which start in all directions.
    pub unaimed: PhotonReport,
    /// Counts and flux of aimed photon paths, which start towards casters, such as glass and
    /// mirrors.
    pub aimed: PhotonReport,
    /// Wall time of all passes, without loading and without pilots (small simulations before the
    /// first pass). The times of continued and merged renders add up.
    pub wall_time: Duration,
}

/// Wall times of the passes of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassTimes {
    /// Time of all passes.
    pub total: Duration,
    /// Mean time of a pass; zero without passes.
    pub mean: Duration,
}

impl PassTimes {
    /// Returns the times of `passes` passes that took the time `total`.
    #[must_use]
    pub fn new(total: Duration, passes: u32) -> Self {
        Self { total, mean: total.checked_div(passes).unwrap_or_default() }
    }
}

/// Progress of a render, reported after each pass.
#[derive(Clone, Copy, Debug)]
pub struct PassProgress<'a> {
    /// Number of passes so far.
    pub passes: u32,
    /// Film, error estimator, counts and times of the passes so far.
    pub rendered: &'a RenderResult,
    /// Reason why the render ends after this pass; `None` if no criterion holds yet.
    pub end_reason: Option<EndReason>,
    /// Estimated error, and a forecast of the error after more passes; `None` if the error was not
    /// estimated after this pass.
    pub error: Option<(ErrorEstimate, ErrorForecast)>,
}

/// Least number of passes before a render gives up an error target that bias makes unreachable.
pub(super) const MIN_PASSES_BEFORE_GIVING_UP: u32 = 16;

/// Safety factor on the estimated bias that more passes do not remove.
///
/// A render gives up its error target only if this factor times the bias exceeds the target.
pub(super) const GIVE_UP_BIAS_FACTOR: f64 = 0.8;

/// The render loop: adds passes to `rendered` and returns it. `numbers` are the numbers of the
/// requested passes. The loop skips passes that `rendered` already holds, and renders the others in
/// ascending order.
///
/// The loop ends when a criterion of `stop` holds or no pass is left.
///
/// A render from the start begins with [`RenderResult::without_passes`] and the numbers
/// `0..u32::MAX`. To continue an earlier render, pass its result as `rendered`: picture and error
/// estimate then have the same bits as after one uninterrupted render. The pass limit of `stop`
/// counts all passes of `rendered`. Its time limit counts only [`StopCriteria::time_before_passes`]
/// and the time of this call.
///
/// `after_pass` is called after each pass. If [`ProgressMonitor::is_cancelled`] becomes true, the
/// render ends and the current pass is discarded.
pub fn render(
    mut rendered: RenderResult,
    numbers: Range<u32>,
    integrator: &dyn Integrator,
    stop: &StopCriteria<'_>,
    monitor: &dyn ProgressMonitor,
    mut after_pass: impl FnMut(&PassProgress<'_>),
) -> RenderResult {
    let start = Instant::now();
    let (passes_before, wall) = (rendered.film.passes(), rendered.wall_time);

    // Estimate the error of the earlier passes, which may meet a criterion already.
    let mut schedule = EstimateSchedule::default();
    (1..=rendered.film.passes()).for_each(|passes| _ = schedule.advance_if_due(passes));
    if rendered.film.passes() > 0 {
        let error = rendered.estimate_error(stop.target);
        let end_reason = stop.end_reason(passes_before, error.as_ref(), PassTimes::default());
        // Time does not end the render here, so that each call makes at least one pass, however
        // long loading and pilots took.
        if let Some(end_reason) = end_reason.filter(|reason| *reason != EndReason::Time) {
            rendered.end_reason = end_reason;
            return rendered;
        }
    }

    loop {
        let Some(number) = rendered.pass_numbers.first_missing(numbers.clone()) else {
            rendered.end_reason = EndReason::Passes;
            return rendered;
        };
        // Render one pass.
        let pass = integrator.render_pass(number, monitor);
        if monitor.is_cancelled() {
            rendered.end_reason = EndReason::Interrupted;
            return rendered;
        }

        // Add it to the result.
        if let Some(estimator) = &mut rendered.estimator {
            estimator.add(number, &pass);
        }
        rendered.film.add(&pass.image);
        rendered.light_group_films.iter_mut().zip(&pass.light_groups).for_each(|(film, image)| film.add(image));
        rendered.clamping_loss_film.iter_mut().for_each(|film| film.add(&pass.removed_by_clamp));
        rendered.pass_numbers.insert(number..number + 1);
        rendered.counters += pass.counters;
        rendered.seconds += pass.seconds;
        rendered.unaimed += pass.unaimed;
        rendered.aimed += pass.aimed;
        let passes = rendered.film.passes();
        rendered.wall_time = wall + start.elapsed();

        // End if a criterion holds.
        let error = if schedule.advance_if_due(passes) { rendered.estimate_error(stop.target) } else { None };
        let no_pass_is_left =
            || rendered.pass_numbers.first_missing(numbers.clone()).is_none().then_some(EndReason::Passes);
        let end_reason = stop
            .end_reason(passes, error.as_ref(), PassTimes::new(start.elapsed(), passes - passes_before))
            .or_else(no_pass_is_left);
        after_pass(&PassProgress { passes, rendered: &rendered, end_reason, error });
        let is_interrupted = stop.interrupted.load(Ordering::Relaxed);
        let end_reason = is_interrupted.then_some(EndReason::Interrupted).or(end_reason);
        if let Some(end_reason) = end_reason {
            rendered.end_reason = end_reason;
            return rendered;
        }
    }
}

impl RenderResult {
    /// Returns a result without passes, with which a render of `size` (width, height) pixels
    /// begins.
    #[must_use]
    pub fn without_passes(integrator: &dyn Integrator, size: (u32, u32)) -> Self {
        let groups = if integrator.groups_light() { LightGroup::ALL.len() } else { 0 };
        Self {
            pass_numbers: PassSet::default(),
            film: Film::new(size.0, size.1),
            light_group_films: (0..groups).map(|_| Film::new(size.0, size.1)).collect(),
            clamping_loss_film: integrator.clamps_light().then(|| Film::new(size.0, size.1)),
            estimator: integrator.estimates_error().then(|| ErrorEstimator::new(integrator.radius_law())),
            end_reason: EndReason::Passes,
            counters: Counters::default(),
            seconds: StageTimes::default(),
            unaimed: PhotonReport::default(),
            aimed: PhotonReport::default(),
            wall_time: Duration::ZERO,
        }
    }

    /// Returns the light that clamping removed from the picture, as a fraction of the light without
    /// clamping. The fraction is 0 for a black picture. `None` means that the render does not clamp
    /// light.
    #[must_use]
    pub fn clamping_loss_fraction(&self) -> Option<f64> {
        let light = |film: &Film| film.pixel_means().map(|mean| mean.element_sum()).sum::<f64>();
        let removed = light(self.clamping_loss_film.as_ref()?);
        let all = light(&self.film) + removed;
        Some(if all > 0.0 { removed / all } else { 0.0 })
    }

    /// Adds the passes of `other`, a render of the same scene with the same settings.
    ///
    /// # Errors
    /// [`MergeError`] if the renders have common passes or too many passes together, or are of
    /// different pictures or integrators. This result then stays as it is.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        let common = self.pass_numbers.intersection(&other.pass_numbers);
        if !common.is_empty() {
            return Err(MergeError::CommonPasses { common });
        }
        if self.film.size() != other.film.size() {
            return Err(MergeError::SizeMismatch { own: self.film.size(), other: other.film.size() });
        }
        if self.light_group_films.len() != other.light_group_films.len()
            || self.clamping_loss_film.is_some() != other.clamping_loss_film.is_some()
        {
            return Err(MergeError::LayerMismatch);
        }
        match (&mut self.estimator, &other.estimator) {
            (Some(own), Some(other)) => own.merge(other)?,
            (None, None) => {}
            _ => return Err(MergeError::EstimatorMismatch),
        }
        self.film.merge(&other.film)?;
        let clamped = self.clamping_loss_film.iter_mut().zip(&other.clamping_loss_film);
        for (own, other) in self.light_group_films.iter_mut().zip(&other.light_group_films).chain(clamped) {
            own.merge(other)?;
        }
        self.pass_numbers.insert_all(&other.pass_numbers);
        self.counters += other.counters;
        self.seconds += other.seconds;
        self.unaimed += other.unaimed;
        self.aimed += other.aimed;
        self.wall_time += other.wall_time;
        Ok(())
    }

    /// Returns the estimated error of the picture, and a forecast of the error after more passes.
    ///
    /// The error interval has the confidence [`ErrorTarget::interval_confidence`] of `target`, or
    /// 90 % without a target. Returns `None` without an error estimator, or after too few passes.
    #[must_use]
    pub fn estimate_error(&self, target: Option<ErrorTarget>) -> Option<(ErrorEstimate, ErrorForecast)> {
        let estimator = self.estimator.as_ref()?;
        let confidence = target.map_or(Confidence::default(), ErrorTarget::interval_confidence);
        let estimate = estimator.estimate_with_confidence(&self.film, confidence);
        Some((estimate, estimator.forecast(&estimate)?))
    }

    /// True if all films, the error estimator and `pass_numbers` have the same number of passes,
    /// and pictures of the same size.
    ///
    /// False for some results that were read from damaged files.
    pub(super) fn is_consistent(&self) -> bool {
        let (width, height) = self.film.size();
        let passes = self.film.passes();
        let is_of_picture =
            |film: &Film| film.is_consistent() && film.size() == (width, height) && film.passes() == passes;
        self.film.is_consistent()
            && (self.light_group_films.is_empty() || self.light_group_films.len() == LightGroup::ALL.len())
            && self.light_group_films.iter().chain(&self.clamping_loss_film).all(is_of_picture)
            && self.pass_numbers.is_consistent()
            && self.pass_numbers.len() == u64::from(passes)
            && self
                .estimator
                .as_ref()
                .is_none_or(|estimator| estimator.is_consistent(passes, width as usize * height as usize))
    }
}

impl<'a> StopCriteria<'a> {
    /// Returns criteria under which only `interrupted` ends a render.
    #[must_use]
    pub fn unlimited(interrupted: &'a AtomicBool) -> Self {
        Self {
            min_passes: 1,
            max_passes: None,
            time_limit: None,
            time_before_passes: Duration::ZERO,
            target: None,
            ends_at_bias_floor: false,
            interrupted,
        }
    }

    /// Returns the reason to end the render after `passes` passes; `None` to continue.
    ///
    /// `times` are the wall times of the passes that count towards the time limit. `error` is the
    /// error estimate after the current pass; `None` if the error was not estimated after it.
    #[must_use]
    pub fn end_reason(
        &self,
        passes: u32,
        error: Option<&(ErrorEstimate, ErrorForecast)>,
        times: PassTimes,
    ) -> Option<EndReason> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Some(EndReason::Interrupted);
        }
        if self.max_passes.is_some_and(|most| passes >= most) {
            return Some(EndReason::Passes);
        }
        if passes < self.min_passes {
            return None;
        }
        let by_error = error.and_then(|(estimate, forecast)| self.end_reason_by_error(estimate, forecast));
        // If the middle of the next pass is before the limit, the end of that pass is nearer to the
        // limit than the current time is.
        let expected_middle_of_next_pass = self.time_before_passes + times.total + times.mean / 2;
        let is_time_up = self.time_limit.is_some_and(|limit| expected_middle_of_next_pass >= limit);
        by_error.or(is_time_up.then_some(EndReason::Time))
    }

    /// Returns [`EndReason::Target`] if the error target is reached, [`EndReason::BiasFloor`] if
    /// bias keeps the render from reaching it, and `None` to continue.
    fn end_reason_by_error(&self, estimate: &ErrorEstimate, forecast: &ErrorForecast) -> Option<EndReason> {
        let target = self.target?;
        if estimate.high <= target.error {
            return Some(EndReason::Target);
        }
        let floor = forecast.bias_floor().filter(|floor| *floor >= target.error)?;
        let hopeless = estimate.passes >= MIN_PASSES_BEFORE_GIVING_UP && GIVE_UP_BIAS_FACTOR * floor > target.error;
        let is_only_bias = self.ends_at_bias_floor && estimate.noise <= target.error;
        (hopeless && (self.has_no_pass_or_time_limit() || is_only_bias)).then_some(EndReason::BiasFloor)
    }

    /// True if neither a number of passes nor a time ends the render.
    pub(super) fn has_no_pass_or_time_limit(&self) -> bool {
        self.max_passes.is_none() && self.time_limit.is_none()
    }
}

#[cfg(test)]
mod tests;
