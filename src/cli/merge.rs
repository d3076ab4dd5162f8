//! `caustica merge`: adds the passes of several film files.

use super::film::{FilmOfOtherRenderError, check_film_memory, read_film, write_film};
use super::outputs::{FileWithRole, OutputFailures, check_distinct_files};
use super::pictures::{PictureArguments, default_tone_curve, write_pictures};
use super::progress::{ProgressDisplay, print_message};
use super::value_parsers::parse_bytes;
use super::{CommandFailure, Exit, forecast_text};
use crate::image::{self, Image, ToneCurve};
use crate::integrate::Algorithm;
use crate::render::error_estimate::MIN_ERROR_ESTIMATE_PASSES;
use crate::render::{FilmFile, FilmHeader, MergeError, PassSet};
use clap::Args;
use std::path::{Path, PathBuf};

/// Extension of film files.
const FILM_EXTENSION: &str = "film";

/// Arguments of `merge`.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// Film files of parts of one render
    #[arg(required = true)]
    pub films: Vec<PathBuf>,

    /// File to write: .png, .exr or .film; may be given several times
    #[arg(short, long = "output", required = true, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    #[command(flatten)]
    pub pictures: PictureArguments,

    /// Memory limit of the program, such as 4G or 512M  [default: the free memory]
    #[arg(long, value_parser = parse_bytes, value_name = "SIZE")]
    pub memory: Option<u64>,

    /// Print only errors and warnings
    #[arg(short, long)]
    pub quiet: bool,
}

/// Error: a film cannot be added to the sum of the films that the command line names before it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot add the film `{}`: {source}", path.display())]
#[diagnostic(help("`caustica film FILE` lists the passes of a film"))]
struct FilmMergeError {
    path: PathBuf,
    source: MergeError,
}

pub(super) fn run(arguments: &MergeArguments) -> Result<Exit, CommandFailure> {
    let (films, pictures): (Vec<&PathBuf>, Vec<&PathBuf>) =
        arguments.output.iter().partition(|path| has_film_extension(path));
    for path in &pictures {
        image::check_writable(path).map_err(CommandFailure::output_error)?;
    }
    for path in &films {
        image::check_replaceable(path).map_err(CommandFailure::output_error)?;
    }
    let outputs: Vec<FileWithRole> = arguments.output.iter().map(|path| FileWithRole::new("-o", path)).collect();
    let inputs: Vec<FileWithRole> = arguments.films.iter().map(|path| FileWithRole::new("the film", path)).collect();
    check_distinct_files(&outputs, &inputs)?;
    check_film_memory(&arguments.films, arguments.films.len().min(2), arguments.memory)?;
    let progress = ProgressDisplay::new(arguments.quiet);
    let FilmFile { header, rendered } = read_and_merge_films(&arguments.films, &progress)?;

    // Write the outputs.
    let mut options =
        arguments.pictures.write_options(film_algorithm(&header).map_or(ToneCurve::Srgb, default_tone_curve));
    let missing = header.missing_passes(&rendered.pass_numbers);
    if !missing.is_empty() {
        print_message(&format!("warning: passes {missing} are missing"));
        options.metadata.push(("Missing passes".to_owned(), missing.to_string()));
    }
    let mut failures = OutputFailures::default();
    let (width, height) = rendered.film.size();
    let picture =
        Image::from_pixels(width, height, rendered.film.mean_picture()).map_err(CommandFailure::output_error)?;
    write_pictures(pictures.into_iter(), &picture, &options, &progress, &mut failures);
    for path in films {
        if failures.ok_or_collect_error(write_film(path, &header, &rendered)).is_some() {
            progress.print_line(&format!("wrote {}", path.display()));
        }
    }
    let passes = rendered.film.passes();
    progress.print_line(&format!("{passes} {}", if passes == 1 { "pass" } else { "passes" }));
    if let Some(estimator) = rendered.estimator.as_ref().filter(|_| passes >= MIN_ERROR_ESTIMATE_PASSES) {
        let estimate = estimator.estimate(&rendered.film);
        progress.print_line(&format!("estimated error {}", forecast_text::error_text(&estimate)));
    }
    failures.into_result(Exit::Success)
}

/// Returns the algorithm that rendered the film with the given header; `None` if this version of
/// the program does not have it.
///
/// The settings of a header begin with `--integrator` and the algorithm's name.
fn film_algorithm(header: &FilmHeader) -> Option<Algorithm> {
    let name = header.settings.get(1)?;
    Algorithm::ALL.into_iter().find(|algorithm| algorithm.name() == name)
}

/// True if `path` has the extension of film files.
pub(super) fn has_film_extension(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(FILM_EXTENSION))
}

/// Returns one film with the passes of all films at `paths`. Leaves out a film that holds the same
/// passes as an earlier film. At most two films are in memory at a time.
fn read_and_merge_films(paths: &[PathBuf], progress: &ProgressDisplay) -> Result<FilmFile, CommandFailure> {
    let mut total: Option<FilmFile> = None;
    let mut added: Vec<PassSet> = Vec::new();
    for path in paths {
        let film = read_film(path)?;
        if let Some(total) = &total {
            check_same_render(total, &film, path)?;
        }
        if added.contains(&film.rendered.pass_numbers) {
            progress.print_line(&format!("{} has the passes of an earlier film, and counts once", path.display()));
            continue;
        }
        added.push(film.rendered.pass_numbers.clone());
        total = Some(match total {
            None => film,
            Some(total) => sum_of_films(total, &film, path)?,
        });
    }
    let missing_argument = || CommandFailure::usage_error(miette::miette!("no film file is given"));
    total.ok_or_else(missing_argument)
}

/// Returns an error if `film`, which was read from `path`, is of another render than `total`.
fn check_same_render(total: &FilmFile, film: &FilmFile, path: &Path) -> Result<(), CommandFailure> {
    let differences = total.header.differences(&film.header);
    if differences.is_empty() {
        return Ok(());
    }
    Err(CommandFailure::new(Exit::Input, FilmOfOtherRenderError { path: path.to_owned(), differences }))
}

/// Returns `total` with the passes of `film` added. `film` was read from `path`.
fn sum_of_films(mut total: FilmFile, film: &FilmFile, path: &Path) -> Result<FilmFile, CommandFailure> {
    let merged = total.rendered.merge(&film.rendered);
    let error = |source| CommandFailure::new(Exit::Input, FilmMergeError { path: path.to_owned(), source });
    merged.map_err(error)?;
    total.header.planned_passes = total.header.planned_passes.max(film.header.planned_passes);
    Ok(total)
}
