//! Loading of a command's scene, and its thread pool.

use super::args::SceneArguments;
use super::memory::check_picture_memory;
use super::{CommandFailure, Exit};
use crate::format::mesh::MeshReadMonitor;
use crate::format::{SceneFile, SceneReadError};
use crate::scene::Scene;

/// Loads the scene of the command line, with the picture size of `--size` if given.
///
/// If a picture or an input does not fit into memory, returns a failure before memory is allocated.
/// `monitor` receives the progress of reading.
pub(super) fn load_scene(arguments: &SceneArguments, monitor: &dyn MeshReadMonitor) -> Result<Scene, CommandFailure> {
    load_scene_and_file(arguments, monitor).map(|(_, scene)| scene)
}

/// Loads the scene of the command line. Returns its parsed file and the resolved scene.
pub(super) fn load_scene_and_file(
    arguments: &SceneArguments,
    monitor: &dyn MeshReadMonitor,
) -> Result<(SceneFile, Scene), CommandFailure> {
    let memory = arguments.memory_limit();
    let mut file = SceneFile::read_monitored(&arguments.scene, monitor, memory).map_err(|e| {
        let exit = if matches!(e, SceneReadError::Memory { .. }) { Exit::Usage } else { Exit::Input };
        CommandFailure::new(exit, e)
    })?;
    if let Some((width, height)) = arguments.size {
        file.description.camera.value.width = width;
        file.description.camera.value.height = height;
    }
    let camera = &file.description.camera;
    check_picture_memory(1, (camera.width, camera.height), memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    let scene = file.resolve_monitored(monitor, memory).map_err(|e| {
        let exit = if e.is_out_of_memory() { Exit::Usage } else { Exit::Input };
        CommandFailure::new(exit, e)
    })?;
    Ok((file, scene))
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
