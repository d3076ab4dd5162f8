//! `caustica study --methods`: measures the error of methods as a function of processor time.

use super::args::ReferenceSource;
use super::effects::load_study_scene;
use super::knobs;
use super::output::{ReportFormatter, StudyOutputs, check_reference_path, study_output_files};
use super::table::{checkpoints_table, square_root_percent_text};
use super::variants::VariantArguments;
use crate::cli::interrupt::{INTERRUPTED, listen_for_signals};
use crate::cli::outputs::{FileWithRole, OutputFailures, check_distinct_files};
use crate::cli::plan;
use crate::cli::progress::{ProgressDisplay, print_message};
use crate::cli::scene::with_thread_pool;
use crate::cli::settings::{method_flags, settings_from_arguments};
use crate::cli::value_parsers::count_with_noun;
use crate::cli::{CommandFailure, Exit, StudyArguments};
use crate::image::{WriteOptions, write};
use crate::plan::Plan;
use crate::render::check_photon_memory;
use crate::scene::Scene;
use crate::stats::format_bytes;
use crate::study::methods::{
    MIN_THREAD_TIME_SHARE, MethodStudy, MethodStudyEvent, MethodStudyResult, MethodVariant, ReferencePictures,
    StudiedScene, StudyLimits, applicable_methods, shell_command_line,
};
use crate::study::report::methods as report;
use miette::IntoDiagnostic;

/// Default processor time for each of the two references, as a multiple of `--budget`.
const REFERENCE_BUDGET_FACTOR: f64 = 4.0;

/// File extensions of reports, each with the function that makes the report as text.
const REPORT_FORMATTERS: [(&str, ReportFormatter<MethodStudyResult>); 4] = [
    ("html", |_, result| report::methods_html_page(result).into_diagnostic()),
    ("csv", |_, result| Ok(report::csv_report(result))),
    ("json", |_, result| report::method_study_json(result).into_diagnostic()),
    ("md", |_, result| Ok(report::markdown_report(result))),
];

/// Usage error: `--truth` names reference files, but another flag applies only to references that
/// the study renders.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{flag} applies to rendered references, but --truth names files")]
#[diagnostic(help("leave out one of the two flags"))]
struct UnusedTruthFlagError {
    flag: &'static str,
}

/// Usage error: the pictures of the study need more memory (`needed`) than there is (`free`)
/// \[bytes].
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error(
    "{seeds} seeds of {variants} methods with {} × {} pixels take {} of memory, and {} are free",
    size.0, size.1, format_bytes(*needed), format_bytes(*free)
)]
#[diagnostic(help("choose a smaller --size, fewer --seeds or fewer methods, or allow more --memory"))]
struct TooManyPicturesError {
    seeds: u32,
    variants: usize,
    size: (u32, u32),
    needed: u64,
    free: u64,
}

pub(super) fn run(arguments: &StudyArguments) -> Result<Exit, CommandFailure> {
    // Everything that can fail without rendering is checked before rendering.
    let outputs = StudyOutputs::from_arguments(arguments, &REPORT_FORMATTERS)?;
    let kind = &arguments.kind;
    if kind.truth != ReferenceSource::Auto {
        let unused = [("--save-truth", kind.save_truth.is_some()), ("--truth-time", kind.truth_time.is_some())];
        if let Some((flag, _)) = unused.into_iter().find(|(_, given)| *given) {
            return Err(CommandFailure::usage_error(UnusedTruthFlagError { flag }));
        }
    }
    if let Some((a, b)) = &kind.save_truth {
        [a, b].into_iter().try_for_each(|path| check_reference_path(path))?;
    }
    let truth = match &kind.truth {
        ReferenceSource::Auto => Vec::new(),
        ReferenceSource::OneFile(a) => vec![FileWithRole::new("the reference", a)],
        ReferenceSource::TwoFiles(a, b) => [a, b].map(|path| FileWithRole::new("the reference", path)).to_vec(),
    };
    check_distinct_files(&study_output_files(arguments), &truth)?;
    let read = |text: &String| VariantArguments::parse(text, &arguments.method).map_err(CommandFailure::usage_error);
    let named = kind.variants.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    listen_for_signals("the study so far is written after this pass");
    let progress = ProgressDisplay::new(arguments.quiet);
    with_thread_pool(&arguments.scene, || run_method_study(arguments, named, &outputs, &progress))
}

fn run_method_study(
    arguments: &StudyArguments,
    named: Vec<VariantArguments>,
    outputs: &StudyOutputs<'_, MethodStudyResult>,
    progress: &ProgressDisplay,
) -> Result<Exit, CommandFailure> {
    let scene = load_study_scene(arguments, progress)?;
    let (kind, size) = (&arguments.kind, scene.camera().size());
    let variants = study_variants(arguments, named, &scene);
    let (needed, seeds) = (MethodStudy::study_picture_bytes(size, variants.len(), kind.seeds), kind.seeds);
    let memory = arguments.scene.memory_limit();
    if let Some(free) = memory.available_bytes().filter(|free| needed > *free) {
        return Err(CommandFailure::usage_error(TooManyPicturesError {
            seeds,
            variants: variants.len(),
            size,
            needed,
            free,
        }));
    }
    let given = match &kind.truth {
        ReferenceSource::Auto => None,
        ReferenceSource::OneFile(a) => Some(ReferencePictures::read(a, None, size)),
        ReferenceSource::TwoFiles(a, b) => Some(ReferencePictures::read(a, Some(b), size)),
    };
    let given = given.transpose().into_diagnostic().map_err(|e| CommandFailure::new(Exit::Input, e))?;
    let algorithms = variants.iter().map(|v| v.algorithm.supported_effects());
    let plans = algorithms.map(|simulates| Plan::new(&scene, simulates, arguments.simulate));
    for (variant, plan) in variants.iter().zip(plans) {
        plan::omitted_effect_warnings(&plan).for_each(|line| print_message(&format!("{line} ({})", variant.label)));
    }
    let runs = count_with_noun(variants.len(), "method", "methods");
    let study =
        MethodStudy::prepare(&scene, variants, kind.seeds).into_diagnostic().map_err(CommandFailure::usage_error)?;
    check_photon_memory(study.max_expected_photon_counts(), needed, memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    let Some(references) =
        given.map_or_else(|| render_references(arguments, &scene, progress), |given| Ok(Some(given)))?
    else {
        print_message("interrupted before anything was measured");
        return Ok(Exit::Interrupted);
    };
    progress.print_line(&format!(
        "{runs} with {} seeds, {:.1} s of processor time a seed",
        kind.seeds,
        kind.budget.as_secs_f64()
    ));
    let limits = StudyLimits { cpu_seconds_per_seed: kind.budget.as_secs_f64(), passes: arguments.passes };
    progress.set_pass_number(1, arguments.passes);
    let result = study.run(&studied_scene(arguments), limits, &references, &INTERRUPTED, progress, |step| match step {
        MethodStudyEvent::PassFinished(made) => progress.set_pass_number(made + 1, arguments.passes),
        MethodStudyEvent::Checkpoint(label, at) => progress.print_line(&format!(
            "{label}: {} after {:.2} s, error {}",
            count_with_noun(at.passes as usize, "pass", "passes"),
            at.cpu_seconds,
            square_root_percent_text(at.mean_relative_squared_error())
        )),
    });
    progress.remove_progress_bar();
    let result = result.into_diagnostic().map_err(|e| CommandFailure::new(Exit::Input, e))?;
    if result.thread_time_share < MIN_THREAD_TIME_SHARE {
        print_message(&format!(
            "warning: threads had only {:.0} % of their time: other programs ran, or the passes are too small for the threads",
            100.0 * result.thread_time_share
        ));
    }
    let text = if arguments.json {
        report::method_study_json(&result).map(|json| json + "\n").into_diagnostic()
    } else {
        Ok(checkpoints_table(&result))
    };
    let exit = if result.interrupted { Exit::Interrupted } else { Exit::Success };
    outputs.write_reports(arguments, &result, text, progress, exit)
}

/// Returns the method variants to measure: those of `--methods`, then of `--variant`, then of
/// `--knobs`. Without these flags, returns the methods that give different pictures of the scene.
fn study_variants(arguments: &StudyArguments, named: Vec<VariantArguments>, scene: &Scene) -> Vec<MethodVariant> {
    let (kind, shared, overrides) = (&arguments.kind, &arguments.method, arguments.simulate);
    let by_default = kind.methods.is_empty() && kind.variants.is_empty() && kind.knobs.is_none();
    let methods = if by_default { applicable_methods(scene, overrides) } else { kind.methods.clone() };
    let knob_variants =
        kind.knobs.map(|algorithm| knobs::knob_study_variants(algorithm, shared, overrides, scene)).unwrap_or_default();
    let plain = methods.into_iter().map(|algorithm| VariantArguments::from_algorithm(algorithm, shared));
    plain.chain(named).chain(knob_variants).map(|named| named.into_method_variant(overrides)).collect()
}

/// Renders two reference pictures, and writes them to the files of `--save-truth` if given. Returns
/// `None` if a signal interrupts the render.
fn render_references(
    arguments: &StudyArguments,
    scene: &Scene,
    progress: &ProgressDisplay,
) -> Result<Option<ReferencePictures>, CommandFailure> {
    let kind = &arguments.kind;
    let default = REFERENCE_BUDGET_FACTOR * kind.budget.as_secs_f64();
    let seconds = kind.truth_time.map_or(default, |time| time.as_secs_f64());
    let camera_paths = settings_from_arguments(&arguments.method, arguments.simulate).camera_paths;
    progress.print_line(&format!("two references with {seconds:.1} s of processor time each"));
    progress.set_pass_number(1, None);
    let rendered = ReferencePictures::render(scene, &camera_paths, seconds, &INTERRUPTED, progress, |made, part| {
        if progress.uses_plain_lines() && made.is_power_of_two() {
            let made = count_with_noun(made as usize, "pass", "passes");
            progress.print_line(&format!("references: {made} of each, {:.0} % of the time", 100.0 * part.min(1.0)));
        }
        progress.set_pass_number(made + 1, None);
    });
    let rendered = rendered.into_diagnostic().map_err(|e| CommandFailure::new(Exit::Input, e))?;
    if let (Some(references), Some((a, b))) = (&rendered, &kind.save_truth) {
        let mut failures = OutputFailures::default();
        for (path, picture) in [a, b].into_iter().zip(references.both_reference_pictures()) {
            if failures.ok_or_collect_error(write(path, picture, &WriteOptions::default())).is_some() {
                progress.print_line(&format!("wrote {}", path.display()));
            }
        }
        failures.into_result(Exit::Success)?;
    }
    Ok(rendered)
}

/// Returns the path and picture size of the study's scene, and the shell command that repeats the
/// study.
fn studied_scene(arguments: &StudyArguments) -> StudiedScene {
    let (kind, scene) = (&arguments.kind, arguments.scene.scene.display().to_string());
    // A name with a leading dash would be parsed as a flag.
    let named = if scene.starts_with('-') { format!("./{scene}") } else { scene.clone() };
    let mut words = ["caustica", "study", &named].map(str::to_owned).to_vec();
    let import_flags = arguments.scene.import.reproducing_flags();
    words.extend(import_flags.iter().cloned());
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
            ReferenceSource::Auto => None,
            ReferenceSource::OneFile(a) => Some(a.display().to_string()),
            ReferenceSource::TwoFiles(a, b) => Some(format!("{},{}", a.display(), b.display())),
        },
    );
    add("--truth-time", kind.truth_time.map(|time| format!("{}s", time.as_secs_f64())));
    add("--seed", Some(arguments.method.seed.to_string()));
    // Skip the first flag with its value, `--integrator`: a study of methods does not take it.
    words.extend(method_flags(&arguments.method, "--simulate", arguments.simulate).into_iter().skip(2));
    let (study_command, size) = (shell_command_line(&words), arguments.scene.size);
    StudiedScene { study_command, scene_path: scene, size, import_flags }
}
