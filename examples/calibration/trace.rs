//! Error estimates along a render.

use super::scenes::Truth;
use caustica::integrate::{Algorithm, Integrator, SilentMonitor};
use caustica::render::error_estimate::{
    Confidence, ErrorEstimate, ErrorEstimator, ErrorForecast, EstimateSchedule, MIN_ERROR_ESTIMATE_PASSES,
};
use caustica::render::{ErrorTarget, Film};
use glam::Vec3;

/// Error estimates of one render.
pub struct Trace {
    pub scene: String,
    pub algorithm: Algorithm,
    pub points: Vec<TracePoint>,
}

/// Error estimate after some passes.
pub struct TracePoint {
    /// Estimate with an interval of 90 %.
    pub estimate: ErrorEstimate,
    /// Upper end of the error with the default confidence of error targets.
    pub upper_end: f64,
    pub forecast: Option<ErrorForecast>,
    /// True error; `None` without references.
    pub error: Option<f64>,
    mean: Vec<Vec3>,
}

/// An error target of a trace.
pub struct ReachedTarget<'a> {
    pub target: ErrorTarget,
    /// The estimate by which the render ends.
    pub end: &'a TracePoint,
}

/// Returns the largest number of passes, up to `passes`, after which a render estimates its error.
pub fn last_estimate_up_to(passes: u32) -> u32 {
    EstimateSchedule::due_passes().take_while(|due| *due <= passes).last().unwrap_or(passes)
}

/// Returns an error target with the default confidence.
pub fn target(error: f64) -> ErrorTarget {
    ErrorTarget { error, confidence: Confidence::default() }
}

impl Trace {
    /// Renders `passes` passes and estimates errors on the schedule of a render.
    pub fn render(
        scene: &str,
        algorithm: Algorithm,
        integrator: &dyn Integrator,
        size: (u32, u32),
        passes: u32,
    ) -> Self {
        let (mut film, mut estimator) = (Film::new(size.0, size.1), ErrorEstimator::new(integrator.radius_law()));
        let (mut schedule, mut points) = (EstimateSchedule::default(), Vec::new());
        for number in 0..passes {
            let pass = integrator.render_pass(number, &SilentMonitor);
            estimator.add(number, &pass);
            film.add(&pass.image);
            if !schedule.advance_if_due(number + 1) || number + 1 < MIN_ERROR_ESTIMATE_PASSES {
                continue;
            }
            let estimate = estimator.estimate(&film);
            let interval = target(1.0).interval_confidence();
            points.push(TracePoint {
                upper_end: estimator.estimate_with_confidence(&film, interval).high,
                forecast: estimator.forecast(&estimate),
                estimate,
                error: None,
                mean: film.mean_picture(),
            });
        }
        Self { scene: scene.to_owned(), algorithm, points }
    }

    /// Adds the true errors by `truth`.
    pub fn with_true_errors(mut self, truth: Option<&Truth>) -> Self {
        for point in &mut self.points {
            point.error = truth.map(|truth| truth.error(&std::mem::take(&mut point.mean)));
        }
        self
    }

    /// Returns the targets from 30 % downwards, each .85 times the previous one, at which this
    /// render would have ended.
    pub fn reached_targets(&self) -> Vec<ReachedTarget<'_>> {
        let errors = std::iter::successors(Some(0.3), |error| Some(0.85 * error)).take(40);
        let reached = |error: f64| {
            let end = self.points.iter().find(|point| point.upper_end <= error)?;
            Some(ReachedTarget { target: target(error), end })
        };
        errors.filter_map(reached).collect()
    }
}

/// Returns the traces of each scene and method.
pub fn groups(traces: &[Trace]) -> impl Iterator<Item = &[Trace]> {
    traces.chunk_by(|a, b| a.scene == b.scene && a.algorithm == b.algorithm)
}
