//! Facts about a render that the live page shows beside its pixels.

use super::frame::LiveFrame;
use super::request::Orbit;
use crate::integrate::PhotonReport;
use crate::plan::Plan;
use crate::render::error_estimate::{
    Confidence, ErrorEstimate, ErrorForecast, PassRange, RANGE_PROBABILITY, StopForecast,
};
use crate::render::{EndReason, ErrorTarget, StopCriteria};
use crate::stats::Counters;
use serde::Serialize;
use std::sync::Arc;

/// Largest number of points of the predicted error curve.
const FORECAST_POINTS: u32 = 24;

/// Stage of a render, as the live page shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RenderStage {
    /// The scene is being read, and its bounding volume hierarchy built.
    #[default]
    Loading,
    /// The scene has errors or does not fit into memory, so nothing is rendered.
    Failed,
    /// A preview of reduced size is being rendered.
    Preview,
    /// Pilots (small simulations before the first pass) choose gather radii, and divide the work
    /// between camera rays and photons.
    Pilots,
    /// Passes are being rendered.
    Passes,
    /// The user stopped the render. It can be resumed.
    Stopped,
    /// The render has ended.
    Ended,
}

/// Point of the curve that shows how the estimated error falls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorCurvePoint {
    /// Wall time of the passes up to this point of the curve \[s].
    pub seconds: f64,
    /// Number of passes made up to this point of the curve.
    pub passes: u32,
    /// Estimated relative error, √(noise² + bias²).
    pub error: f64,
    /// Lower end of the confidence interval of `error`.
    pub low: f64,
    /// Upper end of the confidence interval of `error`.
    pub high: f64,
    /// Relative noise: the part of the error that falls as more passes are averaged.
    pub noise: f64,
    /// Relative bias: the part of the error that averaging does not reduce, because all passes err
    /// in the same direction.
    pub bias: f64,
}

/// Forecast of the relative error after more passes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForecastReport {
    /// Relative error for which the number of passes is predicted. It is the error target of the
    /// render; without a target, it is half of the present error.
    #[serde(rename = "target")]
    pub target_error: f64,
    /// True if `target_error` is the error target of the render; false if it is half of the present
    /// error.
    #[serde(rename = "ends_render")]
    pub is_render_target: bool,
    /// Predicted number of passes after which a render with the error target `target_error` would
    /// end: 10 % quantile, median and 90 % quantile.
    ///
    /// All three are `None` if the target is never reached. The median and the 90 % quantile are
    /// `None` if they are too large to predict. Without a median, the first value is a lower bound
    /// of the number of passes.
    #[serde(rename = "passes")]
    pub passes_to_target: [Option<u32>; 3],
    /// Relative bias that remains after any number of passes, if it keeps the error above
    /// `target_error`; `None` if `target_error` can be reached.
    #[serde(rename = "floor")]
    pub bias_floor: Option<f64>,
    /// Probability that the number of passes lies between the first and the last value of
    /// `passes_to_target`. It is 0.8, because these are the 10 % and 90 % quantiles.
    #[serde(rename = "probability")]
    pub range_probability: f64,
    /// Predicted error curve: pairs of a number of passes and a relative error.
    #[serde(rename = "curve")]
    pub error_curve: Vec<(u32, f64)>,
}

/// Plan of the render: the effects of light that it simulates or leaves out, with reasons.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PlanReport {
    /// Decision about each effect of light, such as caustics or shadows.
    pub effects: Vec<EffectReport>,
    /// Remarks on the rays and photons of a pass, one line each.
    pub notes: Vec<String>,
}

/// Decision whether the render simulates one effect of light, with the reason for the decision.
#[derive(Clone, Debug, Serialize)]
pub struct EffectReport {
    /// Name of the effect, as in `--effects`.
    pub name: &'static str,
    /// True if the render simulates the effect.
    pub on: bool,
    /// True if the user overruled the need of the scene: the effect is on although the scene does
    /// not need it, or off although the scene needs it.
    pub forced: bool,
    /// Reason why the scene needs the effect or does not need it. If the algorithm cannot simulate
    /// the effect, the text says so instead.
    pub reason: String,
    /// Flaw that is visible in the picture because the render leaves out an effect that the scene
    /// needs; `None` in all other cases.
    pub flaw: Option<&'static str>,
}

/// Text of the scene file, with its errors and warnings.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SceneSource {
    /// Path of the scene file, as the user named it.
    #[serde(rename = "name")]
    pub path: String,
    /// Text of the file; empty if it cannot be read as text, or is too long to show.
    pub text: Arc<str>,
    /// Errors that keep the scene from being rendered; empty if there are none.
    pub problems: Vec<SceneProblem>,
    /// Warnings about the scene, one line each.
    pub warnings: Vec<String>,
}

/// Error that keeps the scene from being rendered, with its position in the scene file if it has
/// one.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SceneProblem {
    /// Number of the line, from 1; 0 if the error has no position.
    pub line: usize,
    /// Column in characters, from 1; 0 if the error has no position.
    pub column: usize,
    /// Message that describes the error.
    pub message: String,
    /// Advice on how to correct the error; may be empty.
    pub remedy: String,
}

/// Description of a [`LiveFrame`] without its pixels: sequence number, size, passes and layers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FrameReport {
    /// Sequence number of the page update that delivered the frame. Later frames have larger
    /// numbers.
    pub sequence: u32,
    /// Width \[pixels].
    pub width: u32,
    /// Height \[pixels].
    pub height: u32,
    /// Number of passes from which the layers were computed; 0 for a preview.
    pub passes: u32,
    /// True if the frame is a preview with fewer pixels than the full picture.
    pub preview: bool,
    /// Names of the frame's layers, such as `noise`.
    pub layers: Vec<&'static str>,
}

/// Status of a render, which the page sends to browsers as JSON at each update.
///
/// Each status contains all facts, not only changes, so a browser may miss some statuses.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LiveStatus {
    /// Version of the program.
    pub version: &'static str,
    /// Scene file, as the user named it.
    pub scene: String,
    /// Name of the rendering algorithm, such as `hybrid`.
    pub integrator: &'static str,
    /// True for a page of `caustica view`, which can move the camera and resume a render. False for
    /// a page of `caustica render`.
    pub interactive: bool,
    /// Number of the render, counted from 1. It rises when the scene or the camera changes.
    #[serde(rename = "render")]
    pub render_number: u32,
    /// Sequence number of this update of the page. It rises by one with each update.
    pub sequence: u32,
    /// Stage that the render has reached.
    #[serde(rename = "phase")]
    pub stage: RenderStage,
    /// Reason why the render ended; `None` while it goes on.
    #[serde(rename = "ended")]
    pub end_reason: Option<EndReason>,
    /// Width and height of the full picture \[pixels]; 0 before the first scene is read.
    pub size: (u32, u32),
    /// Position of the camera that the user has chosen on the page, relative to the camera of the
    /// scene file.
    pub orbit: Orbit,
    /// Size and passes of the newest picture; `None` before the first one.
    pub picture: Option<FrameReport>,
    /// Size and passes of the newest maps of the estimated error, which may be older than the
    /// picture; `None` before the first maps.
    #[serde(rename = "maps")]
    pub error_maps: Option<FrameReport>,
    /// Size and passes of the newest surface AOVs; `None` until a browser asks for them.
    #[serde(rename = "surfaces")]
    pub surface_aovs: Option<FrameReport>,
    /// Size of the reference picture \[pixels]; `None` without one.
    #[serde(rename = "reference")]
    pub reference_size: Option<(u32, u32)>,
    /// Number of passes so far.
    pub passes: u32,
    /// Wall time of the passes so far \[s].
    pub seconds: f64,
    /// Time from the start of loading to the first pixels on the page \[s]; `None` before them.
    pub first_pixels_seconds: Option<f64>,
    /// Largest number of passes of the render; `None` for no limit.
    pub pass_limit: Option<u32>,
    /// Time limit of the render \[s]; `None` for no limit. Pilots (small simulations before the
    /// first pass) and, in `caustica render`, loading count towards this limit, but not towards
    /// `seconds`.
    #[serde(rename = "time_limit")]
    pub time_limit_seconds: Option<f64>,
    /// Relative error at which the render ends; `None` for no error target.
    pub error_limit: Option<f64>,
    /// Confidence level of the interval from `low` to `high` of each point in `error_curve`; `None`
    /// without an error target.
    #[serde(rename = "confidence")]
    pub interval_confidence: Option<Confidence>,
    /// Curve of the estimated error so far, in the order of passes, with one point for each error
    /// estimate. When the curve gets too long, every second point is removed.
    #[serde(rename = "curve")]
    pub error_curve: Arc<Vec<ErrorCurvePoint>>,
    /// Forecast of the error after more passes, from the last point of `error_curve`; `None` before
    /// the first error estimate.
    pub forecast: Option<Arc<ForecastReport>>,
    /// Plan of the render; `None` until the pilots (small simulations before the first pass) have
    /// ended.
    pub plan: Option<Arc<PlanReport>>,
    /// Counts of rays and density estimates in all passes so far.
    pub counters: Counters,
    /// Counts and flux of the unaimed photon paths, which leave the lights in all directions.
    pub unaimed: PhotonReport,
    /// Counts and flux of the photon paths that start towards objects that cast caustics, such as
    /// glass or mirrors.
    pub aimed: PhotonReport,
    /// Revision number of the scene text and its errors. The number rises when the scene file is
    /// read again, or when its errors change. The page then fetches text and errors.
    pub source_revision: u32,
    /// Number of errors that keep the scene from being rendered. The page fetches their texts
    /// separately.
    #[serde(rename = "problems")]
    pub problem_count: usize,
}

impl ErrorCurvePoint {
    /// Makes a point of the error curve from an estimate after `seconds` of wall time.
    #[must_use]
    pub fn new(estimate: &ErrorEstimate, seconds: f64) -> Self {
        let ErrorEstimate { passes, error, low, high, noise, bias, .. } = *estimate;
        Self { seconds, passes, error, low, high, noise, bias }
    }
}

impl ForecastReport {
    /// Forecasts how the error falls from `estimate` to the error target of `stop`. If `stop` has
    /// no target, half of the present error is the target.
    #[must_use]
    pub fn new(estimate: &ErrorEstimate, forecast: &ErrorForecast, stop: &StopCriteria<'_>) -> Self {
        let half = ErrorTarget { error: 0.5 * estimate.error, confidence: Confidence::default() };
        let target = stop.target.unwrap_or(half);
        let (passes, floor) = match forecast.stop_forecast(target.error, target.interval_confidence()) {
            StopForecast::Passes(PassRange { low, median, high }) => ([Some(low), Some(median), high], None),
            StopForecast::Never { floor } => ([None; 3], Some(floor)),
            StopForecast::TooFar { at_least } => ([Some(at_least), None, None], None),
        };
        let curve_end = passes.into_iter().flatten().max().unwrap_or(0).max(4 * estimate.passes);
        let ratio = f64::from(curve_end) / f64::from(estimate.passes.max(1));
        let pass_count_at = |i: u32| {
            let factor = libm::pow(ratio, f64::from(i) / f64::from(FORECAST_POINTS - 1));
            (f64::from(estimate.passes) * factor).round() as u32
        };
        let mut pass_counts: Vec<u32> = (0..FORECAST_POINTS).map(pass_count_at).collect();
        pass_counts.dedup();
        Self {
            target_error: target.error,
            is_render_target: stop.target.is_some(),
            passes_to_target: passes,
            bias_floor: floor,
            range_probability: RANGE_PROBABILITY,
            error_curve: pass_counts.into_iter().map(|n| (n, forecast.error_after_passes(n))).collect(),
        }
    }
}

impl PlanReport {
    /// Makes the report of `plan`. `notes` are remarks on the rays and photons of a pass, one line
    /// each.
    #[must_use]
    pub fn new(plan: &Plan, notes: Vec<String>) -> Self {
        let effects = plan.decisions.iter().map(|decision| EffectReport {
            name: decision.effect.name(),
            on: decision.is_simulated,
            forced: decision.is_forced_against_need(),
            reason: decision.reason.to_string(),
            flaw: (decision.is_needed && !decision.is_simulated).then(|| decision.effect.symptom_if_missing()),
        });
        Self { effects: effects.collect(), notes }
    }
}

impl FrameReport {
    /// Makes the description of `frame`.
    #[must_use]
    pub fn new(frame: &LiveFrame) -> Self {
        Self {
            sequence: frame.sequence,
            width: frame.size.0,
            height: frame.size.1,
            passes: frame.passes,
            preview: frame.is_preview,
            layers: frame.layers.iter().map(|layer| layer.kind.url_name()).collect(),
        }
    }
}
