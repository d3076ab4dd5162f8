//! `caustica study --methods`: the error of each method against processor time.

use super::effects::load_checked;
use super::knobs;
use super::output::{Outputs, ReportWriter, check_reference, outputs_of};
use super::table::{root_percent, table};
use super::variants::NamedVariant;
use crate::cli::args::TruthFiles;
use crate::cli::interrupt::{INTERRUPTED, listen};
use crate::cli::memory::check_photons;
use crate::cli::outputs::{NamedFile, OutputFailures, check_distinct};
use crate::cli::plan::{self, count_with_noun};
use crate::cli::progress::{Progress, print_message};
use crate::cli::scene::in_pool;
use crate::cli::settings::{flags, settings};
use crate::cli::{Exit, Failure, StudyArguments};
use crate::image::{WriteOptions, write};
use crate::plan::Plan;
use crate::scene::Scene;
use crate::stats::bytes;
use crate::study::methods::{
    MethodStudy, MethodStudyResult, MethodVariant, References, StudiedScene, StudyLimits, StudyProgress,
    applicable_methods, shell_quoted,
};
use crate::study::report::methods as report;
use miette::IntoDiagnostic;

/// Default processor time of a reference, in multiples of `--budget`.
const TRUTH_BUDGETS: f64 = 4.0;

/// Least share of the threads' time at which measurements count as undisturbed by other programs.
const UNDISTURBED: f64 = 0.9;

/// Report formats by extension.
const REPORTS: [(&str, ReportWriter<MethodStudyResult>); 4] = [
    ("html", |_, found| report::methods_html_page(found).into_diagnostic()),
    ("csv", |_, found| Ok(report::csv(found))),
    ("json", |_, found| report::json(found).into_diagnostic()),
    ("md", |_, found| Ok(report::markdown(found))),
];

/// A flag for rendered references, given together with reference files.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{flag} applies to rendered references, but --truth names files")]
#[diagnostic(help("leave out one of the two flags"))]
struct UnusedTruthFlag {
    flag: &'static str,
}

/// Pictures that do not fit into memory.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error(
    "{seeds} seeds of {variants} methods with {} × {} pixels take {} of memory, and {} are free",
    size.0, size.1, bytes(*needed), bytes(*free)
)]
#[diagnostic(help("choose a smaller --size, fewer --seeds or fewer methods, or allow more --memory"))]
struct TooManyPictures {
    seeds: u32,
    variants: usize,
    size: (u32, u32),
    needed: u64,
    free: u64,
}

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, Failure> {
    // Everything that can fail without rendering is checked before rendering.
    let outputs = Outputs::check(arguments, &REPORTS)?;
    let kind = &arguments.kind;
    if kind.truth != TruthFiles::Auto {
        let unused = [("--save-truth", kind.save_truth.is_some()), ("--truth-time", kind.truth_time.is_some())];
        if let Some((flag, _)) = unused.into_iter().find(|(_, given)| *given) {
            return Err(Failure::usage(UnusedTruthFlag { flag }));
        }
    }
    if let Some((a, b)) = &kind.save_truth {
        [a, b].into_iter().try_for_each(|path| check_reference(path))?;
    }
    let truth = match &kind.truth {
        TruthFiles::Auto => Vec::new(),
        TruthFiles::One(a) => vec![NamedFile::new("the reference", a)],
        TruthFiles::Two(a, b) => [a, b].map(|path| NamedFile::new("the reference", path)).to_vec(),
    };
    check_distinct(&outputs_of(arguments), &truth)?;
    let read = |text: &String| NamedVariant::read(text, &arguments.method).map_err(Failure::usage);
    let named = kind.variants.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    listen("the study");
    let progress = Progress::new(arguments.quiet);
    in_pool(&arguments.scene, || run_in_pool(arguments, named, &outputs, &progress))
}

fn run_in_pool(
    arguments: &StudyArguments,
    named: Vec<NamedVariant>,
    outputs: &Outputs<'_, MethodStudyResult>,
    progress: &Progress,
) -> Result<Exit, Failure> {
    let scene = load_checked(arguments, progress)?;
    let (kind, size) = (&arguments.kind, scene.camera().size());
    let variants = variants(arguments, named, &scene);
    let (needed, seeds) = (MethodStudy::picture_bytes(size, variants.len(), kind.seeds), kind.seeds);
    let memory = arguments.scene.memory();
    if let Some(free) = memory.free().filter(|free| needed > *free) {
        return Err(Failure::usage(TooManyPictures { seeds, variants: variants.len(), size, needed, free }));
    }
    let given = match &kind.truth {
        TruthFiles::Auto => None,
        TruthFiles::One(a) => Some(References::read(a, None, size)),
        TruthFiles::Two(a, b) => Some(References::read(a, Some(b), size)),
    };
    let given = given.transpose().into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    let algorithms = variants.iter().map(|v| v.algorithm.simulates());
    let plans = algorithms.map(|simulates| Plan::new(&scene, simulates, arguments.simulate));
    for (variant, plan) in variants.iter().zip(plans) {
        plan::omission_warnings(&plan).for_each(|line| print_message(&format!("{line} ({})", variant.label)));
    }
    let runs = count_with_noun(variants.len(), "method", "methods");
    let study = MethodStudy::prepare(&scene, variants, kind.seeds).into_diagnostic().map_err(Failure::usage)?;
    check_photons(study.largest_pass_memory(), needed, memory.free()).map_err(Failure::usage)?;
    let Some(references) = given.map_or_else(|| render_truth(arguments, &scene, progress), |given| Ok(Some(given)))?
    else {
        print_message("interrupted before anything was measured");
        return Ok(Exit::Interrupted);
    };
    progress.say(&format!(
        "{runs} with {} seeds, {:.1} s of processor time a seed",
        kind.seeds,
        kind.budget.as_secs_f64()
    ));
    let limits = StudyLimits { budget: kind.budget.as_secs_f64(), passes: arguments.passes };
    progress.pass(1, arguments.passes);
    let found = study.run(&study_subject(arguments), limits, &references, &INTERRUPTED, progress, |step| match step {
        StudyProgress::Round(made) => progress.pass(made + 1, arguments.passes),
        StudyProgress::Checkpoint(label, at) => progress.say(&format!(
            "{label}: {} after {:.2} s, error {}",
            count_with_noun(at.passes as usize, "pass", "passes"),
            at.seconds,
            root_percent(at.mean_squared_error())
        )),
    });
    progress.finish();
    let found = found.into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    if found.share < UNDISTURBED {
        print_message(&format!(
            "warning: threads had only {:.0} % of their time: other programs ran, or the passes are too small for the threads",
            100.0 * found.share
        ));
    }
    let text =
        if arguments.json { report::json(&found).map(|json| json + "\n").into_diagnostic() } else { Ok(table(&found)) };
    let exit = if found.interrupted { Exit::Interrupted } else { Exit::Success };
    outputs.write(arguments, &found, text, progress, exit)
}

/// The variants to compare, in the order of the flags.
fn variants(arguments: &StudyArguments, named: Vec<NamedVariant>, scene: &Scene) -> Vec<MethodVariant> {
    let (kind, shared, overrides) = (&arguments.kind, &arguments.method, arguments.simulate);
    let by_default = kind.methods.is_empty() && kind.variants.is_empty() && kind.knobs.is_none();
    let methods = if by_default { applicable_methods(scene, overrides) } else { kind.methods.clone() };
    let around =
        kind.knobs.map(|algorithm| knobs::variants_around(algorithm, shared, overrides, scene)).unwrap_or_default();
    let plain = methods.into_iter().map(|algorithm| NamedVariant::plain(algorithm, shared));
    plain.chain(named).chain(around).map(|named| named.variant(overrides)).collect()
}

/// Renders the references, and writes them to the files of `--save-truth`. `None` if interrupted.
fn render_truth(arguments: &StudyArguments, scene: &Scene, progress: &Progress) -> Result<Option<References>, Failure> {
    let kind = &arguments.kind;
    let default = TRUTH_BUDGETS * kind.budget.as_secs_f64();
    let seconds = kind.truth_time.map_or(default, |time| time.as_secs_f64());
    let like = settings(&arguments.method, arguments.simulate).camera_paths;
    progress.say(&format!("two references with {seconds:.1} s of processor time each"));
    progress.pass(1, None);
    let rendered = References::render(scene, &like, seconds, &INTERRUPTED, progress, |made, part| {
        if progress.has_lines() && made.is_power_of_two() {
            let made = count_with_noun(made as usize, "pass", "passes");
            progress.say(&format!("references: {made} of each, {:.0} % of the time", 100.0 * part.min(1.0)));
        }
        progress.pass(made + 1, None);
    });
    let rendered = rendered.into_diagnostic().map_err(|e| Failure::new(Exit::Input, e))?;
    if let (Some(references), Some((a, b))) = (&rendered, &kind.save_truth) {
        let mut failures = OutputFailures::default();
        for (path, picture) in [a, b].into_iter().zip(references.pair()) {
            if failures.take_ok(write(path, picture, &WriteOptions::default())).is_some() {
                progress.say(&format!("wrote {}", path.display()));
            }
        }
        failures.finish(Exit::Success)?;
    }
    Ok(rendered)
}

/// The scene of the study, and the command that repeats the study.
fn study_subject(arguments: &StudyArguments) -> StudiedScene {
    let (kind, scene) = (&arguments.kind, arguments.scene.scene.display().to_string());
    // A name with a leading dash would be parsed as a flag.
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
    // The first flag is `--integrator`, which a study of methods does not take.
    words.extend(flags(&arguments.method, "--simulate", arguments.simulate).into_iter().skip(2));
    StudiedScene { command: shell_quoted(&words), scene, size: arguments.scene.size }
}
