//! CSV, JSON and Markdown reports of a study of methods.

use super::analysis::{MethodStudyAnalysis, TARGET_ERRORS, slope_interval_text, slope_range_text, time_to_error_text};
use super::tables::square_root_percent_text;
use super::warnings::study_warnings;
use crate::study::methods::fit::{
    ConvergenceFit, ErrorComponent, MethodRecommendation, ParetoPoint, SlopeRange, TimeToError,
    mean_confidence_interval,
};
use crate::study::methods::{ConvergenceCheckpoint, MethodResult, MethodStudyResult};
use crate::study::report::plain::{csv_row, escape_markdown, markdown_code_block, markdown_table};
use crate::study::report::text::{count_text, duration_text, error_percent_text};
use serde::Serialize;

/// Schema version of [`method_study_json`]. It increases when a field is removed or changes its
/// meaning.
const SCHEMA: u32 = 1;

/// Returns the report of a study of methods as CSV, with one row per method and checkpoint.
///
/// Column `seconds` is processor time. Columns whose name ends in 2 are estimates of squares, which
/// noise can make negative. Column `squares` lists the relative squared errors of all seeds,
/// separated by semicolons.
#[must_use]
pub fn csv_report(found: &MethodStudyResult) -> String {
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
    for method in &found.methods {
        for c in &method.checkpoints {
            let number = |v: f64| v.to_string();
            let [low, high] =
                mean_confidence_interval(&c.squared_errors).map_or_else(Default::default, |ends| ends.map(number));
            table += &csv_row(&[
                method.label.clone(),
                method.algorithm.name().to_owned(),
                c.passes.to_string(),
                number(c.seconds),
                number(c.wall),
                number(method.setup),
                number(c.rays),
                number(c.photon_paths),
                number(c.mean_squared_error()),
                low,
                high,
                number(c.noise2),
                number(c.bias2),
                c.mean_square_of_estimated_error().map_or(String::new(), number),
                number(c.rmse),
                number(c.flip),
                c.squared_errors.iter().map(f64::to_string).collect::<Vec<_>>().join(";"),
                method.command.clone(),
            ]);
        }
    }
    table
}

#[derive(Serialize)]
struct MethodStudyJson<'f> {
    schema: u32,
    program: &'f str,
    machine: &'f str,
    scene: &'f str,
    command: &'f str,
    width: u32,
    height: u32,
    seeds: u32,
    budget: f64,
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

#[derive(Serialize)]
struct ReferenceJson<'f> {
    source: &'f str,
    error: Option<f64>,
}

#[derive(Serialize)]
struct MethodJson<'f> {
    label: &'f str,
    algorithm: &'static str,
    command: &'f str,
    setup: f64,
    alpha: f64,
    radii: Option<[f32; 2]>,
    checkpoints: &'f [ConvergenceCheckpoint],
    fit: &'f Option<ConvergenceFit>,
    theory: PredictedSlopesJson,
    verdict: String,
    reaches: Vec<TimeToErrorJson>,
    tenth: TimeToError,
}

/// JSON of the slopes that theory predicts for a method's error, noise and bias.
#[derive(Serialize)]
struct PredictedSlopesJson {
    error: Option<SlopeRange>,
    noise: Option<SlopeRange>,
    bias: Option<SlopeRange>,
}

#[derive(Serialize)]
struct TimeToErrorJson {
    error: f64,
    #[serde(flatten)]
    reach: TimeToError,
}

/// Returns the report of a study of methods as JSON: everything but pixels. Infinite values are
/// `null`.
///
/// # Errors
/// [`serde_json::Error`] if encoding fails, which is not known to happen.
pub fn method_study_json(found: &MethodStudyResult) -> Result<String, serde_json::Error> {
    let analysis = MethodStudyAnalysis::new(found);
    let methods = found.methods.iter().zip(&analysis.methods).map(|(method, judged)| {
        let law = |quantity| judged.predicted_convergence_slopes(method, quantity);
        let target = |(error, reach): (f64, TimeToError)| TimeToErrorJson { error, reach };
        MethodJson {
            label: &method.label,
            algorithm: method.algorithm.name(),
            command: &method.command,
            setup: method.setup,
            alpha: method.alpha,
            radii: method.radii,
            checkpoints: &method.checkpoints,
            fit: &judged.fit,
            theory: PredictedSlopesJson {
                error: law(ErrorComponent::Error),
                noise: law(ErrorComponent::Noise),
                bias: law(ErrorComponent::Bias),
            },
            verdict: judged.verdict.to_string(),
            reaches: TARGET_ERRORS.into_iter().zip(judged.reaches).map(target).collect(),
            tenth: judged.tenth,
        }
    });
    let report = MethodStudyJson {
        schema: SCHEMA,
        program: &found.program,
        machine: &found.machine,
        scene: &found.scene,
        command: &found.command,
        width: found.reference.picture.width(),
        height: found.reference.picture.height(),
        seeds: found.seeds,
        budget: found.budget,
        thread_time_share: found.thread_time_share,
        interrupted: found.interrupted,
        warnings: study_warnings(found),
        reference: ReferenceJson { source: &found.reference.source, error: found.reference.error },
        methods: methods.collect(),
        pareto: &analysis.pareto,
        recommendation: &analysis.recommendation,
    };
    Ok(serde_json::to_string_pretty(&report)? + "\n")
}

/// Report of a study of methods as Markdown: tables, verdicts and commands.
#[must_use]
pub fn markdown_report(found: &MethodStudyResult) -> String {
    let analysis = MethodStudyAnalysis::new(found);
    let own_error =
        found.reference.error.map_or(String::new(), |e| format!(", its own error about {}", error_percent_text(e)));
    let mut text = format!(
        "# Error over time: {}\n\n{}. {}. Seeds: {} of each method, up to {} of processor time each. Reference: {}{own_error}.\n\n{}",
        escape_markdown(&found.scene),
        escape_markdown(&found.program),
        escape_markdown(&found.machine),
        found.seeds,
        duration_text(found.budget),
        escape_markdown(&found.reference.source),
        markdown_code_block(&found.command),
    );
    for warning in study_warnings(found) {
        text += &format!("\n> {}\n", escape_markdown(&warning));
    }
    if let Some((words, command)) = analysis.recommendation_text(found) {
        text += &format!("\n## Recommendation\n\n{}\n\n{}", escape_markdown(&words), markdown_code_block(&command));
    }
    let all = || found.methods.iter().zip(&analysis.methods);
    let rows = all().map(|(method, judged)| {
        let of = |square: fn(&ConvergenceCheckpoint) -> f64| {
            method.checkpoints.last().map_or("–".to_owned(), |c| square_root_percent_text(square(c)))
        };
        let fit = judged.fit.as_ref();
        vec![
            method.label.clone(),
            of(ConvergenceCheckpoint::mean_squared_error),
            of(|c| c.noise2),
            of(|c| c.bias2),
            slope_interval_text(fit.and_then(|f| f.error)),
            fit.map_or("–".to_owned(), |_| {
                slope_range_text(judged.predicted_convergence_slopes(method, ErrorComponent::Error))
            }),
            judged.verdict.to_string(),
        ]
    });
    let heads = ["method", "error at the end", "noise", "bias", "slope", "theory", "verdict"];
    text += &format!("\n## Verdicts\n\n{}", markdown_table(&heads, &rows.collect::<Vec<_>>()));
    let rows = all().map(|(method, judged)| {
        let reach = |reach: &TimeToError| {
            let (time, work) = time_to_error_text(reach, method.algorithm.traces_photons());
            if work.is_empty() { time } else { format!("{time} ({})", work.join(", ")) }
        };
        let reaches = judged.reaches.iter().chain([&judged.tenth]).map(reach);
        [method.label.clone(), duration_text(method.setup)].into_iter().chain(reaches).collect()
    });
    let heads = ["method", "setup", "10 %", "5 %", "2 %", "1 %", "a tenth of the last error"];
    text += &format!("\n## Time to reach an error\n\n{}", markdown_table(&heads, &rows.collect::<Vec<_>>()));
    text += "\n## Checkpoints\n";
    for method in &found.methods {
        text += &format!(
            "\n### {}\n\n{}\n{}",
            escape_markdown(&method.label),
            checkpoints_markdown(method),
            markdown_code_block(&method.command)
        );
    }
    text
}

fn checkpoints_markdown(method: &MethodResult) -> String {
    let row = |c: &ConvergenceCheckpoint| {
        vec![
            c.passes.to_string(),
            duration_text(c.seconds),
            count_text(c.rays),
            count_text(c.photon_paths),
            square_root_percent_text(c.mean_squared_error()),
            square_root_percent_text(c.noise2),
            square_root_percent_text(c.bias2),
        ]
    };
    let rows: Vec<Vec<String>> = method.checkpoints.iter().map(row).collect();
    markdown_table(&["passes", "processor time", "rays", "photons", "error", "noise", "bias"], &rows)
}
