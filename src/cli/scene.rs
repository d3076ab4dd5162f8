//! Loads the scene of a command, and sets up its threads.

use super::args::SceneArguments;
use super::memory::check_pictures;
use super::{Exit, Failure};
use crate::format::mesh::MeshReadMonitor;
use crate::format::{SceneFile, SceneReadError};
use crate::scene::Scene;

/// Reads and resolves the scene file, with the picture size of `--size` if given.
///
/// A picture or an input of the scene that does not fit into memory is refused before it is
/// allocated. `monitor` receives the progress of reading.
pub(super) fn load(arguments: &SceneArguments, monitor: &dyn MeshReadMonitor) -> Result<Scene, Failure> {
    load_with_file(arguments, monitor).map(|(_, scene)| scene)
}

/// Like [`load`], and returns the scene file too.
pub(super) fn load_with_file(
    arguments: &SceneArguments,
    monitor: &dyn MeshReadMonitor,
) -> Result<(SceneFile, Scene), Failure> {
    let memory = arguments.memory();
    let mut file = SceneFile::read_within_memory(&arguments.scene, memory).map_err(|e| {
        let exit = if matches!(e, SceneReadError::Memory { .. }) { Exit::Usage } else { Exit::Input };
        Failure::new(exit, e)
    })?;
    if let Some((width, height)) = arguments.size {
        file.description.camera.value.width = width;
        file.description.camera.value.height = height;
    }
    let camera = &file.description.camera;
    check_pictures(1, (camera.width, camera.height), memory.free()).map_err(Failure::usage)?;
    let scene = file.resolve_monitored(monitor, memory).map_err(|e| {
        let exit = if e.is_out_of_memory() { Exit::Usage } else { Exit::Input };
        Failure::new(exit, e)
    })?;
    Ok((file, scene))
}

/// Runs `work` in a pool with the number of threads of `--threads`.
pub(super) fn in_pool<T: Send>(
    arguments: &SceneArguments,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let threads = arguments.threads.map_or(0, |n| n as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Failure::usage(miette::Report::from_err(e)))?.install(work)
}
