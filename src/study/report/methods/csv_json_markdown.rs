//! CSV, JSON and Markdown reports of a study of methods.

use super::analysis::{MethodStudyAnalysis, TARGET_ERRORS, time_to_error_text};
use super::warnings::study_warnings;
use crate::study::methods::fit::{
    ConvergenceFit, ErrorComponent, MethodRecommendation, ParetoPoint, SlopeRange, TimeToError,
    mean_confidence_interval,
};
use crate::study::methods::{ConvergenceCheckpoint, MethodResult, MethodStudyResult};
use crate::study::report::csv_and_markdown::{csv_row, escape_markdown, markdown_code_block, markdown_table};
use crate::study::report::text::{count_text, duration_text, error_percent_text, square_root_percent_text};
use serde::Serialize;

/// Schema version of [`method_study_json`]. The version increases when a field is removed or
/// changes its meaning.
const SCHEMA: u32 = 1;

/// Returns the report of a study of methods as CSV, with one row per method and checkpoint.
///
/// Column `seconds` is processor time. Columns whose name ends in 2 are estimates of squares, which
/// noise can make negative. Column `squares` lists the relative squared errors of all seeds,
/// separated by semicolons.
#[must_use]
pub fn csv_report(result: &MethodStudyResult) -> String {
    let mut table = csv_row(&[
        "method",
        "algorithm",
        "passes",
        "seconds",
        "wall",
        "setup",
        "rays",
        "photons",
        "error2",
        "error2_low",
        "error2_high",
        "noise2",
        "bias2",
        "estimated2",
        "rmse",
        "flip",
        "squares",
        "command",
    ]);
    for method in &result.methods {
        for c in &method.checkpoints {
            let number = |v: f64| v.to_string();
            let [low, high] = mean_confidence_interval(&c.relative_squared_errors)
                .map_or_else(Default::default, |ends| ends.map(number));
            table += &csv_row(&[
                method.label.clone(),
                method.algorithm.name().to_owned(),
                c.passes.to_string(),
                number(c.cpu_seconds),
                number(c.wall_seconds),
                number(method.setup_seconds),
                number(c.rays),
                number(c.photon_paths),
                number(c.mean_relative_squared_error()),
                low,
                high,
                number(c.squared_noise),
                number(c.squared_bias),
                c.mean_square_of_estimated_error().map_or(String::new(), number),
                number(c.rmse),
                number(c.flip),
                c.relative_squared_errors.iter().map(f64::to_string).collect::<Vec<_>>().join(";"),
                method.render_command.clone(),
            ]);
        }
    }
    table
}

/// JSON report of a study of methods.
#[derive(Serialize)]
struct MethodStudyJson<'f> {
    schema: u32,
    program: &'f str,
    machine: &'f str,
    scene: &'f str,
    #[serde(rename = "command")]
    study_command: &'f str,
    width: u32,
    height: u32,
    seeds: u32,
    #[serde(rename = "budget")]
    cpu_seconds_per_seed: f64,
    #[serde(rename = "share")]
    thread_time_share: f64,
    interrupted: bool,
    warnings: Vec<String>,
    #[serde(rename = "truth")]
    reference: ReferenceJson<'f>,
    methods: Vec<MethodJson<'f>>,
    pareto: &'f [ParetoPoint],
    recommendation: &'f Option<MethodRecommendation>,
}

/// JSON of the origin and the relative error of the reference picture.
#[derive(Serialize)]
struct ReferenceJson<'f> {
    source: &'f str,
    error: Option<f64>,
}

/// JSON of one method: its settings, checkpoints, slopes, verdict and times to reach errors.
#[derive(Serialize)]
struct MethodJson<'f> {
    label: &'f str,
    algorithm: &'static str,
    #[serde(rename = "command")]
    render_command: &'f str,
    #[serde(rename = "setup")]
    setup_seconds: f64,
    alpha: f64,
    #[serde(rename = "radii")]
    gather_radii: Option<[f32; 2]>,
    checkpoints: &'f [ConvergenceCheckpoint],
    fit: &'f Option<ConvergenceFit>,
    #[serde(rename = "theory")]
    predicted_slopes: PredictedSlopesJson,
    verdict: String,
    #[serde(rename = "reaches")]
    times_to_target_errors: Vec<TimeToErrorJson>,
    #[serde(rename = "tenth")]
    time_to_tenth_error: TimeToError,
}

/// JSON of the slopes that theory predicts for a method's error, noise and bias.
#[derive(Serialize)]
struct PredictedSlopesJson {
    error: Option<SlopeRange>,
    noise: Option<SlopeRange>,
    bias: Option<SlopeRange>,
}

/// JSON of a target error, and of the time and work in which a method reaches it.
#[derive(Serialize)]
struct TimeToErrorJson {
    #[serde(rename = "error")]
    target_error: f64,
    #[serde(flatten)]
    time_to_error: TimeToError,
}

/// Returns the report of a study of methods as JSON: everything but pixels. Infinite values are
/// `null`.
///
/// # Errors
/// [`serde_json::Error`] if encoding fails, which is not known to happen.
pub fn method_study_json(result: &MethodStudyResult) -> Result<String, serde_json::Error> {
    let analysis = MethodStudyAnalysis::new(result);
    let methods = result.methods.iter().zip(&analysis.methods).map(|(method, judged)| {
        let law = |quantity| judged.predicted_convergence_slopes(method, quantity);
        let target = |(error, reach): (f64, TimeToError)| TimeToErrorJson { target_error: error, time_to_error: reach };
        MethodJson {
            label: &method.label,
            algorithm: method.algorithm.name(),
            render_command: &method.render_command,
            setup_seconds: method.setup_seconds,
            alpha: method.alpha,
            gather_radii: method.gather_radii,
            checkpoints: &method.checkpoints,
            fit: &judged.fit,
            predicted_slopes: PredictedSlopesJson {
                error: law(ErrorComponent::Error),
                noise: law(ErrorComponent::Noise),
                bias: law(ErrorComponent::Bias),
            },
            verdict: judged.verdict.to_string(),
            times_to_target_errors: TARGET_ERRORS.into_iter().zip(judged.times_to_target_errors).map(target).collect(),
            time_to_tenth_error: judged.time_to_tenth_error,
        }
    });
    let report = MethodStudyJson {
        schema: SCHEMA,
        program: &result.program,
        machine: &result.machine,
        scene: &result.scene_path,
        study_command: &result.study_command,
        width: result.reference.picture.width(),
        height: result.reference.picture.height(),
        seeds: result.seeds,
        cpu_seconds_per_seed: result.max_cpu_seconds_per_seed,
        thread_time_share: result.thread_time_share,
        interrupted: result.interrupted,
        warnings: study_warnings(result),
        reference: ReferenceJson { source: &result.reference.source, error: result.reference.error },
        methods: methods.collect(),
        pareto: &analysis.pareto,
        recommendation: &analysis.recommendation,
    };
    Ok(serde_json::to_string_pretty(&report)? + "\n")
}

/// Returns the report of a study of methods as Markdown: tables, verdicts and commands.
#[must_use]
pub fn markdown_report(result: &MethodStudyResult) -> String {
    let analysis = MethodStudyAnalysis::new(result);
    let own_error =
        result.reference.error.map_or(String::new(), |e| format!(", its own error about {}", error_percent_text(e)));
    let mut text = format!(
        "# Error over time: {}\n\n{}. {}. Seeds: {} of each method, up to {} of processor time each. Reference: {}{own_error}.\n\n{}",
        escape_markdown(&result.scene_path),
        escape_markdown(&result.program),
        escape_markdown(&result.machine),
        result.seeds,
        duration_text(result.max_cpu_seconds_per_seed),
        escape_markdown(&result.reference.source),
        markdown_code_block(&result.study_command),
    );
    for warning in study_warnings(result) {
        text += &format!("\n> {}\n", escape_markdown(&warning));
    }
    if let Some((words, command)) = analysis.recommendation_text(result) {
        text += &format!("\n## Recommendation\n\n{}\n\n{}", escape_markdown(&words), markdown_code_block(&command));
    }
    let all = || result.methods.iter().zip(&analysis.methods);
    let rows = all().map(|(method, judged)| {
        let [error, noise, bias, slope, theory] = judged.verdict_cells(method);
        vec![method.label.clone(), error, noise, bias, slope, theory, judged.verdict.to_string()]
    });
    let heads = ["method", "error at the end", "noise", "bias", "slope", "theory", "verdict"];
    text += &format!("\n## Verdicts\n\n{}", markdown_table(&heads, &rows.collect::<Vec<_>>()));
    let rows = all().map(|(method, judged)| {
        let reach = |reach: &TimeToError| {
            let (time, work) = time_to_error_text(reach, method.algorithm.traces_photons());
            if work.is_empty() { time } else { format!("{time} ({})", work.join(", ")) }
        };
        let reaches = judged.times_to_target_errors.iter().chain([&judged.time_to_tenth_error]).map(reach);
        [method.label.clone(), duration_text(method.setup_seconds)].into_iter().chain(reaches).collect()
    });
    let heads = ["method", "setup", "10 %", "5 %", "2 %", "1 %", "a tenth of the last error"];
    text += &format!("\n## Time to reach an error\n\n{}", markdown_table(&heads, &rows.collect::<Vec<_>>()));
    text += "\n## Checkpoints\n";
    for method in &result.methods {
        text += &format!(
            "\n### {}\n\n{}\n{}",
            escape_markdown(&method.label),
            checkpoints_markdown(method),
            markdown_code_block(&method.render_command)
        );
    }
    text
}

fn checkpoints_markdown(method: &MethodResult) -> String {
    let row = |c: &ConvergenceCheckpoint| {
        vec![
            c.passes.to_string(),
            duration_text(c.cpu_seconds),
            count_text(c.rays),
            count_text(c.photon_paths),
            square_root_percent_text(c.mean_relative_squared_error()),
            square_root_percent_text(c.squared_noise),
            square_root_percent_text(c.squared_bias),
        ]
    };
    let rows: Vec<Vec<String>> = method.checkpoints.iter().map(row).collect();
    markdown_table(&["passes", "processor time", "rays", "photons", "error", "noise", "bias"], &rows)
}
