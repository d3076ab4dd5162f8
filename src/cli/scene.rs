//! Loading of a command's scene, and its thread pool.

use super::progress::print_message;
use super::scene_args::{ImportArguments, SceneArguments};
use super::{CommandFailure, Exit};
use crate::format::mesh::MeshReadMonitor;
use crate::format::{ResolvedScene, SceneFile, SceneReadError};
use crate::render::check_picture_memory;
use crate::scene::Scene;
use crate::stats::MemoryLimit;
use miette::Report;
use std::path::{Path, PathBuf};

/// Reads and builds the scene that the command line names, and prints the warnings of its importer.
/// `--size` replaces the picture size of the scene.
///
/// If a picture or an input does not fit into memory, returns a failure before memory is allocated.
/// `monitor` receives the progress of reading.
pub(super) fn load_scene(arguments: &SceneArguments, monitor: &dyn MeshReadMonitor) -> Result<Scene, CommandFailure> {
    let (file, scene) = load_scene_and_file(arguments, monitor)?;
    import_warnings(&file).iter().for_each(|line| print_message(line));
    Ok(scene)
}

/// Error: content of a scene file is not supported, and `--strict` is given.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{}: {message}", path.display())]
#[diagnostic(help("change the scene, or render it without --strict"))]
struct UnsupportedContentError {
    path: PathBuf,
    message: String,
}

/// Reads a scene file. With `--strict`, content that is not supported is a failure.
pub(super) fn read_scene_file(
    path: &Path,
    import: &ImportArguments,
    monitor: &dyn MeshReadMonitor,
    memory: MemoryLimit,
) -> Result<SceneFile, CommandFailure> {
    let file = SceneFile::read_with_options(path, monitor, &import.import_options(memory)).map_err(|e| {
        let exit = if matches!(e, SceneReadError::OutOfMemory { .. }) { Exit::Usage } else { Exit::Input };
        CommandFailure::new(exit, e)
    })?;
    let unsupported = file.notes.iter().filter(|note| import.strict && note.concerns_unsupported_content);
    let reports: Vec<Report> = unsupported
        .map(|note| UnsupportedContentError { path: path.to_owned(), message: note.message.clone() }.into())
        .collect();
    if reports.is_empty() { Ok(file) } else { Err(CommandFailure { reports, exit: Exit::Input }) }
}

/// Returns the warnings of the scene importer about ignored or approximated content, one line each.
pub(super) fn import_warnings(file: &SceneFile) -> Vec<String> {
    file.import_warnings().iter().map(|line| replace_control_characters(line)).collect()
}

/// Replaces control characters by U+FFFD, so that a file name cannot control the terminal.
pub(super) fn replace_control_characters(line: &str) -> String {
    line.replace(char::is_control, "\u{fffd}")
}

/// Reads and builds the scene that the command line names. Returns its parsed file and the scene.
pub(super) fn load_scene_and_file(
    arguments: &SceneArguments,
    monitor: &dyn MeshReadMonitor,
) -> Result<(SceneFile, Scene), CommandFailure> {
    let file = read_resized_scene_file(arguments, monitor)?;
    let scene = resolve_scene_file(&file, arguments, monitor)?;
    Ok((file, scene))
}

/// Reads the scene file that the command line names. `--size` replaces the picture size of the
/// scene.
///
/// If the picture does not fit into memory, returns a failure.
pub(super) fn read_resized_scene_file(
    arguments: &SceneArguments,
    monitor: &dyn MeshReadMonitor,
) -> Result<SceneFile, CommandFailure> {
    let memory = arguments.memory_limit();
    let mut file = read_scene_file(&arguments.scene, &arguments.import, monitor, memory)?;
    if let Some((width, height)) = arguments.size {
        file.description.camera.value.width = width;
        file.description.camera.value.height = height;
    }
    let camera = &file.description.camera;
    check_picture_memory(1, (camera.width, camera.height), memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    Ok(file)
}

/// Resolves the scene that `file` describes: loads meshes, pictures and other files that the scene
/// names, and builds the scene, within the memory limit of the command line.
pub(super) fn resolve_scene_file(
    file: &SceneFile,
    arguments: &SceneArguments,
    monitor: &dyn MeshReadMonitor,
) -> Result<Scene, CommandFailure> {
    Ok(resolve_scene_file_incrementally(None, file, arguments, monitor)?.scene)
}

/// Builds the scene that `file` describes, within the memory limit of the command line. Meshes and
/// bounding volume hierarchies that are unchanged since `earlier` are shared with that scene.
pub(super) fn resolve_scene_file_incrementally(
    earlier: Option<&ResolvedScene>,
    file: &SceneFile,
    arguments: &SceneArguments,
    monitor: &dyn MeshReadMonitor,
) -> Result<ResolvedScene, CommandFailure> {
    file.resolve_incrementally(earlier, monitor, arguments.memory_limit()).map_err(|e| {
        let exit = if e.is_out_of_memory() { Exit::Usage } else { Exit::Input };
        CommandFailure::new(exit, e)
    })
}

/// Runs `work` in a Rayon pool of `--threads` threads; by default one for each core.
pub(super) fn with_thread_pool<T: Send>(
    arguments: &SceneArguments,
    work: impl FnOnce() -> Result<T, CommandFailure> + Send,
) -> Result<T, CommandFailure> {
    let threads = arguments.threads.map_or(0, |n| n as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| CommandFailure::usage_error(miette::Report::from_err(e)))?.install(work)
}
