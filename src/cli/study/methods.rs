//! `caustica study`: how the error of each method falls with time.

use super::knobs;
use super::output::{Outputs, Writer, check_reference};
use super::table::{root, table};
use super::variants::Named;
use crate::cli::args::TruthFiles;
use crate::cli::interrupt::{INTERRUPTED, listen};
use crate::cli::memory::check_photons;
use crate::cli::plan::{self, counted};
use crate::cli::progress::{Progress, tell};
use crate::cli::scene::{in_pool, load};
use crate::cli::settings::{flags, settings};
use crate::cli::{Exit, Failure, StudyArguments};
use crate::image::{WriteOptions, write};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::stats::bytes;
use crate::study::methods::{
    Limits, MethodStudy, MethodsFound, References, Step, Subject, Variant, in_shell, methods_for,
};
use crate::study::report::methods as report;
use miette::IntoDiagnostic;
use std::io::Write as _;

/// Processor time of a reference in budgets, where the user does not say.
const TRUTH_BUDGETS: f64 = 4.0;

/// Below this part of the threads' time, others disturbed.
const UNDISTURBED: f64 = 0.9;

/// What reports are written as.
const REPORTS: [(&str, Writer<MethodsFound>); 4] = [
    ("html", |_, found| report::html(found).into_diagnostic()),
    ("csv", |_, found| Ok(report::csv(found))),
    ("json", |_, found| report::json(found).into_diagnostic()),
    ("md", |_, found| Ok(report::markdown(found))),
];

/// Flags that do not go together.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{flag} is for references that are rendered, but --truth names files")]
#[diagnostic(help("leave out one of the two"))]
struct NotRendered {
    flag: &'static str,
}

/// More pictures than memory holds.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error(
    "{seeds} seeds of {variants} methods with {} × {} pixels take {} of memory, and {} are free",
    size.0, size.1, bytes(*needed), bytes(*free)
)]
#[diagnostic(help("choose a smaller --size, fewer --seeds or fewer methods, or let it have more memory (--memory)"))]
struct TooMany {
    seeds: u32,
    variants: usize,
    size: (u32, u32),
    needed: u64,
    free: u64,
}

fn usage(error: impl Into<miette::Report>) -> Failure {
    Failure::new(Exit::Usage, error)
}

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, Failure> {
    // Whatever can fail without rendering fails before it.
    let outputs = Outputs::check(&arguments.output, &REPORTS)?;
    let kind = &arguments.kind;
    if kind.truth != TruthFiles::Auto {
        let idle = [("--save-truth", kind.save_truth.is_some()), ("--truth-time", kind.truth_time.is_some())];
        if let Some((flag, _)) = idle.into_iter().find(|(_, given)| *given) {
            return Err(usage(NotRendered { flag }));
        }
    }
    if let Some((a, b)) = &kind.save_truth {
        [a, b].into_iter().try_for_each(|path| check_reference(path))?;
    }
    let read = |text: &String| Named::read(text, &arguments.method).map_err(usage);
    let named = kind.variants.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    listen("the study");
    let progress = Progress::new(arguments.quiet);
    in_pool(&arguments.scene, || run_in_pool(arguments, named, &outputs, &progress))
}

fn run_in_pool(
    arguments: &StudyArguments,
    named: Vec<Named>,
    outputs: &Outputs<'_, MethodsFound>,
    progress: &Progress,
) -> Result<Exit, Failure> {
    let scene = load(&arguments.scene, progress)?;
    let (kind, size) = (&arguments.kind, scene.camera().size());
    let variants = variants(arguments, named, &scene);
    let (needed, seeds) = (MethodStudy::bytes(size, variants.len(), kind.seeds), kind.seeds);
    let memory = arguments.scene.memory();
    if let Some(free) = memory.free().filter(|free| needed > *free) {
        return Err(usage(TooMany { seeds, variants: variants.len(), size, needed, free }));
    }
    let given = match &kind.truth {
        TruthFiles::Auto => None,
        TruthFiles::One(a) => Some(References::read(a, None, size)),
        TruthFiles::Two(a, b) => Some(References::read(a, Some(b), size)),
    };
    let given = given.transpose().into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    let algorithms = variants.iter().map(|v| v.algorithm.simulates());
    let wishes = algorithms.map(|simulates| Plan::new(&scene, simulates, arguments.wish));
    for (variant, plan) in variants.iter().zip(wishes) {
        plan::complaints(&plan).for_each(|line| tell(&format!("{line} ({})", variant.label)));
    }
    let runs = counted(variants.len(), "method", "methods");
    let study = MethodStudy::prepare(&scene, variants, kind.seeds).into_diagnostic().map_err(usage)?;
    check_photons(study.expected(), needed, memory.free()).map_err(usage)?;
    let Some(references) = given.map_or_else(|| render_truth(arguments, &scene, progress), |given| Ok(Some(given)))?
    else {
        tell("interrupted before anything was measured");
        return Ok(Exit::Interrupted);
    };
    progress.say(&format!(
        "{runs} with {} seeds, {:.1} s of processor time a seed",
        kind.seeds,
        kind.budget.as_secs_f64()
    ));
    let limits = Limits { budget: kind.budget.as_secs_f64(), passes: arguments.passes };
    progress.pass(1, arguments.passes);
    let found = study.run(&subject(arguments), limits, &references, &INTERRUPTED, progress, |step| match step {
        Step::Round(made) => progress.pass(made + 1, arguments.passes),
        Step::Checkpoint(label, at) => progress.say(&format!(
            "{label}: {} after {:.2} s, error {}",
            counted(at.passes as usize, "pass", "passes"),
            at.seconds,
            root(at.square())
        )),
    });
    progress.finish();
    let found = found.into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    if found.share < UNDISTURBED {
        tell(&format!(
            "warning: the machine was busy, or the passes too small for its threads: they had {:.0} % of their time",
            100.0 * found.share
        ));
    }
    conclude(arguments, outputs, progress, &found).map_err(|e| Failure::new(Exit::Output, e))?;
    Ok(if found.interrupted { Exit::Interrupted } else { Exit::Success })
}

/// What is compared, in the order of the command line's flags.
fn variants(arguments: &StudyArguments, named: Vec<Named>, scene: &Scene) -> Vec<Variant> {
    let (kind, shared, wishes) = (&arguments.kind, &arguments.method, arguments.wish);
    let unsaid = kind.methods.is_empty() && kind.variants.is_empty() && kind.knobs.is_none();
    let methods = if unsaid { methods_for(scene, wishes) } else { kind.methods.clone() };
    let around = kind.knobs.map(|algorithm| knobs::around(algorithm, shared, wishes, scene)).unwrap_or_default();
    let plain = methods.into_iter().map(|algorithm| Named::plain(algorithm, shared));
    plain.chain(named).chain(around).map(|named| named.variant(wishes)).collect()
}

/// Renders the references and keeps them where the user asks for that; `None` where that was interrupted.
fn render_truth(arguments: &StudyArguments, scene: &Scene, progress: &Progress) -> Result<Option<References>, Failure> {
    let kind = &arguments.kind;
    let unsaid = TRUTH_BUDGETS * kind.budget.as_secs_f64();
    let seconds = kind.truth_time.map_or(unsaid, |time| time.as_secs_f64());
    let like = settings(&arguments.method, arguments.wish).eye;
    progress.say(&format!("two references of {seconds:.1} s of processor time each"));
    progress.pass(1, None);
    let rendered = References::render(scene, &like, seconds, &INTERRUPTED, progress, |made, part| {
        if matches!(progress, Progress::Lines) && made.is_power_of_two() {
            let made = counted(made as usize, "pass", "passes");
            progress.say(&format!("references: {made} of each, {:.0} % of the time", 100.0 * part.min(1.0)));
        }
        progress.pass(made + 1, None);
    });
    let rendered = rendered.into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    if let (Some(references), Some((a, b))) = (&rendered, &kind.save_truth) {
        for (path, picture) in [a, b].into_iter().zip(references.pair()) {
            write(path, picture, &WriteOptions::default())
                .into_diagnostic()
                .map_err(|e| Failure::new(Exit::Output, e))?;
            progress.say(&format!("wrote {}", path.display()));
        }
    }
    Ok(rendered)
}

/// What is studied, and the command that repeats it.
fn subject(arguments: &StudyArguments) -> Subject {
    let (kind, scene) = (&arguments.kind, arguments.scene.scene.display().to_string());
    // What begins with a dash would be read as a flag.
    let named = if scene.starts_with('-') { format!("./{scene}") } else { scene.clone() };
    let mut words = ["caustica", "study", &named].map(str::to_owned).to_vec();
    let mut add = |flag: &str, value: Option<String>| {
        words.extend(value.into_iter().flat_map(|value| [flag.to_owned(), value]));
    };
    add("--size", arguments.scene.size.map(|(width, height)| format!("{width}x{height}")));
    add("--threads", arguments.scene.threads.map(|n| n.to_string()));
    let names = kind.methods.iter().map(|algorithm| algorithm.name()).collect::<Vec<_>>().join(",");
    add("--methods", (!names.is_empty()).then_some(names));
    kind.variants.iter().for_each(|text| add("--variant", Some(text.clone())));
    add("--knobs", kind.knobs.map(|algorithm| algorithm.name().to_owned()));
    add("--budget", Some(format!("{}s", kind.budget.as_secs_f64())));
    add("--passes", arguments.passes.map(|n| n.to_string()));
    add("--seeds", Some(kind.seeds.to_string()));
    add(
        "--truth",
        match &kind.truth {
            TruthFiles::Auto => None,
            TruthFiles::One(a) => Some(a.display().to_string()),
            TruthFiles::Two(a, b) => Some(format!("{},{}", a.display(), b.display())),
        },
    );
    add("--truth-time", kind.truth_time.map(|time| format!("{}s", time.as_secs_f64())));
    add("--seed", Some(arguments.method.seed.to_string()));
    // Methods are named in place of one integrator.
    words.extend(flags(&arguments.method, "--wish", arguments.wish).into_iter().skip(2));
    Subject { command: in_shell(&words), scene, size: arguments.scene.size }
}

/// Writes the reports and prints the figures.
fn conclude(
    arguments: &StudyArguments,
    outputs: &Outputs<'_, MethodsFound>,
    progress: &Progress,
    found: &MethodsFound,
) -> miette::Result<()> {
    outputs.write(arguments, found, progress)?;
    let text = if arguments.json { report::json(found).into_diagnostic()? + "\n" } else { table(found) };
    std::io::stdout().write_all(text.as_bytes()).into_diagnostic()
}
