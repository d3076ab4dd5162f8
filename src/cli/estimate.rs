//! `caustica estimate`: predicts the passes, time and photons until a given error.
//!
//! The command renders a short pilot and extrapolates the pilot's error estimate.

use super::forecast_text::{self, ErrorEstimateUnsupportedError, duration_text};
use super::interrupt::{INTERRUPTED, listen_for_signals};
use super::memory::{check_error_estimate_memory, check_photon_memory};
use super::number::count_with_noun;
use super::plan::print_plan;
use super::progress::ProgressDisplay;
use super::scene::{load_scene, with_thread_pool};
use super::settings::{method_flags, settings_from_arguments};
use super::{CommandFailure, EstimateArguments, Exit};
use crate::integrate::{Algorithm, Integrator};
use crate::render::error_estimate::{Confidence, ErrorEstimate, ErrorForecast, RANGE_PROBABILITY, StopForecast};
use crate::render::{
    DEFAULT_ERROR, EndReason, ErrorTarget, ExpectedEnd, PREVIEW_ERROR, RenderLimits, RenderResult, StopCriteria, render,
};
use crate::stats::peak_memory;
use crate::study::text::{count_text, percent_text};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

/// Smallest number of passes of the pilot. Fewer would miss rare paths.
const MIN_PILOT_PASSES: u32 = 8;

/// Error: the pilot was interrupted before its error could be estimated.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the pilot ended after {passes} passes, too few to estimate an error")]
#[diagnostic(help("let it make at least four passes"))]
struct PilotTooShortError {
    passes: u32,
}

pub(super) fn run(arguments: &EstimateArguments) -> Result<Exit, CommandFailure> {
    if arguments.method.integrator == Algorithm::Raycast {
        return Err(CommandFailure::usage_error(ErrorEstimateUnsupportedError { flag: "estimate" }));
    }
    listen_for_signals("the result of the pilot");
    let progress = ProgressDisplay::new(arguments.quiet);
    with_thread_pool(&arguments.scene, || {
        let start = Instant::now();
        let scene = load_scene(&arguments.scene, &progress)?;
        let algorithm = arguments.method.integrator;
        let mut settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
        settings.camera_paths.estimate_error = true;
        let memory = arguments.scene.memory_limit();
        let pictures = check_error_estimate_memory(1, scene.camera().size(), memory.available_bytes())
            .map_err(CommandFailure::usage_error)?;
        let integrator = algorithm.prepare(&scene, settings);
        check_photon_memory(integrator.expected_photons(), pictures, memory.available_bytes())
            .map_err(CommandFailure::usage_error)?;
        print_plan(integrator.as_ref(), &progress);
        progress.remove_progress_bar();
        let setup = start.elapsed().as_secs_f64();
        let (rendered, pass_seconds) = render_pilot(arguments, integrator.as_ref(), scene.camera().size(), &progress);
        let ends = [false, true].map(|preview| {
            let limits = RenderLimits { preview, ..RenderLimits::default() };
            limits.stop_criteria(algorithm, integrator.as_ref(), &INTERRUPTED)
        });
        let report = CostEstimateReport::new(arguments, algorithm, &rendered, (setup, pass_seconds), &ends);
        let report = report.map_err(|e| CommandFailure::new(Exit::Interrupted, e))?;
        let text = if arguments.json {
            let json = serde_json::to_string_pretty(&report);
            json.map_err(CommandFailure::output_error)? + "\n"
        } else {
            report.text_table()
        };
        let written = std::io::stdout().write_all(text.as_bytes());
        written.map_err(CommandFailure::output_error)?;
        let interrupted = INTERRUPTED.load(std::sync::atomic::Ordering::Relaxed);
        Ok(if interrupted { Exit::Interrupted } else { Exit::Success })
    })
}

/// Renders the pilot: a short render from which costs are extrapolated.
///
/// Returns the pilot's result, and the expected time of each later pass \[s].
fn render_pilot(
    arguments: &EstimateArguments,
    integrator: &dyn Integrator,
    size: (u32, u32),
    progress: &ProgressDisplay,
) -> (RenderResult, f64) {
    let stop = StopCriteria {
        min_passes: MIN_PILOT_PASSES,
        time: Some(arguments.pilot),
        ..StopCriteria::unlimited(&INTERRUPTED)
    };
    let (began, mut first) = (Instant::now(), 0.0);
    progress.set_pass_number(1, None);
    progress.set_time_left(Some(arguments.pilot));
    let rendered = render(integrator, size, &stop, progress, |standing| {
        if standing.passes == 1 {
            first = began.elapsed().as_secs_f64();
        }
        progress.set_pass_number(standing.passes + 1, None);
    });
    progress.remove_progress_bar();
    // The first pass takes longer, because caches are cold.
    let (passes, wall) = (rendered.film.passes(), rendered.wall.as_secs_f64());
    let pass_seconds = if passes > 2 { (wall - first) / f64::from(passes - 1) } else { wall / f64::from(passes) };
    (rendered, pass_seconds)
}

/// JSON report of `caustica estimate`: estimated costs of all requested errors.
#[derive(Debug, Serialize)]
struct CostEstimateReport {
    schema: u32,
    version: &'static str,
    scene: String,
    integrator: &'static str,
    width: u32,
    height: u32,
    threads: usize,
    /// Estimated error of the pilot's picture.
    pilot: ErrorEstimate,
    setup_seconds: f64,
    pass_seconds: f64,
    pass_photons: f64,
    peak_memory_bytes: Option<u64>,
    /// Probability that the time of a render lies between `seconds_low` and `seconds_high` of its
    /// price.
    range_probability: f64,
    #[serde(rename = "prices")]
    estimates: Vec<CostEstimate>,
    /// Expected end of a render without limits.
    default: Option<ExpectedEndReport>,
    /// Expected end of a render with `--preview` and without limits.
    preview: Option<ExpectedEndReport>,
}

/// Expected end of a render.
#[derive(Debug, Serialize)]
struct ExpectedEndReport {
    ended: EndReason,
    passes: u32,
    /// Expected time of the render, with preparation \[s].
    seconds: f64,
    /// Expected relative error of the picture.
    error: f64,
}

/// Estimated cost of a render that ends by one error target.
#[derive(Debug, Serialize)]
struct CostEstimate {
    error: f64,
    /// Expected number of passes: the median; `None` if it is unknown or no number is enough.
    passes: Option<u32>,
    /// Expected time of the render, with preparation \[s]; `None` if `passes` is.
    seconds: Option<f64>,
    /// Lower end of the range of likely times \[s].
    seconds_low: Option<f64>,
    /// Upper end of the range of likely times \[s]; `None` if it is unknown.
    seconds_high: Option<f64>,
    photons: Option<f64>,
    /// Relative bias that no number of passes removes; `None` if bias does not prevent the error.
    floor: Option<f64>,
    /// Flags of `caustica render` that reach this error; `None` if the error cannot be reached.
    flags: Option<String>,
}

impl CostEstimateReport {
    fn new(
        arguments: &EstimateArguments,
        algorithm: Algorithm,
        rendered: &RenderResult,
        (setup, pass_seconds): (f64, f64),
        [default, preview]: &[StopCriteria<'_>; 2],
    ) -> Result<Self, PilotTooShortError> {
        let passes = rendered.film.passes();
        let estimator = rendered.estimator.as_ref();
        let pilot = estimator.map(|estimator| estimator.estimate(&rendered.film)).unwrap_or_default();
        let forecast = estimator.and_then(|estimator| estimator.forecast(&pilot));
        let forecast = forecast.ok_or(PilotTooShortError { passes })?;
        let pass_photons = (rendered.unaimed.emitted + rendered.aimed.emitted) as f64 / f64::from(passes);
        let mut words = method_flags(&arguments.method, "--effects", arguments.effects.effects);
        if arguments.method.seed != 0 {
            words.extend(["--seed".to_owned(), arguments.method.seed.to_string()]);
        }
        if let Some((width, height)) = arguments.scene.size {
            words.extend(["--size".to_owned(), format!("{width}x{height}")]);
        }
        let words = words.join(" ");
        let estimate = |error: &f64| {
            let estimate = CostEstimate::new(*error, &forecast, (setup, pass_seconds, pass_photons));
            let flags = estimate.floor.is_none().then(|| format!("{words} --target-error {error}"));
            CostEstimate { flags, ..estimate }
        };
        let expected_end = |stop: &StopCriteria<'_>| {
            let ExpectedEnd { ended, passes, error } = stop.expected_end(&forecast, pass_seconds)?;
            Some(ExpectedEndReport { ended, passes, seconds: setup + f64::from(passes) * pass_seconds, error })
        };
        let (width, height) = rendered.film.size();
        Ok(Self {
            schema: 3,
            version: env!("CARGO_PKG_VERSION"),
            scene: arguments.scene.scene.display().to_string(),
            integrator: algorithm.name(),
            width,
            height,
            threads: rayon::current_num_threads(),
            pilot,
            setup_seconds: setup,
            pass_seconds,
            pass_photons,
            peak_memory_bytes: peak_memory(),
            range_probability: RANGE_PROBABILITY,
            estimates: arguments.errors.iter().map(estimate).collect(),
            default: expected_end(default),
            preview: expected_end(preview),
        })
    }

    fn text_table(&self) -> String {
        let Self { pilot, peak_memory_bytes, .. } = self;
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
            let error = percent_text(estimate.error);
            let (Some(passes), Some(time)) = (estimate.passes, estimate.seconds) else {
                let why = match estimate.floor {
                    Some(floor) => {
                        format!("never: {} is bias that stays; {}", percent_text(floor), forecast_text::BIAS_REMEDY)
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
                estimate.photons.map_or(String::new(), count_text),
                estimate.flags.as_deref().unwrap_or_default(),
            );
        }
        let ends =
            [("without a limit", DEFAULT_ERROR, &self.default), ("with --preview", PREVIEW_ERROR, &self.preview)];
        for (flags, target, end) in ends {
            if let Some(end) = end {
                let _ = writeln!(text, "{flags}, a render ends {}", end.text(target));
            }
        }
        text
    }
}

impl ExpectedEndReport {
    /// Returns the end of a render whose default error is `target`, as the end of a sentence.
    fn text(&self, target: f64) -> String {
        let passes = count_with_noun(self.passes as usize, "pass", "passes");
        let (time, target, error) = (duration_text(self.seconds), percent_text(target), percent_text(self.error));
        match self.ended {
            EndReason::Target => format!("at an error of {target}, after about {passes} and {time}"),
            EndReason::Time => format!("by time, after about {passes} and {time}, at an error of about {error}"),
            EndReason::Floor => {
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
            error,
            passes: None,
            seconds: None,
            seconds_low: None,
            seconds_high: None,
            photons: None,
            floor: None,
            flags: None,
        };
        match forecast.stop(error, target.interval_confidence()) {
            StopForecast::Passes(range) => Self {
                passes: Some(range.median),
                seconds: Some(time(range.median)),
                seconds_low: Some(time(range.low)),
                seconds_high: range.high.map(time),
                photons: Some(f64::from(range.median) * pass_photons),
                ..unknown
            },
            StopForecast::Never { floor } => Self { floor: Some(floor), ..unknown },
            StopForecast::TooFar { at_least } => Self { seconds_low: Some(time(at_least)), ..unknown },
        }
    }
}
