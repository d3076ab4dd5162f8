//! The report of a render as JSON; docs/guide/command-line.md describes each field.

use super::plan::EffectReport;
use crate::integrate::{Balance, GuidingReports, PhotonReport, Radii, Seconds};
use crate::render::error_estimate::{Confidence, ErrorEstimate, PassesNeeded};
use crate::render::{EndReason, Rendered};
use crate::stats::{Counters, cpu_seconds, peak_memory};
use serde::Serialize;

/// Version of the schema: it grows when a field changes its meaning or goes.
const SCHEMA: u32 = 1;

/// What `--stats` writes.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub schema: u32,
    pub version: &'static str,
    pub scene: String,
    pub integrator: &'static str,
    pub width: u32,
    pub height: u32,
    pub seed: u64,
    pub threads: usize,
    pub passes: u32,
    pub ended: EndReason,
    pub triangles: usize,
    pub shapes: usize,
    pub lights: usize,
    pub radii: Option<RadiiReport>,
    pub emission: GuidingReports,
    pub effects: Vec<EffectReport>,
    pub balance: Option<Balance>,
    pub photons: Photons,
    /// `None` with too few passes, or without the gauge.
    pub error: Option<ErrorReport>,
    pub counters: Counters,
    pub seconds: Times,
    pub rates: Rates,
    pub peak_memory_bytes: Option<u64>,
    pub cpu_seconds: Option<f64>,
}

/// The error of the picture, relative (see `RelativeScale`).
#[derive(Debug, Serialize)]
pub(super) struct ErrorReport {
    #[serde(flatten)]
    pub reading: ErrorEstimate,
    /// Of the interval from `low` to `high`.
    confidence: Confidence,
    /// Passes that make the error half as large, in all; `None` where none do.
    halving_passes: Option<u32>,
    /// The time that they take from now on \[s].
    halving_seconds: Option<f64>,
}

impl ErrorReport {
    fn new(rendered: &Rendered, confidence: Confidence) -> Option<Self> {
        let gauge = rendered.estimator.as_ref()?;
        let reading = gauge.estimate_with(&rendered.film, confidence);
        let forecast = gauge.forecast(&reading)?;
        let halving_passes = match forecast.passes_to(0.5 * reading.error) {
            PassesNeeded::Passes(n) => Some(n),
            PassesNeeded::Never { .. } | PassesNeeded::TooMany => None,
        };
        let a_pass = rendered.wall.as_secs_f64() / f64::from(reading.passes);
        let halving_seconds = halving_passes.map(|n| f64::from(n.saturating_sub(reading.passes)) * a_pass);
        Some(Self { reading, confidence, halving_passes, halving_seconds })
    }
}

#[derive(Debug, Serialize)]
pub(super) struct RadiiReport {
    pub global: f32,
    pub caustic: f32,
}

#[derive(Debug, Serialize)]
pub(super) struct Photons {
    pub global: PhotonReport,
    pub caustic: PhotonReport,
}

#[derive(Debug, Serialize)]
pub(super) struct Times {
    pub setup: f64,
    #[serde(flatten)]
    pub passes: Seconds,
    pub render: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Rates {
    pub photons_per_second: f64,
    pub rays_per_second: f64,
}

/// What of the report is known before the render.
pub(super) struct Setting {
    pub scene: String,
    pub integrator: &'static str,
    pub seed: u64,
    pub threads: usize,
    pub triangles: usize,
    pub shapes: usize,
    pub lights: usize,
    pub radii: Option<Radii>,
    pub emission: GuidingReports,
    pub effects: Vec<EffectReport>,
    pub balance: Option<Balance>,
    pub setup: f64,
}

impl Report {
    pub fn new(setting: Setting, rendered: &Rendered, confidence: Confidence) -> Self {
        let (width, height) = rendered.film.size();
        let wall = rendered.wall.as_secs_f64();
        let rate = |n: u64, seconds: f64| if seconds > 0.0 { n as f64 / seconds } else { 0.0 };
        let emitted = rendered.global.emitted + rendered.caustic.emitted;
        Self {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            scene: setting.scene,
            integrator: setting.integrator,
            width,
            height,
            seed: setting.seed,
            threads: setting.threads,
            passes: rendered.film.passes(),
            ended: rendered.ended,
            triangles: setting.triangles,
            shapes: setting.shapes,
            lights: setting.lights,
            radii: setting.radii.map(|r| RadiiReport { global: r.global, caustic: r.caustic }),
            emission: setting.emission,
            effects: setting.effects,
            balance: setting.balance,
            photons: Photons { global: rendered.global, caustic: rendered.caustic },
            error: ErrorReport::new(rendered, confidence),
            counters: rendered.counters,
            seconds: Times { setup: setting.setup, passes: rendered.seconds, render: wall },
            rates: Rates {
                photons_per_second: rate(emitted, rendered.seconds.photons),
                rays_per_second: rate(rendered.counters.rays(), wall),
            },
            peak_memory_bytes: peak_memory(),
            cpu_seconds: cpu_seconds(),
        }
    }
}
