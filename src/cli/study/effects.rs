//! `caustica study --effects`: the cost and the contribution of each effect.

use super::output::{Outputs, ReportWriter, outputs_of};
use crate::cli::interrupt::{INTERRUPTED, listen};
use crate::cli::memory::{check_photons, check_pictures};
use crate::cli::outputs::{NamedFile, check_distinct};
use crate::cli::plan::{self, EffectReport};
use crate::cli::progress::{InputFiles, Progress, print_message, warn_of_rejected};
use crate::cli::scene::{in_pool, load};
use crate::cli::settings::settings;
use crate::cli::{Exit, Failure, StudyArguments};
use crate::plan::{Decision, Effect};
use crate::scene::Scene;
use crate::stats::Counters;
use crate::study::report::effects::{csv, markdown};
use crate::study::text::{count_text, percent_text, signed_count_text, signed_milliseconds_text, three_digit_text};
use crate::study::{
    Clock, EffectContribution, EffectCost, EffectStudy, EffectStudyResult, PictureCost, ReportContext,
    effects_html_page,
};
use miette::IntoDiagnostic;
use serde::Serialize;
use std::fmt::Write as _;
use std::time::Instant;

/// Default number of passes of each picture.
const PASSES: u32 = 4;

/// Report formats by extension.
const REPORTS: [(&str, ReportWriter<EffectStudyResult>); 4] = [
    ("html", |arguments, found| effects_html_page(&about(arguments), found).into_diagnostic()),
    ("csv", |_, found| Ok(csv(found))),
    ("json", json),
    ("md", |arguments, found| Ok(markdown(&about(arguments), found))),
];

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, Failure> {
    // Everything that can fail without rendering is checked before rendering.
    let outputs = Outputs::check(arguments, &REPORTS)?;
    listen("the study");
    let progress = Progress::new(arguments.quiet);
    in_pool(&arguments.scene, || run_in_pool(arguments, &outputs, &progress))
}

fn run_in_pool(
    arguments: &StudyArguments,
    outputs: &Outputs<'_, EffectStudyResult>,
    progress: &Progress,
) -> Result<Exit, Failure> {
    let start = Instant::now();
    let scene = load_checked(arguments, progress)?;
    let algorithm = arguments.method.integrator;
    // At most one picture without each effect, and the full picture.
    let memory = arguments.scene.memory();
    let pictures =
        check_pictures(Effect::ALL.len() + 1, scene.camera().size(), memory.free()).map_err(Failure::usage)?;
    let study = EffectStudy::prepare(&scene, algorithm, &settings(&arguments.method, arguments.simulate));
    check_photons(study.largest_pass_memory(), pictures, memory.free()).map_err(Failure::usage)?;
    progress.say(&plan::effects_line(study.plan()));
    plan::omission_warnings(study.plan()).for_each(|line| print_message(&line));
    let (pictures, passes) = (study.picture_count(), arguments.passes.unwrap_or(PASSES));
    progress.say(&format!("{pictures} pictures of {passes} passes each"));
    progress.pass(1, Some(passes));
    let found = study.run(passes, &INTERRUPTED, progress, |made| {
        if progress.has_lines() {
            progress.say(&format!("pass {made}/{passes} of each after {:.1} s", start.elapsed().as_secs_f64()));
        }
        progress.pass(made + 1, Some(passes));
    });
    progress.finish();
    let found = found.into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    warn_of_rejected(&found.whole.counters);
    let text = if arguments.json {
        json(arguments, &found).map(|json| json + "\n")
    } else {
        Ok(table(arguments.method.integrator.name(), &found))
    };
    let exit = if found.interrupted { Exit::Interrupted } else { Exit::Success };
    outputs.write(arguments, &found, text, progress, exit)
}

/// Loads the scene, and refuses outputs that are one of its inputs.
pub(super) fn load_checked(arguments: &StudyArguments, progress: &Progress) -> Result<Scene, Failure> {
    let inputs = InputFiles::new(progress);
    let scene = load(&arguments.scene, &inputs)?;
    progress.finish();
    let inputs: Vec<NamedFile> = inputs.into_files().iter().map(|path| NamedFile::new("the input", path)).collect();
    check_distinct(&outputs_of(arguments), &inputs)?;
    Ok(scene)
}

/// Facts about the study for the heads of its reports.
fn about(arguments: &StudyArguments) -> ReportContext {
    let scene = arguments.scene.scene.display().to_string();
    let (integrator, seed) = (arguments.method.integrator.name(), arguments.method.seed);
    ReportContext { scene, integrator, seed, exposure: arguments.exposure }
}

/// All figures as JSON.
fn json(arguments: &StudyArguments, found: &EffectStudyResult) -> miette::Result<String> {
    let scene = arguments.scene.scene.display().to_string();
    let report = Report::new(scene, arguments.method.integrator.name(), arguments.method.seed, found);
    serde_json::to_string_pretty(&report).into_diagnostic()
}

/// All figures as a table.
fn table(integrator: &str, found: &EffectStudyResult) -> String {
    let clock = match found.clock {
        Clock::Processor => "processor",
        Clock::Wall => "wall",
    };
    let whole = &found.whole;
    let passes = whole.passes.len() as f64;
    let mut text = format!(
        "{integrator}: {:.1} ms of {clock} time, {} rays and {} gathered photons per pass; mean radiance {}\n",
        1e3 * whole.seconds() / passes,
        count_text(whole.counters.rays() as f64 / passes),
        count_text(whole.counters.gathered_photons as f64 / passes),
        three_digit_text(found.mean),
    );
    if !found.effects.is_empty() {
        let _ = writeln!(
            text,
            "  {:<16} {:>18} {:>7} {:>9} {:>10} {:>9} {:>9} {:>9}",
            "effect", "ms per pass", "time", "rays", "gathered", "changes", "adds", "takes"
        );
    }
    for finding in &found.effects {
        let EffectCost { seconds, seconds_error, ratio, rays, gathered_photons, .. } = finding.cost;
        let EffectContribution { relative_rmse, adds, takes, rmse } = finding.gain;
        let error = seconds_error.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        let share = |x: f64| if found.mean > 0.0 { percent_text(x / found.mean) } else { three_digit_text(x) };
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
            share(takes),
        );
    }
    for decision in found.plan.decisions.iter().filter(|d| !d.on) {
        let forced = if decision.is_forced() { ", forced, although " } else { ": " };
        let _ = writeln!(text, "  {:<16} off{forced}{}", decision.effect, decision.reason);
    }
    text
}

#[derive(Debug, Serialize)]
struct Report<'f> {
    schema: u32,
    version: &'static str,
    scene: String,
    integrator: &'static str,
    width: u32,
    height: u32,
    seed: u64,
    passes: usize,
    interrupted: bool,
    clock: Clock,
    mean: f64,
    whole: Made<'f>,
    effects: Vec<Row<'f>>,
}

#[derive(Debug, Serialize)]
struct Made<'f> {
    setup: f64,
    seconds: f64,
    counters: &'f Counters,
}

#[derive(Debug, Serialize)]
struct Row<'f> {
    #[serde(flatten)]
    effect: EffectReport,
    /// Work of the picture without the effect; `None` if the effect is off.
    without: Option<Made<'f>>,
    /// `None` if the effect is not simulated.
    cost: Option<EffectCost>,
    /// `None` if the effect is not simulated.
    gain: Option<EffectContribution>,
}

impl<'f> From<&'f PictureCost> for Made<'f> {
    fn from(spent: &'f PictureCost) -> Self {
        Self { setup: spent.setup, seconds: spent.seconds(), counters: &spent.counters }
    }
}

impl<'f> Report<'f> {
    fn new(scene: String, integrator: &'static str, seed: u64, found: &'f EffectStudyResult) -> Self {
        let row = |(effect, decision): (EffectReport, &Decision)| {
            let finding = found.effects.iter().find(|f| f.decision.effect == decision.effect);
            Row {
                effect,
                without: finding.map(|f| (&f.without).into()),
                cost: finding.map(|f| f.cost),
                gain: finding.map(|f| f.gain),
            }
        };
        Self {
            schema: 2,
            version: env!("CARGO_PKG_VERSION"),
            scene,
            integrator,
            width: found.picture.width(),
            height: found.picture.height(),
            seed,
            passes: found.whole.passes.len(),
            interrupted: found.interrupted,
            clock: found.clock,
            mean: found.mean,
            whole: (&found.whole).into(),
            effects: plan::effect_reports(&found.plan).into_iter().zip(&found.plan.decisions).map(row).collect(),
        }
    }
}
