//! `caustica study --effects`.

use super::output::{Outputs, Writer};
use crate::cli::interrupt::{INTERRUPTED, listen};
use crate::cli::memory::{check_photons, check_pictures};
use crate::cli::plan::{self, EffectReport};
use crate::cli::progress::{Progress, tell, tell_of_rejected};
use crate::cli::scene::{in_pool, load};
use crate::cli::settings::settings;
use crate::cli::{Exit, Failure, StudyArguments};
use crate::plan::{Decision, Effect};
use crate::stats::Counters;
use crate::study::report::effects::{csv, markdown};
use crate::study::text::{amount, figure, milliseconds, percent, signed};
use crate::study::{About, Clock, Cost, EffectStudy, Findings, Gain, Spent, page};
use miette::IntoDiagnostic;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

/// Passes of each picture, where the user does not say.
const PASSES: u32 = 4;

/// What reports are written as.
const REPORTS: [(&str, Writer<Findings>); 4] = [
    ("html", |arguments, found| page(&about(arguments), found).into_diagnostic()),
    ("csv", |_, found| Ok(csv(found))),
    ("json", json),
    ("md", |arguments, found| Ok(markdown(&about(arguments), found))),
];

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, Failure> {
    // Whatever can fail without rendering fails before it.
    let outputs = Outputs::check(&arguments.output, &REPORTS)?;
    listen("the study");
    let progress = Progress::new(arguments.quiet);
    in_pool(&arguments.scene, || run_in_pool(arguments, &outputs, &progress))
}

fn run_in_pool(
    arguments: &StudyArguments,
    outputs: &Outputs<'_, Findings>,
    progress: &Progress,
) -> Result<Exit, Failure> {
    let usage = |e| Failure::new(Exit::Usage, e);
    let start = Instant::now();
    let scene = load(&arguments.scene, progress)?;
    let algorithm = arguments.method.integrator;
    // No more than one picture without each effect, besides the whole one.
    let memory = arguments.scene.memory();
    let pictures = check_pictures(Effect::ALL.len() + 1, scene.camera().size(), memory.free()).map_err(usage)?;
    let study = EffectStudy::prepare(&scene, algorithm, &settings(&arguments.method, arguments.wish));
    check_photons(study.expected(), pictures, memory.free()).map_err(usage)?;
    progress.say(&plan::line(study.plan()));
    plan::complaints(study.plan()).for_each(|line| tell(&line));
    let (pictures, passes) = (study.pictures(), arguments.passes.unwrap_or(PASSES));
    progress.say(&format!("{pictures} pictures of {passes} passes each"));
    progress.pass(1, Some(passes));
    let found = study.run(passes, &INTERRUPTED, progress, |made| {
        if matches!(progress, Progress::Lines) {
            progress.say(&format!("pass {made}/{passes} of each after {:.1} s", start.elapsed().as_secs_f64()));
        }
        progress.pass(made + 1, Some(passes));
    });
    progress.finish();
    let found = found.into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    tell_of_rejected(&found.whole.counters);
    conclude(arguments, outputs, progress, &found).map_err(|e| Failure::new(Exit::Output, e))?;
    Ok(if found.interrupted { Exit::Interrupted } else { Exit::Success })
}

/// Writes the reports and prints the figures.
fn conclude(
    arguments: &StudyArguments,
    outputs: &Outputs<'_, Findings>,
    progress: &Progress,
    found: &Findings,
) -> miette::Result<()> {
    outputs.write(arguments, found, progress)?;
    let text =
        if arguments.json { json(arguments, found)? + "\n" } else { table(arguments.method.integrator.name(), found) };
    std::io::stdout().write_all(text.as_bytes()).into_diagnostic()
}

fn about(arguments: &StudyArguments) -> About {
    let scene = arguments.scene.scene.display().to_string();
    let (integrator, seed) = (arguments.method.integrator.name(), arguments.method.seed);
    About { scene, integrator, seed, exposure: arguments.exposure }
}

/// All figures.
fn json(arguments: &StudyArguments, found: &Findings) -> miette::Result<String> {
    let scene = arguments.scene.scene.display().to_string();
    let report = Report::new(scene, arguments.method.integrator.name(), arguments.method.seed, found);
    serde_json::to_string_pretty(&report).into_diagnostic()
}

fn table(integrator: &str, found: &Findings) -> String {
    let clock = match found.clock {
        Clock::Processor => "processor",
        Clock::Wall => "wall",
    };
    let whole = &found.whole;
    let passes = whole.passes.len() as f64;
    let mut text = format!(
        "{integrator}: {:.1} ms of {clock} time, {} rays and {} gathered photons a pass; mean radiance {}\n",
        1e3 * whole.seconds() / passes,
        amount(whole.counters.rays() as f64 / passes),
        amount(whole.counters.gathered_photons as f64 / passes),
        figure(found.mean),
    );
    if !found.effects.is_empty() {
        let _ = writeln!(
            text,
            "  {:<16} {:>18} {:>7} {:>9} {:>10} {:>9} {:>9} {:>9}",
            "effect", "costs a pass, ms", "time", "rays", "gathered", "changes", "adds", "takes"
        );
    }
    for finding in &found.effects {
        let Cost { seconds, seconds_error, ratio, rays, gathered_photons, .. } = finding.cost;
        let Gain { relative_rmse, adds, takes, rmse } = finding.gain;
        let error = seconds_error.map_or(String::new(), |e| format!(" ± {:.1}", 1e3 * e));
        let part = |x: f64| if found.mean > 0.0 { percent(x / found.mean) } else { figure(x) };
        let _ = writeln!(
            text,
            "  {:<16} {:>18} {:>7} {:>9} {:>10} {:>9} {:>9} {:>9}",
            finding.decision.effect,
            milliseconds(seconds) + &error,
            format!("× {ratio:.2}"),
            signed(rays),
            signed(gathered_photons),
            relative_rmse.map_or(figure(rmse), percent),
            part(adds),
            part(takes),
        );
    }
    for decision in found.plan.decisions.iter().filter(|d| !d.on) {
        let wished = if decision.is_forced() { ", as wished, though " } else { ": " };
        let _ = writeln!(text, "  {:<16} off{wished}{}", decision.effect, decision.reason);
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
    /// These are `None` where the effect is off.
    without: Option<Made<'f>>,
    cost: Option<Cost>,
    gain: Option<Gain>,
}

impl<'f> From<&'f Spent> for Made<'f> {
    fn from(spent: &'f Spent) -> Self {
        Self { setup: spent.setup, seconds: spent.seconds(), counters: &spent.counters }
    }
}

impl<'f> Report<'f> {
    fn new(scene: String, integrator: &'static str, seed: u64, found: &'f Findings) -> Self {
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
            schema: 1,
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
            effects: plan::effects(&found.plan).into_iter().zip(&found.plan.decisions).map(row).collect(),
        }
    }
}
