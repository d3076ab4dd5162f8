//! JSON report of a render for `--stats`. `docs/guide/command-line.md` describes each field.

use super::plan::EffectDecisionReport;
use crate::integrate::{
    EmissionGuidingReports, EnvironmentGuidingReport, GatherRadii, PhotonReport, RayPhotonBalance,
    ScatterPointGuidingReport, StageTimes,
};
use crate::render::error_estimate::{BiasPart, Confidence, ErrorEstimate, StopForecast};
use crate::render::{EndReason, ErrorTarget, RenderLimits, RenderResult, StopCriteria};
use crate::stats::{Counters, cpu_seconds, peak_memory};
use serde::Serialize;

/// Version of the JSON schema of the report. The version rises when a field's name or meaning
/// changes.
const SCHEMA: u32 = 3;

/// JSON report that `--stats` writes.
#[derive(Debug, Serialize)]
pub(super) struct RenderReport {
    pub schema: u32,
    pub version: &'static str,
    pub scene: String,
    pub integrator: &'static str,
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    pub threads: usize,
    pub passes: u32,
    #[serde(rename = "ended")]
    pub end_reason: EndReason,
    pub limits: LimitsReport,
    pub triangles: usize,
    #[serde(rename = "shapes")]
    pub analytic_shapes: usize,
    pub lights: usize,
    #[serde(rename = "radii")]
    pub gather_radii: Option<GatherRadiiReport>,
    pub emission_guiding: EmissionGuidingReports,
    pub environment_guiding: Option<EnvironmentGuidingReport>,
    pub scatter_point_guiding: Option<ScatterPointGuidingReport>,
    pub effects: Vec<EffectDecisionReport>,
    pub balance: Option<RayPhotonBalance>,
    pub photons: PhotonReports,
    /// Estimated error; `None` after too few passes, with `--no-error-estimate`, or for `raycast`.
    pub error: Option<EstimatedErrorReport>,
    /// Fraction of the picture's light that `--clamp` removed, relative to the picture without
    /// clamping; `None` without this flag.
    pub clamped_fraction: Option<f64>,
    pub counters: Counters,
    pub seconds: RenderTimes,
    pub rates: RenderRates,
    pub peak_memory_bytes: Option<u64>,
    pub cpu_seconds: Option<f64>,
}

/// Limits of the render. The field `ended` of [`RenderReport`] names the limit that ended the
/// render.
#[derive(Debug, Serialize)]
pub(super) struct LimitsReport {
    /// True if the command line has none of the flags `--passes`, `--time` and `--target-error`.
    /// The limits are then the defaults, or those of `--preview`.
    #[serde(rename = "default")]
    is_default: bool,
    /// Largest number of passes; `None` without this limit.
    passes: Option<u32>,
    /// Time limit \[s], from the start of loading; `None` without this limit.
    seconds: Option<f64>,
    /// Relative error at which the render ends; `None` without this limit.
    #[serde(rename = "error")]
    target_error: Option<f64>,
    /// Confidence with which the true error must be at most `target_error`; `None` if there is no
    /// limit `target_error`.
    confidence: Option<Confidence>,
}

impl LimitsReport {
    fn new(limits: &RenderLimits, stop: &StopCriteria<'_>) -> Self {
        Self {
            is_default: limits.are_default(),
            passes: stop.max_passes,
            seconds: stop.time_limit.map(|time| time.as_secs_f64()),
            target_error: stop.target.map(|target| target.error),
            confidence: stop.target.map(|target| target.confidence),
        }
    }
}

/// Estimated relative error of the picture, and the cost of halving it.
#[derive(Debug, Serialize)]
pub(super) struct EstimatedErrorReport {
    #[serde(flatten)]
    pub estimate: ErrorEstimate,
    /// Confidence that the true error lies between the bounds `low` and `high` of the estimate.
    #[serde(rename = "confidence")]
    pub interval_confidence: Confidence,
    /// Predicted total number of passes after which the error is half of the present error: median
    /// of the forecast, including the passes so far. `None` if the number is unknown, or if bias
    /// keeps the error above this half.
    #[serde(rename = "halving_passes")]
    halving_total_passes: Option<u32>,
    /// Expected further time until `halving_total_passes` is reached \[s]; `None` if that field is
    /// `None`.
    #[serde(rename = "halving_seconds")]
    halving_seconds_left: Option<f64>,
    /// Largest part of the bias that remains after any number of passes; `None` if no bias remains.
    #[serde(skip)]
    pub largest_remaining_bias: Option<BiasPart>,
}

impl EstimatedErrorReport {
    fn new(rendered: &RenderResult, confidence: Confidence) -> Option<Self> {
        let estimator = rendered.estimator.as_ref()?;
        let estimate = estimator.estimate_with_confidence(&rendered.film, confidence);
        let forecast = estimator.forecast(&estimate)?;
        let half = ErrorTarget { error: 0.5 * estimate.error, confidence: Confidence::default() };
        let halving_passes = match forecast.stop_forecast(half.error, half.interval_confidence()) {
            StopForecast::Passes(range) => Some(range.median),
            StopForecast::Never { .. } | StopForecast::TooFar { .. } => None,
        };
        let pass_seconds = rendered.wall_time.as_secs_f64() / f64::from(estimate.passes);
        let halving_seconds = halving_passes.map(|n| f64::from(n.saturating_sub(estimate.passes)) * pass_seconds);
        Some(Self {
            estimate,
            interval_confidence: confidence,
            halving_total_passes: halving_passes,
            halving_seconds_left: halving_seconds,
            largest_remaining_bias: forecast.largest_remaining_bias(),
        })
    }
}

/// Largest gather radius of each photon map in the first pass. In later passes, radii may be
/// smaller.
#[derive(Debug, Serialize)]
pub(super) struct GatherRadiiReport {
    /// Largest gather radius of the indirect map in the first pass \[length].
    ///
    /// In most algorithms, the indirect map holds the photons of all indirect light. In `hybrid`,
    /// it holds only light that a surface or medium reflected or scattered after the light had
    /// formed a caustic.
    #[serde(rename = "global")]
    pub indirect: f32,
    /// Largest gather radius of the caustic map in the first pass \[length].
    pub caustic: f32,
}

/// Counts and flux of photon paths. Paths that lights emit in all directions are separate from
/// paths that lights aim at casters (glass, mirrors).
#[derive(Debug, Serialize)]
pub(super) struct PhotonReports {
    /// Photon paths that lights emit in all directions (unaimed): those of `--photons`.
    #[serde(rename = "global")]
    pub unaimed: PhotonReport,
    /// Photon paths that lights aim at casters (glass, mirrors): those of `--caustic-photons`.
    #[serde(rename = "caustic")]
    pub aimed: PhotonReport,
}

/// Wall times of a render \[s].
#[derive(Debug, Serialize)]
pub(super) struct RenderTimes {
    /// Time before the first pass; see [`RenderSetup::setup_seconds`].
    pub setup: f64,
    /// Time of each stage of a pass, such as photon tracing, summed over all passes.
    #[serde(flatten)]
    pub passes: StageTimes,
    /// Time of all passes.
    pub render: f64,
}

/// Mean numbers of photon paths and of rays that a render traces per second of wall time.
#[derive(Debug, Serialize)]
pub(super) struct RenderRates {
    /// Number of emitted photon paths, divided by the time spent on tracing photons \[1/s].
    #[serde(rename = "photons_per_second")]
    pub photon_paths_per_second: f64,
    /// Number of rays of all kinds, divided by the time of all passes \[1/s].
    pub rays_per_second: f64,
}

/// Properties of a render that are known before its first pass, for the JSON report.
pub(super) struct RenderSetup {
    pub scene: String,
    pub integrator: &'static str,
    pub seed: u64,
    pub threads: usize,
    pub triangles: usize,
    pub analytic_shapes: usize,
    pub lights: usize,
    pub gather_radii: Option<GatherRadii>,
    pub emission_guiding: EmissionGuidingReports,
    pub environment_guiding: Option<EnvironmentGuidingReport>,
    pub scatter_point_guiding: Option<ScatterPointGuidingReport>,
    pub effects: Vec<EffectDecisionReport>,
    pub balance: Option<RayPhotonBalance>,
    /// Time before the first pass \[s]: loading the scene and preparing the algorithm. If there are
    /// several pictures (`--frames`, `--stereo`), loading is left out, because they share it.
    pub setup_seconds: f64,
}

impl RenderReport {
    pub fn new(setup: RenderSetup, limits: &RenderLimits, stop: &StopCriteria<'_>, rendered: &RenderResult) -> Self {
        let confidence = stop.target.map_or(limits.confidence, ErrorTarget::interval_confidence);
        let (width, height) = rendered.film.size();
        let wall = rendered.wall_time.as_secs_f64();
        let rate = |n: u64, seconds: f64| if seconds > 0.0 { n as f64 / seconds } else { 0.0 };
        let emitted = rendered.unaimed.emitted_paths + rendered.aimed.emitted_paths;
        Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            scene: setup.scene,
            integrator: setup.integrator,
            width,
            height,
            seed: setup.seed,
            threads: setup.threads,
            passes: rendered.film.passes(),
            end_reason: rendered.end_reason,
            limits: LimitsReport::new(limits, stop),
            triangles: setup.triangles,
            analytic_shapes: setup.analytic_shapes,
            lights: setup.lights,
            gather_radii: setup.gather_radii.map(|r| GatherRadiiReport { indirect: r.indirect, caustic: r.caustic }),
            emission_guiding: setup.emission_guiding,
            environment_guiding: setup.environment_guiding,
            scatter_point_guiding: setup.scatter_point_guiding,
            effects: setup.effects,
            balance: setup.balance,
            photons: PhotonReports { unaimed: rendered.unaimed, aimed: rendered.aimed },
            error: EstimatedErrorReport::new(rendered, confidence),
            clamped_fraction: rendered.clamping_loss_fraction(),
            counters: rendered.counters,
            seconds: RenderTimes { setup: setup.setup_seconds, passes: rendered.seconds, render: wall },
            rates: RenderRates {
                photon_paths_per_second: rate(emitted, rendered.seconds.photons),
                rays_per_second: rate(rendered.counters.total_rays(), wall),
            },
            peak_memory_bytes: peak_memory(),
            cpu_seconds: cpu_seconds(),
        }
    }
}
