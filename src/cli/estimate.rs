//! `caustica estimate`: predicts the passes, time and photons until a given error.
//!
//! For each algorithm, the command renders a pilot, which is a short render, and extrapolates the
//! pilot's error estimate.

mod comparison;
mod report;

use super::args::MethodArguments;
use super::forecast_text::ErrorEstimateUnsupportedError;
use super::interrupt::{INTERRUPTED, listen_for_signals};
use super::plan::{finds_caustics_only_by_chance, print_plan};
use super::progress::ProgressDisplay;
use super::scene::{load_scene, with_thread_pool};
use super::settings::settings_from_arguments;
use super::{CommandFailure, EstimateArguments, Exit};
use crate::integrate::{Algorithm, Integrator};
use crate::render::{
    RenderLimits, RenderResult, StopCriteria, check_photon_memory, check_picture_and_error_memory, render,
};
use crate::scene::Scene;
use comparison::{CostComparison, check_comparable};
use report::CostEstimateReport;
use std::io::Write as _;
use std::time::{Duration, Instant};

/// Smallest number of passes of the pilot, a short render whose error is extrapolated. The error
/// estimate of fewer passes would miss rare bright paths.
const MIN_PILOT_PASSES: u32 = 8;

pub(super) fn run(arguments: &EstimateArguments) -> Result<Exit, CommandFailure> {
    if arguments.method.integrator == Algorithm::Raycast {
        return Err(CommandFailure::usage_error(ErrorEstimateUnsupportedError { flag: "estimate" }));
    }
    check_comparable(&arguments.compare).map_err(CommandFailure::usage_error)?;
    listen_for_signals("the result of the pilot so far is written after this pass");
    let progress = ProgressDisplay::new(arguments.quiet);
    with_thread_pool(&arguments.scene, || {
        let start = Instant::now();
        let scene = load_scene(&arguments.scene, &progress)?;
        let load_seconds = start.elapsed().as_secs_f64();
        let report = estimate_method_cost(arguments, &arguments.method, &scene, load_seconds, &progress)?;
        let mut comparison = CostComparison::new(report);
        for algorithm in &arguments.compare {
            if comparison.has_no_report_of(*algorithm) && !is_interrupted() {
                let method = MethodArguments { integrator: *algorithm, ..arguments.method.clone() };
                match estimate_method_cost(arguments, &method, &scene, load_seconds, &progress) {
                    Ok(report) => comparison.add_report(report),
                    // After an interruption, compare no further algorithm, and print the reports so
                    // far.
                    Err(failure) if failure.exit == Exit::Interrupted => break,
                    Err(failure) => return Err(failure),
                }
            }
        }
        let text = if arguments.json {
            let json = serde_json::to_string_pretty(&comparison);
            json.map_err(CommandFailure::output_error)? + "\n"
        } else {
            comparison.text()
        };
        let written = std::io::stdout().write_all(text.as_bytes());
        written.map_err(CommandFailure::output_error)?;
        Ok(if is_interrupted() { Exit::Interrupted } else { Exit::Success })
    })
}

fn is_interrupted() -> bool {
    INTERRUPTED.load(std::sync::atomic::Ordering::Relaxed)
}

/// Renders a pilot (short render) by the algorithm of `method`. Estimates the cost of a full render
/// for each error that the command line names.
///
/// `load_seconds` is the time that loading the scene took \[s].
fn estimate_method_cost(
    arguments: &EstimateArguments,
    method: &MethodArguments,
    scene: &Scene,
    load_seconds: f64,
    progress: &ProgressDisplay,
) -> Result<CostEstimateReport, CommandFailure> {
    let start = Instant::now();
    let mut settings = settings_from_arguments(method, arguments.effects.effects);
    settings.camera_paths.estimate_error = true;
    let memory = arguments.scene.memory_limit();
    let picture_bytes = check_picture_and_error_memory(1, scene.camera().size(), memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    let integrator = method.integrator.prepare(scene, settings);
    check_photon_memory(integrator.expected_photons(), picture_bytes, memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    print_plan(integrator.as_ref(), progress);
    progress.remove_progress_bar();
    let setup = load_seconds + start.elapsed().as_secs_f64();
    let (rendered, pass_seconds) = render_pilot(arguments, integrator.as_ref(), scene.camera().size(), progress);
    let ends = [false, true].map(|preview| {
        let limits = RenderLimits { preview, ..RenderLimits::default() };
        let stop = limits.stop_criteria(method.integrator, integrator.as_ref(), &INTERRUPTED);
        StopCriteria { time_before_passes: Duration::from_secs_f64(setup), ..stop }
    });
    let method = (method, finds_caustics_only_by_chance(integrator.as_ref()));
    let report = CostEstimateReport::new(arguments, method, &rendered, (setup, pass_seconds), &ends);
    report.map_err(|e| CommandFailure::new(Exit::Interrupted, e))
}

/// Renders the pilot, a short render whose error and times give the forecasts of full renders.
///
/// Returns the result of the pilot, and the expected time of each pass after the first \[s].
fn render_pilot(
    arguments: &EstimateArguments,
    integrator: &dyn Integrator,
    size: (u32, u32),
    progress: &ProgressDisplay,
) -> (RenderResult, f64) {
    let stop = StopCriteria {
        min_passes: MIN_PILOT_PASSES,
        time_limit: Some(arguments.pilot),
        ..StopCriteria::unlimited(&INTERRUPTED)
    };
    let (began, mut first) = (Instant::now(), 0.0);
    progress.set_pass_number(1, None);
    progress.set_time_left(Some(arguments.pilot));
    let start = RenderResult::without_passes(integrator, size);
    let rendered = render(start, 0..u32::MAX, integrator, &stop, progress, |standing| {
        if standing.passes == 1 {
            first = began.elapsed().as_secs_f64();
        }
        progress.set_pass_number(standing.passes + 1, None);
    });
    progress.remove_progress_bar();
    // The first pass takes longer than later ones, because caches are cold. So leave it out of the
    // mean.
    let (passes, wall) = (rendered.film.passes(), rendered.wall_time.as_secs_f64());
    let pass_seconds = if passes > 2 { (wall - first) / f64::from(passes - 1) } else { wall / f64::from(passes) };
    (rendered, pass_seconds)
}
