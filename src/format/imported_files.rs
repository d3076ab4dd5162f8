//! Access to the files that a scene names: folder, permission and memory.

use super::import::{ImportOptions, ReadResult, SceneReadError};
use crate::image::{open_file, parent_folder};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Reason why a scene cannot use a file.
pub(super) struct FileDefect {
    pub message: String,
    /// Help text: how the user can mend the defect.
    pub help: String,
}

/// Returns the path of the file `name`, relative to the folder of the scene file at `scene`.
///
/// # Errors
/// The file does not exist. Or it lies outside that folder, and `options` do not allow this.
pub(super) fn find_file_in_folder(scene: &Path, name: &str, options: &ImportOptions) -> Result<PathBuf, FileDefect> {
    let file = parent_folder(scene).join(name);
    if file.canonicalize().is_err() {
        let help = format!("put the file at `{}`", file.display());
        return Err(FileDefect { message: format!("the file `{name}` does not exist"), help });
    }
    check_permission(scene, &file, name, options)?;
    Ok(file)
}

/// Fails if `file`, which the scene calls `name`, lies outside the folder of the scene file at
/// `scene`, unless `options` allow this.
pub(super) fn check_permission(
    scene: &Path,
    file: &Path,
    name: &str,
    options: &ImportOptions,
) -> Result<(), FileDefect> {
    let is_inside = match (parent_folder(scene).canonicalize(), file.canonicalize()) {
        (Ok(folder), Ok(file)) => file.starts_with(folder),
        _ => false,
    };
    if is_inside || options.allows_outside_files {
        return Ok(());
    }
    let help = "move the file below the scene's folder, or trust the scene with --allow-outside".to_owned();
    Err(FileDefect { message: format!("`{name}` is outside the folder of the scene"), help })
}

/// Fails with an error that names `path` if `needed` bytes exceed `free`. A `free` of `None` sets
/// no limit.
pub(super) fn check_memory(path: &Path, needed: u64, free: Option<u64>) -> ReadResult<()> {
    match free {
        Some(free) if needed > free => Err(SceneReadError::OutOfMemory { path: path.to_owned(), needed, free }),
        _ => Ok(()),
    }
}

/// Returns the content of the file at `path`. `check_length` receives the length of the file
/// \[bytes] before it is read, and may refuse it.
pub(super) fn read_file(path: &Path, check_length: impl FnOnce(u64) -> ReadResult<()>) -> ReadResult<Vec<u8>> {
    let unreadable = |source| SceneReadError::Unreadable { path: path.to_owned(), source };
    let (file, length) = open_file(path).map_err(unreadable)?;
    check_length(length)?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}
