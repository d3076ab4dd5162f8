//! Report of the time, passes and photons that one algorithm needs to reach each of several errors.

use crate::cli::EstimateArguments;
use crate::cli::args::MethodArguments;
use crate::cli::forecast_text::{self, duration_text};
use crate::cli::settings::method_flags;
use crate::cli::value_parsers::count_with_noun;
use crate::render::error_estimate::{
    BiasPart, Confidence, ErrorEstimate, ErrorForecast, RANGE_PROBABILITY, StopForecast,
};
use crate::render::{
    DEFAULT_TARGET_ERROR, EndReason, ErrorTarget, ExpectedEnd, PREVIEW_TARGET_ERROR, RenderResult, StopCriteria,
};
use crate::stats::peak_memory;
use crate::study::text::{count_text, percent_text};
use serde::Serialize;
use std::fmt::Write as _;

/// Error: the pilot (short render) was interrupted before its error could be estimated.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the pilot ended after {passes} passes, too few to estimate an error")]
#[diagnostic(help("let it make at least four passes"))]
pub(super) struct PilotTooShortError {
    passes: u32,
}

/// JSON report: estimated cost of a render by one algorithm, for each target error of `--errors`.
#[derive(Debug, Serialize)]
pub(super) struct CostEstimateReport {
    schema: u32,
    version: &'static str,
    scene: String,
    pub(super) integrator: &'static str,
    width: u32,
    height: u32,
    threads: usize,
    /// True if the scene has caustics and the algorithm traces no photons, so that it finds
    /// caustics only by chance. The estimated error then leaves out the caustics that the pilot
    /// (short render) did not find.
    #[serde(rename = "misses_caustics")]
    pub(super) may_miss_caustics: bool,
    /// Estimated error of the picture of the pilot, which is a short render.
    #[serde(rename = "pilot")]
    pilot_error: ErrorEstimate,
    /// Largest part of the bias that remains after any number of passes; `None` if no bias remains.
    #[serde(skip)]
    largest_remaining_bias: Option<BiasPart>,
    /// Time before the first pass \[s]: loading the scene and preparing the algorithm.
    setup_seconds: f64,
    /// Time of each pass after the first \[s].
    pass_seconds: f64,
    /// Mean number of photon paths that a pass emits.
    #[serde(rename = "pass_photons")]
    photon_paths_per_pass: f64,
    peak_memory_bytes: Option<u64>,
    /// Probability that a render takes between `seconds_low` and `seconds_high`, the time range in
    /// its [`CostEstimate`].
    #[serde(rename = "range_probability")]
    time_range_probability: f64,
    #[serde(rename = "prices")]
    pub(super) estimates: Vec<CostEstimate>,
    /// Expected end of a render that has only the default limits of error and time, without the
    /// flags `--passes`, `--time`, `--target-error` and `--preview`. `None` if no limit is expected
    /// to end it.
    #[serde(rename = "default")]
    default_end: Option<ExpectedEndReport>,
    /// Expected end of a render with the flag `--preview` and no other limit. `None` if its limits
    /// are not expected to end the render.
    #[serde(rename = "preview")]
    preview_end: Option<ExpectedEndReport>,
}

/// Expected end of a render: its reason, and the passes, time and error at that end.
#[derive(Debug, Serialize)]
struct ExpectedEndReport {
    #[serde(rename = "ended")]
    end_reason: EndReason,
    passes: u32,
    /// Expected time of the render, including loading and preparation \[s].
    seconds: f64,
    /// Expected relative error of the picture at the end.
    error: f64,
}

/// Estimated cost of a render that stops at one target error.
#[derive(Debug, Serialize)]
pub(super) struct CostEstimate {
    #[serde(rename = "error")]
    pub(super) target_error: f64,
    /// Predicted number of passes until the estimated error is at most the target error: median of
    /// the forecast. `None` if the pilot (short render) is too short for a prediction, or if bias
    /// stays above the target error.
    passes: Option<u32>,
    /// Expected time of the render for `passes` passes, including loading and preparation \[s];
    /// `None` if `passes` is `None`.
    pub(super) seconds: Option<f64>,
    /// Lower end of the range of likely times of the render \[s]. If `seconds` is unknown, the
    /// render takes at least this time. `None` if bias stays above the target error.
    seconds_low: Option<f64>,
    /// Upper end of the range of likely times of the render \[s]; `None` if it is too far to
    /// predict, or if bias stays above the target error.
    seconds_high: Option<f64>,
    /// Expected number of photon paths; `None` if `passes` is `None`.
    #[serde(rename = "photons")]
    photon_paths: Option<f64>,
    /// Relative bias that remains in the picture after any number of passes, if this bias is above
    /// the target error; `None` if the target error can be reached.
    #[serde(rename = "floor")]
    pub(super) bias_floor: Option<f64>,
    /// Flags with which `caustica render` stops at the target error; `None` if bias stays above it.
    #[serde(rename = "flags")]
    render_flags: Option<String>,
}

impl CostEstimateReport {
    /// Creates the report of a pilot (short render) by the algorithm of `method`.
    ///
    /// `misses_caustics` is true if that algorithm finds caustics of the scene only by chance.
    /// `setup` is the time before the first pass \[s]: loading the scene and preparing the
    /// algorithm. `pass_seconds` is the time of each later pass \[s]. `default` holds the stop
    /// criteria of a render without limits on the command line. `preview` holds those of a render
    /// with `--preview` alone.
    ///
    /// Returns an error if the pilot made too few passes to estimate its error.
    pub(super) fn new(
        arguments: &EstimateArguments,
        (method, misses_caustics): (&MethodArguments, bool),
        rendered: &RenderResult,
        (setup, pass_seconds): (f64, f64),
        [default, preview]: &[StopCriteria<'_>; 2],
    ) -> Result<Self, PilotTooShortError> {
        let passes = rendered.film.passes();
        let estimator = rendered.estimator.as_ref();
        let pilot = estimator.map(|estimator| estimator.estimate(&rendered.film)).unwrap_or_default();
        let forecast = estimator.and_then(|estimator| estimator.forecast(&pilot));
        let forecast = forecast.ok_or(PilotTooShortError { passes })?;
        let pass_photons = (rendered.unaimed.emitted_paths + rendered.aimed.emitted_paths) as f64 / f64::from(passes);
        let mut words = method_flags(method, "--effects", arguments.effects.effects);
        if method.seed != 0 {
            words.extend(["--seed".to_owned(), method.seed.to_string()]);
        }
        if let Some((width, height)) = arguments.scene.size {
            words.extend(["--size".to_owned(), format!("{width}x{height}")]);
        }
        words.extend(arguments.scene.import.reproducing_flags());
        let words = words.join(" ");
        let estimate = |error: &f64| {
            let estimate = CostEstimate::new(*error, &forecast, (setup, pass_seconds, pass_photons));
            // `render` takes an error of 1 or more only with a percent sign.
            let error = if *error < 1.0 { error.to_string() } else { format!("{}%", 100.0 * error) };
            let flags = estimate.bias_floor.is_none().then(|| format!("{words} --target-error {error}"));
            CostEstimate { render_flags: flags, ..estimate }
        };
        let expected_end = |stop: &StopCriteria<'_>| {
            let ExpectedEnd { reason, passes, error } = stop.expected_end(&forecast, pass_seconds)?;
            Some(ExpectedEndReport {
                end_reason: reason,
                passes,
                seconds: setup + f64::from(passes) * pass_seconds,
                error,
            })
        };
        let (width, height) = rendered.film.size();
        Ok(Self {
            schema: 3,
            version: env!("CARGO_PKG_VERSION"),
            scene: arguments.scene.scene.display().to_string(),
            integrator: method.integrator.name(),
            width,
            height,
            threads: rayon::current_num_threads(),
            may_miss_caustics: misses_caustics,
            pilot_error: pilot,
            largest_remaining_bias: forecast.largest_remaining_bias(),
            setup_seconds: setup,
            pass_seconds,
            photon_paths_per_pass: pass_photons,
            peak_memory_bytes: peak_memory(),
            time_range_probability: RANGE_PROBABILITY,
            estimates: arguments.errors.iter().map(estimate).collect(),
            default_end: expected_end(default),
            preview_end: expected_end(preview),
        })
    }

    /// Returns the report as a table for a terminal.
    pub(super) fn text_table(&self) -> String {
        let Self { pilot_error: pilot, peak_memory_bytes, largest_remaining_bias: remaining_bias, .. } = self;
        let memory = peak_memory_bytes.map_or("?".to_owned(), |bytes| format!("{}B", count_text(bytes as f64)));
        let mut text = format!(
            "{} at {} × {}: after {} passes the estimated error is {}\n",
            self.integrator,
            self.width,
            self.height,
            pilot.passes,
            forecast_text::error_text(pilot)
        );
        let range = format!("{} range", percent_text(RANGE_PROBABILITY));
        let _ = writeln!(
            text,
            "  {:>7} {:>9} {:>14} {range:>24} {:>9} {:>8}  flags",
            "error", "passes", "time", "photons", "memory"
        );
        for estimate in &self.estimates {
            let error = percent_text(estimate.target_error);
            let (Some(passes), Some(time)) = (estimate.passes, estimate.seconds) else {
                let why = match estimate.bias_floor.zip(*remaining_bias) {
                    Some((floor, part)) => {
                        format!(
                            "never: {} is bias that stays; {}",
                            percent_text(floor),
                            forecast_text::bias_remedy(part)
                        )
                    }
                    None => format!(
                        "cannot tell yet: at least {}; a longer --pilot tells more",
                        estimate.seconds_low.map_or(String::new(), duration_text)
                    ),
                };
                let _ = writeln!(text, "  {error:>7} {why}");
                continue;
            };
            let ends = [estimate.seconds_low, estimate.seconds_high].map(|t| t.map_or("?".to_owned(), duration_text));
            let _ = writeln!(
                text,
                "  {error:>7} {passes:>9} {:>14} {:>24} {:>9} {memory:>8}  {}",
                duration_text(time),
                ends.join(" to "),
                estimate.photon_paths.map_or(String::new(), count_text),
                estimate.render_flags.as_deref().unwrap_or_default(),
            );
        }
        let ends = [
            ("without a limit", DEFAULT_TARGET_ERROR, &self.default_end),
            ("with --preview", PREVIEW_TARGET_ERROR, &self.preview_end),
        ];
        for (flags, target, end) in ends {
            if let Some(end) = end {
                let _ = writeln!(text, "{flags}, a render ends {}", end.text(target));
            }
        }
        text
    }
}

impl ExpectedEndReport {
    /// Returns a phrase that completes the sentence "a render ends …": whether an error of
    /// `target`, the time limit or bias ends the render, and after how many passes.
    fn text(&self, target: f64) -> String {
        let passes = count_with_noun(self.passes as usize, "pass", "passes");
        let (time, target, error) = (duration_text(self.seconds), percent_text(target), percent_text(self.error));
        match self.end_reason {
            EndReason::Target => format!("at an error of {target}, after about {passes} and {time}"),
            EndReason::Time => format!("by time, after about {passes} and {time}, at an error of about {error}"),
            EndReason::BiasFloor => {
                format!("by bias, which keeps the error above {target}: at about {error}, after {passes} and {time}")
            }
            EndReason::Passes | EndReason::Interrupted => format!("after {passes} and about {time}"),
        }
    }
}

impl CostEstimate {
    fn new(error: f64, forecast: &ErrorForecast, (setup, pass_seconds, pass_photons): (f64, f64, f64)) -> Self {
        let target = ErrorTarget { error, confidence: Confidence::default() };
        let time = |n: u32| setup + pass_seconds * f64::from(n);
        let unknown = Self {
            target_error: error,
            passes: None,
            seconds: None,
            seconds_low: None,
            seconds_high: None,
            photon_paths: None,
            bias_floor: None,
            render_flags: None,
        };
        match forecast.stop_forecast(error, target.interval_confidence()) {
            StopForecast::Passes(range) => Self {
                passes: Some(range.median),
                seconds: Some(time(range.median)),
                seconds_low: Some(time(range.low)),
                seconds_high: range.high.map(time),
                photon_paths: Some(f64::from(range.median) * pass_photons),
                ..unknown
            },
            StopForecast::Never { floor } => Self { bias_floor: Some(floor), ..unknown },
            StopForecast::TooFar { at_least } => Self { seconds_low: Some(time(at_least)), ..unknown },
        }
    }
}
