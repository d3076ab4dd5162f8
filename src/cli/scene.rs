//! The scene that the command line names, and the threads that work on it.

use super::args::SceneArguments;
use super::memory::check_pictures;
use super::{Exit, Failure};
use crate::format::mesh::ReadMonitor;
use crate::format::{ReadError, SceneFile};
use crate::scene::Scene;
use miette::IntoDiagnostic;

/// Reads and resolves a scene file, with the picture size replaced where one is given; refuses a picture, and then whatever the scene
/// names, that does not fit into memory, before any is taken for it. `monitor` hears how far meshes are read.
pub(super) fn load(arguments: &SceneArguments, monitor: &dyn ReadMonitor) -> Result<Scene, Failure> {
    let memory = arguments.memory();
    let mut file = SceneFile::read_within(&arguments.scene, memory).map_err(|e| {
        let exit = if matches!(e, ReadError::Memory { .. }) { Exit::Usage } else { Exit::Input };
        Failure::new(exit, e)
    })?;
    if let Some((width, height)) = arguments.size {
        file.description.camera.value.width = width;
        file.description.camera.value.height = height;
    }
    let camera = &file.description.camera;
    check_pictures(1, (camera.width, camera.height), memory.free()).map_err(|e| Failure::new(Exit::Usage, e))?;
    file.resolve_watched(monitor, memory).map_err(|e| {
        let exit = if e.exhausts_memory() { Exit::Usage } else { Exit::Input };
        Failure::new(exit, e)
    })
}

/// Does `work` with as many threads as are asked for.
pub(super) fn in_pool<T: Send>(
    arguments: &SceneArguments,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let threads = arguments.threads.map_or(0, |n| n as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.into_diagnostic().map_err(|e| Failure::new(Exit::Usage, e))?.install(work)
}
