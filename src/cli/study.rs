//! `caustica study`.

use super::interrupt::{INTERRUPTED, listen};
use super::memory::{self, check_photons, check_pictures};
use super::plan::{self, EffectReport};
use super::progress::{Progress, tell};
use super::scene::{in_pool, load};
use super::settings::settings;
use super::{Exit, Failure, StudyArguments};
use crate::image::{check_place, replace_file};
use crate::integrate::Algorithm;
use crate::plan::{Decision, Effect};
use crate::stats::Counters;
use crate::study::text::{amount, figure, milliseconds, percent, signed};
use crate::study::{About, Clock, Cost, EffectStudy, Findings, Gain, Spent, page};
use miette::IntoDiagnostic;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A page whose name says something else.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("`{}` does not name a page", path.display())]
#[diagnostic(help("give it the extension .html"))]
struct NotHtml {
    path: PathBuf,
}

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, Failure> {
    // Whatever can fail without rendering fails before it.
    if let Some(path) = &arguments.output {
        check_page(path)?;
    }
    listen("the study");
    let progress = Progress::new(arguments.quiet);
    in_pool(&arguments.scene, || run_in_pool(arguments, &progress))
}

fn check_page(path: &Path) -> Result<(), Failure> {
    let named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm"));
    if !named {
        return Err(Failure::new(Exit::Output, NotHtml { path: path.to_owned() }));
    }
    check_place(path).into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))
}

fn run_in_pool(arguments: &StudyArguments, progress: &Progress) -> Result<Exit, Failure> {
    let usage = |e| Failure::new(Exit::Usage, e);
    let start = Instant::now();
    let scene = load(&arguments.scene, progress)?;
    let algorithm = Algorithm::from(arguments.method.integrator);
    // No more than one picture without each effect, besides the whole one.
    check_pictures(Effect::ALL.len() + 1, scene.camera().size(), memory::free()).map_err(usage)?;
    let study = EffectStudy::prepare(&scene, algorithm, &settings(&arguments.method, arguments.wish));
    check_photons(study.expected(), memory::free()).map_err(usage)?;
    progress.say(&plan::line(study.plan()));
    plan::complaints(study.plan()).for_each(|line| tell(&line));
    let (pictures, passes) = (study.pictures(), arguments.passes);
    progress.say(&format!("{pictures} pictures of {passes} passes each"));
    progress.pass(1, Some(passes), None);
    let found = study.run(passes, &INTERRUPTED, progress, |made| {
        if matches!(progress, Progress::Lines) {
            progress.say(&format!("pass {made}/{passes} of each after {:.1} s", start.elapsed().as_secs_f64()));
        }
        progress.pass(made + 1, Some(passes), None);
    });
    progress.finish();
    let found = found.into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    let rejected: u64 = found.whole.counters.rejected_samples;
    if rejected > 0 {
        tell(&format!("warning: {rejected} samples were not finite and were left out"));
    }
    conclude(arguments, progress, &found).map_err(|e| Failure::new(Exit::Output, e))?;
    Ok(if found.interrupted { Exit::Interrupted } else { Exit::Success })
}

/// Writes the page and prints the figures.
fn conclude(arguments: &StudyArguments, progress: &Progress, found: &Findings) -> miette::Result<()> {
    let scene = arguments.scene.scene.display().to_string();
    let integrator = Algorithm::from(arguments.method.integrator).name();
    let seed = arguments.method.seed;
    if let Some(path) = &arguments.output {
        let about = About { scene: scene.clone(), integrator, seed, exposure: arguments.exposure };
        replace_file(path, page(&about, found).into_diagnostic()?.as_bytes()).into_diagnostic()?;
        progress.say(&format!("wrote {}", path.display()));
    }
    let text = if arguments.json {
        let report = Report::new(scene, integrator, seed, found);
        serde_json::to_string_pretty(&report).into_diagnostic()? + "\n"
    } else {
        table(integrator, found)
    };
    std::io::stdout().write_all(text.as_bytes()).into_diagnostic()
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
