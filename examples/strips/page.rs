//! Text of the page, and of the caption of the strip in README.md.

use crate::measure::{Stage, TARGETS};
use crate::scenes::Entry;
use crate::{LIMIT, OTHER_LIMIT};
use caustica::study::text::{count_text, error_percent_text, three_digit_text};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Assumed power of one busy core \[W], from which energy is computed.
const CORE_WATTS: f64 = 15.0;

const INTRODUCTION: &str = include_str!("introduction.md");

/// Measurements of one scene.
#[derive(Debug, Serialize, Deserialize)]
pub struct SceneMeasurements {
    /// Processor time of the default method before its first default pass, loading included \[s].
    pub setup_seconds: f64,
    /// Stages of the default method.
    pub default: Vec<Stage>,
    /// Trials of the other methods.
    pub trials: Vec<Trial>,
    /// Method that is compared with the default method.
    pub other_algorithm: String,
    /// Stages of this method.
    pub other: Vec<Stage>,
}

/// Short render of a method other than the default one.
#[derive(Debug, Serialize, Deserialize)]
pub struct Trial {
    pub algorithm: String,
    /// True if the estimated error reached the target of trials.
    pub is_reached: bool,
    /// Processor time of the trial \[s].
    pub cpu_seconds: f64,
    /// Relative error with the last picture of the default method as the true picture.
    pub difference: f64,
}

/// Returns the page.
pub fn page(scenes: &[(&Entry, SceneMeasurements)]) -> String {
    let mut page = INTRODUCTION
        .replace("OTHER_LIMIT", &OTHER_LIMIT.to_string())
        .replace("LIMIT", &LIMIT.to_string())
        .replace("WATTS", &CORE_WATTS.to_string())
        .replace("SUMMARY", summary(scenes).trim_end());
    for (entry, measured) in scenes {
        let scene = entry.scene();
        _ = write!(
            page,
            "\n## {}\n\n![{}](images/strips/{}.png)\n\n{}\nScene: [{scene}](../{scene}).\n\n\
             | method | target | estimated error | CPU s | energy | passes | rays | photon paths | difference |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            entry.title, entry.title, entry.name, entry.text,
        );
        for (algorithm, stages) in methods(measured) {
            for (i, stage) in stages.iter().enumerate() {
                // Targets after the first one that is out of reach would repeat its row.
                if stage.is_reached || i == 0 || stages[i - 1].is_reached {
                    page += &row(algorithm, stage);
                }
            }
        }
        page += "\n";
        for (algorithm, stages) in methods(measured) {
            if let Some(stage) = stages.iter().find(|stage| !stage.flags.is_empty()) {
                _ = writeln!(page, "Small passes of `{algorithm}`: `{}`.", stage.flags);
            }
        }
        for trial in measured.trials.iter().filter(|trial| trial.algorithm != measured.other_algorithm) {
            let (algorithm, difference) = (&trial.algorithm, error_percent_text(trial.difference));
            let seconds = three_digit_text(trial.cpu_seconds);
            let end = if trial.is_reached { "an estimated error of 5 %" } else { "its time limit" };
            _ = writeln!(
                page,
                "A trial of `{algorithm}` ended at {end} after {seconds} s. Its difference was {difference}."
            );
        }
    }
    page
}

/// Returns name and stages of the default method, and of the other method.
fn methods(measured: &SceneMeasurements) -> [(&str, &[Stage]); 2] {
    [("hybrid", &measured.default), (&measured.other_algorithm, &measured.other)]
}

/// Returns a table of the times of all scenes.
fn summary(scenes: &[(&Entry, SceneMeasurements)]) -> String {
    let targets = || TARGETS.iter().map(|target| target_text(*target));
    let head: String = targets().chain(targets()).map(|target| format!(" {target} |")).collect();
    let mut table = format!("| scene | pilots |{head} by |\n|{}\n", " --- |".repeat(2 + 2 * TARGETS.len() + 1));
    for (entry, measured) in scenes {
        let times = |stages: &[Stage], limit| -> String {
            stages.iter().map(|stage| format!(" {} |", time_text(stage, limit))).collect()
        };
        _ = writeln!(
            table,
            "| {} | {} |{}{} `{}` |",
            entry.name,
            three_digit_text(measured.setup_seconds),
            times(&measured.default, LIMIT),
            times(&measured.other, OTHER_LIMIT),
            measured.other_algorithm,
        );
    }
    table
}

/// Returns the caption of a strip, such as `10 % after 4.20 s, …`.
pub fn caption(stages: &[Stage]) -> String {
    let part = |stage: &Stage| format!("{} after {} s", target_text(stage.target), time_text(stage, LIMIT));
    stages.iter().map(part).collect::<Vec<_>>().join(", ")
}

/// Returns the processor time of a stage in seconds, or a text that it is more than `limit`.
fn time_text(stage: &Stage, limit: f64) -> String {
    if stage.is_reached { three_digit_text(stage.cpu_seconds) } else { format!("> {limit}") }
}

fn target_text(target: f64) -> String {
    format!("{:.0} %", 100.0 * target)
}

fn row(algorithm: &str, stage: &Stage) -> String {
    let not_reached = if stage.is_reached { "" } else { "not reached: " };
    let small = if stage.flags.is_empty() { "" } else { " small" };
    format!(
        "| `{algorithm}` | {} | {not_reached}{} ({} to {}) | {} | {:.0} | {}{small} | {:.0} | {} | {} |\n",
        target_text(stage.target),
        error_percent_text(stage.error),
        three_digit_text(100.0 * stage.low),
        error_percent_text(stage.high),
        three_digit_text(stage.cpu_seconds),
        CORE_WATTS * stage.cpu_seconds,
        stage.passes,
        stage.camera_rays_per_pixel,
        count_text(stage.photon_paths as f64),
        stage.difference.map_or("–".to_owned(), error_percent_text),
    )
}
