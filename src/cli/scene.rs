//! The scene that the command line names, and the threads that work on it.

use super::args::SceneArguments;
use super::memory::{self, check_pictures};
use super::{Exit, Failure};
use crate::format::SceneFile;
use crate::format::mesh::ReadMonitor;
use crate::scene::Scene;
use miette::IntoDiagnostic;

/// Reads and resolves a scene file, with the picture size replaced where one is given; refuses a picture that does not fit into
/// memory. `monitor` hears how far meshes are read.
pub(super) fn load(arguments: &SceneArguments, monitor: &dyn ReadMonitor) -> Result<Scene, Failure> {
    let mut file = SceneFile::read(&arguments.scene).map_err(|e| Failure::new(Exit::Input, e))?;
    if let Some((width, height)) = arguments.size {
        file.description.camera.value.width = width;
        file.description.camera.value.height = height;
    }
    let scene = file.resolve_watched(monitor).map_err(|e| Failure::new(Exit::Input, e))?;
    check_pictures(1, scene.camera().size(), memory::free()).map_err(|e| Failure::new(Exit::Usage, e))?;
    Ok(scene)
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
