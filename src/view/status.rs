//! Facts about a render that the live page shows beside its pixels.

use super::frame::Frame;
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

/// Largest number of points of the forecast error curve.
const FORECAST_POINTS: u32 = 24;

/// Phase of a render, as the live page shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// The scene is read, and its bounding volume hierarchy is built.
    #[default]
    Loading,
    /// The scene has errors, so nothing is rendered.
    Failed,
    /// A preview of reduced size is rendered.
    Preview,
    /// Pilots (small simulations before the first pass) find gather radii and the division of work.
    Pilots,
    /// Passes are rendered.
    Passes,
    /// The user stopped the render. It can be resumed.
    Stopped,
    /// The render has ended.
    Ended,
}

/// Point of the curve that shows how the estimated error falls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Wall time of all passes so far \[s].
    pub seconds: f64,
    /// Number of passes at this point of the curve.
    pub passes: u32,
    /// Estimated relative error.
    pub error: f64,
    /// Lower end of the confidence interval of `error`.
    pub low: f64,
    /// Upper end of the confidence interval of `error`.
    pub high: f64,
    /// Relative noise: `error` is √(noise² + bias²).
    pub noise: f64,
    /// Relative bias: `error` is √(noise² + bias²).
    pub bias: f64,
}

/// Forecast of the relative error after more passes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForecastReport {
    /// Relative error whose pass is forecast: the target of the render, or half of the current
    /// error if the render has no target.
    pub target: f64,
    /// True if `target` is the error target that ends the render.
    pub ends_render: bool,
    /// Predicted number of passes at which the error is `target`: 10 % quantile, median and 90 %
    /// quantile. `None` where it is too far to predict, or never reached.
    pub passes: [Option<u32>; 3],
    /// Relative bias that keeps the error above `target` after any number of passes; `None` if the
    /// target can be reached.
    pub floor: Option<f64>,
    /// Probability that the number of passes lies between the first and last value of `passes`.
    pub probability: f64,
    /// Predicted error curve: pairs of a number of passes and a relative error.
    pub curve: Vec<(u32, f64)>,
}

/// Plan of the render: decisions with their reasons.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PlanReport {
    /// Decisions about effects of light.
    pub effects: Vec<EffectReport>,
    /// Remarks on the work of a pass, one line each.
    pub notes: Vec<String>,
}

/// Decision of the plan about one effect of light.
#[derive(Clone, Debug, Serialize)]
pub struct EffectReport {
    /// Name of the effect.
    pub name: &'static str,
    /// True if the render simulates the effect.
    pub on: bool,
    /// True if the user forced the effect on or off, against the plan.
    pub forced: bool,
    /// Why the scene needs the effect, or does not need it.
    pub reason: String,
    /// Visible flaw of a picture without the effect; `None` unless the scene needs the effect and
    /// the render leaves it out.
    pub flaw: Option<&'static str>,
}

/// Text of the scene file, with its errors.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SceneSource {
    /// Name of the file.
    pub name: String,
    /// Text of the file; empty for a binary format.
    pub text: Arc<str>,
    /// Errors in the scene file.
    pub problems: Vec<SceneProblem>,
    /// Warnings about the scene, one line each.
    pub warnings: Vec<String>,
}

/// Error in the scene file, with its place.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SceneProblem {
    /// Number of the line, from 1; 0 if the error has no position.
    pub line: usize,
    /// Column in characters, from 1; 0 if the error has no position.
    pub column: usize,
    /// Message that describes the error.
    pub message: String,
    /// Advice on how to correct it.
    pub remedy: String,
}

/// Sequence number, size and passes of a published frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FrameReport {
    /// Sequence number of the frame; later frames have larger numbers.
    pub sequence: u32,
    /// Width \[pixels].
    pub width: u32,
    /// Height \[pixels].
    pub height: u32,
    /// Number of passes from which the layers were computed; 0 for a preview.
    pub passes: u32,
    /// True if the frame is a preview of reduced size.
    pub preview: bool,
    /// Names of the frame's layers, such as `noise`.
    pub layers: Vec<&'static str>,
}

/// Status of a render. Each publication holds all of it, so a browser may miss publications.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LiveStatus {
    /// Version of the program.
    pub version: &'static str,
    /// Scene file, as the user named it.
    pub scene: String,
    /// Name of the algorithm.
    pub integrator: &'static str,
    /// True if the page belongs to `caustica view`: it then can move the camera and resume.
    pub interactive: bool,
    /// Number of the render, counted from 1. It rises when the scene or the camera changes.
    pub render: u32,
    /// Sequence number of the publication.
    pub sequence: u32,
    /// Phase that the render has reached.
    pub phase: Phase,
    /// Why the render ended; `None` while it goes on.
    pub ended: Option<EndReason>,
    /// Width and height of the full picture \[pixels]; 0 before the scene is read.
    pub size: (u32, u32),
    /// Camera position that the user has chosen on the page, relative to the scene file.
    pub orbit: Orbit,
    /// Size and passes of the newest picture; `None` before the first one.
    pub picture: Option<FrameReport>,
    /// Size and passes of the newest maps of the estimated error, which may be older than the
    /// picture.
    pub maps: Option<FrameReport>,
    /// Size of the reference picture \[pixels]; `None` without one.
    pub reference: Option<(u32, u32)>,
    /// Number of passes so far.
    pub passes: u32,
    /// Wall time of the passes so far \[s].
    pub seconds: f64,
    /// Time from the start of loading to the first pixels \[s].
    pub first_pixels_seconds: Option<f64>,
    /// Largest number of passes; `None` for no limit.
    pub pass_limit: Option<u32>,
    /// Wall time after which the render ends \[s]; `None` for no limit.
    pub time_limit: Option<f64>,
    /// Relative error at which the render ends; `None` for no error target.
    pub error_limit: Option<f64>,
    /// Confidence of the error intervals in `curve`; `None` for no error target.
    pub confidence: Option<Confidence>,
    /// Curve of the estimated error over the passes.
    pub curve: Arc<Vec<CurvePoint>>,
    /// Forecast of the error from the last point of `curve`; `None` before the first estimate.
    pub forecast: Option<Arc<ForecastReport>>,
    /// Plan of the render; `None` before pilots have ended.
    pub plan: Option<Arc<PlanReport>>,
    /// Counts of rays and density estimates.
    pub counters: Counters,
    /// Counts and flux of the photon paths that start in all directions.
    pub unaimed: PhotonReport,
    /// Counts and flux of the photon paths that are aimed at casters, such as glass or mirrors.
    pub aimed: PhotonReport,
    /// Number that rises whenever the text or the errors of the scene file change.
    pub source_revision: u32,
    /// Number of errors in the scene file. The page fetches their text separately.
    pub problems: usize,
}

impl CurvePoint {
    /// Makes a point of the error curve from an estimate after `seconds` of wall time.
    #[must_use]
    pub fn new(estimate: &ErrorEstimate, seconds: f64) -> Self {
        let ErrorEstimate { passes, error, low, high, noise, bias, .. } = *estimate;
        Self { seconds, passes, error, low, high, noise, bias }
    }
}

impl ForecastReport {
    /// Forecasts the error that `estimate` gives, up to the target of `stop` or to half the error.
    #[must_use]
    pub fn new(estimate: &ErrorEstimate, forecast: &ErrorForecast, stop: &StopCriteria<'_>) -> Self {
        let half = ErrorTarget { error: 0.5 * estimate.error, confidence: Confidence::default() };
        let target = stop.target.unwrap_or(half);
        let (passes, floor) = match forecast.stop_forecast(target.error, target.interval_confidence()) {
            StopForecast::Passes(PassRange { low, median, high }) => ([Some(low), Some(median), high], None),
            StopForecast::Never { floor } => ([None; 3], Some(floor)),
            StopForecast::TooFar { at_least } => ([Some(at_least), None, None], None),
        };
        let last = passes.into_iter().flatten().max().unwrap_or(0).max(4 * estimate.passes);
        let ratio = f64::from(last) / f64::from(estimate.passes.max(1));
        let point = |i: u32| {
            let factor = libm::pow(ratio, f64::from(i) / f64::from(FORECAST_POINTS - 1));
            (f64::from(estimate.passes) * factor).round() as u32
        };
        let mut numbers: Vec<u32> = (0..FORECAST_POINTS).map(point).collect();
        numbers.dedup();
        Self {
            target: target.error,
            ends_render: stop.target.is_some(),
            passes,
            floor,
            probability: RANGE_PROBABILITY,
            curve: numbers.into_iter().map(|n| (n, forecast.error_after_passes(n))).collect(),
        }
    }
}

impl PlanReport {
    /// Makes the report of `plan`. `notes` are remarks on the work of a pass.
    #[must_use]
    pub fn new(plan: &Plan, notes: Vec<String>) -> Self {
        let effects = plan.decisions.iter().map(|decision| EffectReport {
            name: decision.effect.name(),
            on: decision.is_simulated,
            forced: decision.is_forced_by_user(),
            reason: decision.reason.to_string(),
            flaw: (decision.is_needed && !decision.is_simulated).then(|| decision.effect.symptom_if_missing()),
        });
        Self { effects: effects.collect(), notes }
    }
}

impl FrameReport {
    /// Makes the report of a frame.
    #[must_use]
    pub fn new(frame: &Frame) -> Self {
        Self {
            sequence: frame.sequence,
            width: frame.size.0,
            height: frame.size.1,
            passes: frame.passes,
            preview: frame.is_preview,
            layers: frame.layers.iter().map(|layer| layer.kind.name()).collect(),
        }
    }
}
