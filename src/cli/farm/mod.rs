//! `caustica farm`: renders one picture on many machines, as jobs of a batch system such as Slurm.
//!
//! Each job renders a shard, which is a part of the passes. A last job merges the films of all
//! shards.

mod args;
mod division;
mod script;
mod slurm;
mod slurm_render;
mod waves;
mod work_folder;

pub use args::{FarmArguments, FarmEngine, RefusedArguments, SlurmArguments};

use super::film::make_film_header;
use super::input_files::{InputFile, InputFileCollector};
use super::interrupt::listen_for_signals;
use super::merge::has_film_extension;
use super::outputs::{FileWithRole, check_distinct_files};
use super::progress::ProgressDisplay;
use super::render::{check_raycast_flags, rendered_picture_size};
use super::scene::{load_scene_and_file, with_thread_pool};
use super::{CommandFailure, Exit};
use crate::image::{check_replaceable, check_writable};
use crate::render::FilmHeader;
use division::{ShardDivision, job_arrays};
use script::{JobScripts, shell_command_line};
use slurm_render::{SlurmRender, merge_arguments, shard_arguments};
use std::io::Write as _;
use std::path::PathBuf;
use work_folder::{MERGE_SCRIPT_NAME, MERGED_FILM_NAME, SHARD_SCRIPT_NAME, WorkFolder};

/// Error: there are more shards than passes.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{shards} shards are too many for {passes} passes: some would have none")]
#[diagnostic(help("choose at most {passes} --shards"))]
struct EmptyShardsError {
    shards: u32,
    passes: u32,
}

pub(super) fn run(arguments: &FarmArguments) -> Result<Exit, CommandFailure> {
    match &arguments.engine {
        FarmEngine::Slurm(arguments) => run_slurm(arguments),
    }
}

/// Renders by Slurm; with `--dry-run`, prints the scripts.
fn run_slurm(arguments: &SlurmArguments) -> Result<Exit, CommandFailure> {
    check_raycast_flags(&arguments.film_header_settings(), arguments.target_error)?;
    let division = first_division(arguments)?;
    for path in &arguments.output {
        if has_film_extension(path) { check_replaceable(path) } else { check_writable(path) }
            .map_err(CommandFailure::output_error)?;
    }
    let folder = WorkFolder::new(&work_folder_path(arguments)).map_err(CommandFailure::output_error)?;
    let progress = ProgressDisplay::new(arguments.quiet);
    let header = with_thread_pool(&arguments.scene, || film_header_from_scene(arguments, &folder, &progress))?;
    let scripts = JobScripts::new(arguments, &folder, &header, division).map_err(CommandFailure::usage_error)?;
    if arguments.dry_run {
        return print_scripts(&folder, &scripts, division);
    }
    listen_for_signals("the jobs go on, and the same command follows them again");
    SlurmRender::new(arguments, &folder, header, &progress).run(division)
}

/// Divides the passes of the first wave of jobs into shards.
///
/// With `--target-error`, the number of passes is rounded up to a multiple of the number of shards.
/// All shards then have equal sizes, so that later waves can add shards.
fn first_division(arguments: &SlurmArguments) -> Result<ShardDivision, CommandFailure> {
    let SlurmArguments { shards, passes, .. } = *arguments;
    if shards > passes {
        return Err(CommandFailure::usage_error(EmptyShardsError { shards, passes }));
    }
    let equal = passes.div_ceil(shards).checked_mul(shards).filter(|_| arguments.target_error.is_some());
    Ok(ShardDivision { shards, passes: equal.unwrap_or(passes) })
}

/// Returns the folder of `--work-dir`; by default, the path of the first output with `.farm` added.
fn work_folder_path(arguments: &SlurmArguments) -> PathBuf {
    let beside_output = || {
        let mut name = arguments.output.first().map(|path| path.as_os_str().to_owned()).unwrap_or_default();
        name.push(".farm");
        PathBuf::from(name)
    };
    arguments.work_dir.clone().unwrap_or_else(beside_output)
}

/// Loads the scene, and returns the header of the films of its shards. So errors of the scene are
/// found before any job is submitted.
///
/// Returns a failure if an output would replace an input.
fn film_header_from_scene(
    arguments: &SlurmArguments,
    folder: &WorkFolder,
    progress: &ProgressDisplay,
) -> Result<FilmHeader, CommandFailure> {
    let scene_file = InputFile::new(&arguments.scene.scene);
    let inputs = InputFileCollector::new(progress);
    let (_, scene) = load_scene_and_file(&arguments.scene, &inputs)?;
    progress.remove_progress_bar();
    let input_files = inputs.into_input_files();
    let mut outputs: Vec<FileWithRole> = arguments.output.iter().map(|path| FileWithRole::new("-o", path)).collect();
    outputs.push(FileWithRole::new("the film of --work-dir", &folder.file_path(MERGED_FILM_NAME)));
    let mut inputs = vec![FileWithRole::new("the scene file", &arguments.scene.scene)];
    inputs.extend(input_files.iter().map(|file| FileWithRole::new("the input", &file.path)));
    check_distinct_files(&outputs, &inputs)?;
    let whole = scene.camera().size();
    let size = rendered_picture_size(arguments.crop, whole)?;
    make_film_header(&arguments.film_header_settings(), size, whole, &scene_file, &input_files)
}

/// Prints the two job scripts, and the sbatch commands that submit the first jobs.
fn print_scripts(folder: &WorkFolder, scripts: &JobScripts, division: ShardDivision) -> Result<Exit, CommandFailure> {
    // Without Slurm on this machine, assume the default limit of job arrays.
    let most = slurm::max_task_number().unwrap_or(slurm::DEFAULT_MAX_ARRAY_SIZE - 1);
    let shards: Vec<u32> = (1..=division.shards).collect();
    let line = |arguments: Vec<String>| {
        let words: Vec<String> = std::iter::once("sbatch".to_owned()).chain(arguments).collect();
        shell_command_line(&words).map_err(CommandFailure::usage_error)
    };
    let mut text = format!("# {}\n{}\n", folder.file_path(SHARD_SCRIPT_NAME).display(), scripts.shard_script);
    text += &format!("# {}\n{}\n", folder.file_path(MERGE_SCRIPT_NAME).display(), scripts.merge_script);
    let arrays = job_arrays(&shards, most);
    for array in &arrays {
        text += &format!("{}\n", line(shard_arguments(folder, array))?);
    }
    // Slurm has not numbered the jobs yet, so the names ARRAY1, ARRAY2 … stand for their numbers.
    let jobs: Vec<String> = (1..=arrays.len()).map(|n| format!("ARRAY{n}")).collect();
    text += &format!("{}\n", line(merge_arguments(folder, &jobs))?);
    std::io::stdout().write_all(text.as_bytes()).map_err(CommandFailure::output_error)?;
    Ok(Exit::Success)
}
