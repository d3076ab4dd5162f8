//! `caustica study --effects`: the cost and the contribution of each effect.

use super::output::{ReportFormatter, StudyOutputs, study_output_files};
use crate::cli::input_files::InputFileCollector;
use crate::cli::interrupt::{INTERRUPTED, listen_for_signals};
use crate::cli::outputs::{FileWithRole, check_distinct_files};
use crate::cli::plan::{self, EffectDecisionReport};
use crate::cli::progress::{ProgressDisplay, print_message, warn_of_rejected_samples};
use crate::cli::scene::{load_scene, with_thread_pool};
use crate::cli::settings::settings_from_arguments;
use crate::cli::{CommandFailure, Exit, StudyArguments};
use crate::plan::EffectDecision;
use crate::render::{check_photon_memory, check_picture_memory};
use crate::scene::{Effect, Scene};
use crate::stats::Counters;
use crate::study::report::effects::{csv_report, markdown_report};
use crate::study::text::{count_text, percent_text, signed_count_text, signed_milliseconds_text, three_digit_text};
use crate::study::{
    AddedCost, ClockKind, EffectContribution, EffectReportHeader, EffectStudy, EffectStudyResult, PictureCost,
    effects_html_page,
};
use miette::IntoDiagnostic;
use serde::Serialize;
use std::fmt::Write as _;
use std::time::Instant;

/// Default number of passes of each picture of `caustica study --effects`.
const DEFAULT_PASSES: u32 = 4;

/// File extensions of reports, each with the function that makes the report as text.
const REPORT_FORMATTERS: [(&str, ReportFormatter<EffectStudyResult>); 4] = [
    ("html", |arguments, result| effects_html_page(&effect_report_header(arguments), result).into_diagnostic()),
    ("csv", |_, result| Ok(csv_report(result))),
    ("json", effect_study_json),
    ("md", |arguments, result| Ok(markdown_report(&effect_report_header(arguments), result))),
];

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, CommandFailure> {
    // Everything that can fail without rendering is checked before rendering.
    let outputs = StudyOutputs::from_arguments(arguments, &REPORT_FORMATTERS)?;
    listen_for_signals("the study so far is written after this pass");
    let progress = ProgressDisplay::new(arguments.quiet);
    with_thread_pool(&arguments.scene, || run_effect_study(arguments, &outputs, &progress))
}

fn run_effect_study(
    arguments: &StudyArguments,
    outputs: &StudyOutputs<'_, EffectStudyResult>,
    progress: &ProgressDisplay,
) -> Result<Exit, CommandFailure> {
    let start = Instant::now();
    let scene = load_study_scene(arguments, progress)?;
    let algorithm = arguments.method.integrator;
    // The study holds the full picture, and at most one further picture for each effect.
    let memory = arguments.scene.memory_limit();
    let picture_bytes = check_picture_memory(Effect::ALL.len() + 1, scene.camera().size(), memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    let study =
        EffectStudy::prepare(&scene, algorithm, &settings_from_arguments(&arguments.method, arguments.simulate));
    check_photon_memory(study.max_expected_photon_counts(), picture_bytes, memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    progress.print_line(&plan::simulated_effects_line(study.plan()));
    plan::omitted_effect_warnings(study.plan()).for_each(|line| print_message(&line));
    let (pictures, passes) = (study.picture_count(), arguments.passes.unwrap_or(DEFAULT_PASSES));
    progress.print_line(&format!("{pictures} pictures of {passes} passes each"));
    progress.set_pass_number(1, Some(passes));
    let result = study.run(passes, &INTERRUPTED, progress, |made| {
        if progress.uses_plain_lines() {
            progress.print_line(&format!("pass {made}/{passes} of each after {:.1} s", start.elapsed().as_secs_f64()));
        }
        progress.set_pass_number(made + 1, Some(passes));
    });
    progress.remove_progress_bar();
    let result = result.into_diagnostic().map_err(|e| CommandFailure::new(Exit::Input, e))?;
    warn_of_rejected_samples(&result.full_picture_cost.counters);
    let text = if arguments.json {
        effect_study_json(arguments, &result).map(|json| json + "\n")
    } else {
        Ok(effects_table(arguments.method.integrator.name(), &result))
    };
    let exit = if result.interrupted { Exit::Interrupted } else { Exit::Success };
    outputs.write_reports(arguments, &result, text, progress, exit)
}

/// Loads the scene of a study. Returns a failure if an output is one of the scene's files.
pub(super) fn load_study_scene(
    arguments: &StudyArguments,
    progress: &ProgressDisplay,
) -> Result<Scene, CommandFailure> {
    let inputs = InputFileCollector::new(progress);
    let scene = load_scene(&arguments.scene, &inputs)?;
    progress.remove_progress_bar();
    let inputs: Vec<FileWithRole> =
        inputs.into_input_paths().iter().map(|path| FileWithRole::new("the input", path)).collect();
    check_distinct_files(&study_output_files(arguments), &inputs)?;
    Ok(scene)
}

/// Returns the scene name and settings that a report shows at its top.
fn effect_report_header(arguments: &StudyArguments) -> EffectReportHeader {
    let scene = arguments.scene.scene.display().to_string();
    let (integrator, seed) = (arguments.method.integrator.name(), arguments.method.seed);
    EffectReportHeader { scene_name: scene, integrator, seed, exposure: arguments.exposure }
}

/// Returns the results of a study of effects as JSON.
fn effect_study_json(arguments: &StudyArguments, result: &EffectStudyResult) -> miette::Result<String> {
    let scene = arguments.scene.scene.display().to_string();
    let report = EffectStudyReport::new(scene, arguments.method.integrator.name(), arguments.method.seed, result);
    serde_json::to_string_pretty(&report).into_diagnostic()
}

/// Returns the results of a study of effects as a text table.
fn effects_table(integrator: &str, result: &EffectStudyResult) -> String {
    let clock = match result.clock {
        ClockKind::Processor => "processor",
        ClockKind::Wall => "wall",
    };
    let full_cost = &result.full_picture_cost;
    let passes = full_cost.pass_seconds.len() as f64;
    let mut text = format!(
        "{integrator}: {:.1} ms of {clock} time, {} rays and {} gathered photons per pass; mean radiance {}\n",
        1e3 * full_cost.total_pass_seconds() / passes,
        count_text(full_cost.counters.total_rays() as f64 / passes),
        count_text(full_cost.counters.gathered_photons as f64 / passes),
        three_digit_text(result.mean_radiance),
    );
    if !result.effects.is_empty() {
        let _ = writeln!(
            text,
            "  {:<16} {:>18} {:>7} {:>9} {:>10} {:>9} {:>9} {:>9}",
            "effect", "ms per pass", "time", "rays", "gathered", "changes", "adds", "takes"
        );
    }
    for finding in &result.effects {
        let AddedCost {
            seconds_per_pass: seconds,
            seconds_standard_error: seconds_error,
            time_ratio: ratio,
            rays,
            gathered_photons,
            ..
        } = finding.added_cost;
        let EffectContribution { relative_rmse, added_radiance: adds, removed_radiance: removes, rmse } =
            finding.contribution;
        let error = seconds_error.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        let share = |x: f64| {
            if result.mean_radiance > 0.0 { percent_text(x / result.mean_radiance) } else { three_digit_text(x) }
        };
        let _ = writeln!(
            text,
            "  {:<16} {:>18} {:>7} {:>9} {:>10} {:>9} {:>9} {:>9}",
            finding.decision.effect,
            signed_milliseconds_text(seconds) + &error,
            format!("× {ratio:.2}"),
            signed_count_text(rays),
            signed_count_text(gathered_photons),
            relative_rmse.map_or(three_digit_text(rmse), percent_text),
            share(adds),
            share(removes),
        );
    }
    for decision in result.effect_plan.decisions.iter().filter(|d| !d.is_simulated) {
        let forced = if decision.is_forced_against_need() { ", forced, although " } else { ": " };
        let _ = writeln!(text, "  {:<16} off{forced}{}", decision.effect, decision.reason);
    }
    text
}

/// JSON report of `study --effects`: the cost and the contribution of each effect of light, such as
/// caustics.
#[derive(Debug, Serialize)]
struct EffectStudyReport<'f> {
    schema: u32,
    version: &'static str,
    scene: String,
    integrator: &'static str,
    width: u32,
    height: u32,
    seed: u64,
    passes: usize,
    interrupted: bool,
    clock: ClockKind,
    #[serde(rename = "mean")]
    mean_radiance: f64,
    #[serde(rename = "whole")]
    full_picture_cost: PictureCostReport<'f>,
    effects: Vec<EffectResultReport<'f>>,
}

/// JSON of the time \[s] and work of rendering one picture.
#[derive(Debug, Serialize)]
struct PictureCostReport<'f> {
    #[serde(rename = "setup")]
    setup_seconds: f64,
    #[serde(rename = "seconds")]
    total_pass_seconds: f64,
    counters: &'f Counters,
}

/// JSON of the cost and contribution of one effect.
#[derive(Debug, Serialize)]
struct EffectResultReport<'f> {
    #[serde(flatten)]
    effect_decision: EffectDecisionReport,
    /// Time and counters of the picture without the effect; `None` if the effect is off.
    #[serde(rename = "without")]
    cost_without_effect: Option<PictureCostReport<'f>>,
    /// Cost of the effect: time and rays per pass of the picture with all effects, minus those of
    /// the picture without this effect. `None` if the effect is off.
    cost: Option<AddedCost>,
    /// Mean light that the effect adds to the picture, and mean light that it removes, as shadows
    /// do; `None` if the effect is off.
    #[serde(rename = "gain")]
    contribution: Option<EffectContribution>,
}

impl<'f> From<&'f PictureCost> for PictureCostReport<'f> {
    fn from(spent: &'f PictureCost) -> Self {
        Self {
            setup_seconds: spent.setup_seconds,
            total_pass_seconds: spent.total_pass_seconds(),
            counters: &spent.counters,
        }
    }
}

impl<'f> EffectStudyReport<'f> {
    fn new(scene: String, integrator: &'static str, seed: u64, result: &'f EffectStudyResult) -> Self {
        let row = |(effect, decision): (EffectDecisionReport, &EffectDecision)| {
            let finding = result.effects.iter().find(|f| f.decision.effect == decision.effect);
            EffectResultReport {
                effect_decision: effect,
                cost_without_effect: finding.map(|f| (&f.cost_without_effect).into()),
                cost: finding.map(|f| f.added_cost),
                contribution: finding.map(|f| f.contribution),
            }
        };
        Self {
            schema: 2,
            version: env!("CARGO_PKG_VERSION"),
            scene,
            integrator,
            width: result.picture.width(),
            height: result.picture.height(),
            seed,
            passes: result.full_picture_cost.pass_seconds.len(),
            interrupted: result.interrupted,
            clock: result.clock,
            mean_radiance: result.mean_radiance,
            full_picture_cost: (&result.full_picture_cost).into(),
            effects: plan::plan_effect_reports(&result.effect_plan)
                .into_iter()
                .zip(&result.effect_plan.decisions)
                .map(row)
                .collect(),
        }
    }
}
