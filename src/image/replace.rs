//! Atomic replacement of files: other programs see the old file or the complete new one.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use tempfile::NamedTempFile;

use super::error::WriteError;

/// Replaces the file at `path` by a file with content `bytes`, atomically. If writing fails, the
/// old file stays.
///
/// The bytes are written to a temporary file in the same folder, which is flushed to the disk and
/// renamed to `path`. Symbolic links are followed. A replaced file keeps its permissions. A new
/// file has default permissions.
///
/// # Errors
/// [`WriteError`] if the folder is missing, if the path is a folder, device or read-only file, or
/// if the system refuses.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    replace_file_with(path, |file| file.write_all(bytes))
}

/// Replaces the file at `path` by a file that `fill` writes, atomically like [`replace_file`].
///
/// # Errors
/// [`WriteError`] like [`replace_file`], or if `fill` fails.
pub fn replace_file_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), WriteError> {
    let target = ReplaceTarget::find_replaceable_file(path)?;
    // Dropping the temporary file on an early return removes it.
    let mut temporary = target.create_temporary_file()?;
    let wrote = fill(temporary.as_file_mut()).and_then(|()| temporary.as_file().sync_all());
    wrote.map_err(|source| WriteError::Io { action: "write", path: path.to_owned(), source })?;
    match temporary.persist(&target.file) {
        Ok(_) => Ok(()),
        Err(error) => Err(WriteError::Io { action: "replace", path: path.to_owned(), source: error.error }),
    }
}

/// Checks whether [`replace_file`] can write to `path`, without changing the file.
///
/// # Errors
/// [`WriteError`] that [`replace_file`] would return.
pub fn check_replaceable(path: &Path) -> Result<(), WriteError> {
    ReplaceTarget::find_replaceable_file(path)?.create_temporary_file().map(drop)
}

/// Returns the absolute path of the file that [`replace_file`] would write, with symbolic links
/// resolved.
///
/// Two paths to one file have equal results, so equal outputs can be detected. A path whose folder
/// does not exist is returned unchanged.
#[must_use]
pub fn canonical_output_path(path: &Path) -> PathBuf {
    let in_folder = || Some(fs::canonicalize(parent_folder(path)).ok()?.join(path.file_name()?));
    fs::canonicalize(path).ok().or_else(in_folder).unwrap_or_else(|| path.to_owned())
}

/// Returns the folder of `file`; `.` for a bare file name.
#[must_use]
pub(crate) fn parent_folder(file: &Path) -> &Path {
    file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Prefix and suffix of the names of the temporary files of [`replace_file`].
const TEMPORARY_NAME: (&str, &str) = (".caustica-", ".tmp");

/// Age above which a temporary file is removed, because the process that made it was probably
/// killed.
const ABANDONED_AGE: Duration = Duration::from_secs(3600);

/// Removes temporary files of [`replace_file`] in `folder` that are older than [`ABANDONED_AGE`] at
/// the time `now`: killed processes left them. Failures are ignored.
///
/// A file whose modification time is after `now` stays. Such files exist if the clock was set back.
fn remove_abandoned_files(folder: &Path, now: SystemTime) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours =
            name.to_str().is_some_and(|name| name.starts_with(TEMPORARY_NAME.0) && name.ends_with(TEMPORARY_NAME.1));
        let abandoned = || {
            let metadata = entry.metadata().ok().filter(fs::Metadata::is_file)?;
            let age = now.duration_since(metadata.modified().ok()?).ok()?;
            (age > ABANDONED_AGE).then_some(())
        };
        if ours && abandoned().is_some() {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Target of an atomic replacement: a writable file, or a path at which a file can be created.
struct ReplaceTarget {
    /// Path of the target, with symbolic links resolved.
    file: PathBuf,
    folder: PathBuf,
    /// Permissions of the file to replace; `None` if there is no file yet.
    existing: Option<fs::Permissions>,
}

impl ReplaceTarget {
    /// Finds the file at `path` to replace or create; fails if the folder is missing or the file is
    /// not writable.
    fn find_replaceable_file(path: &Path) -> Result<Self, WriteError> {
        let file = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let folder = parent_folder(&file).to_owned();
        if !folder.is_dir() {
            return Err(WriteError::NoFolder { path: path.to_owned(), folder });
        }
        let existing = match fs::metadata(&file) {
            Ok(metadata) if !metadata.is_file() => return Err(WriteError::NotAFile { path: path.to_owned() }),
            Ok(metadata) if metadata.permissions().readonly() => {
                return Err(WriteError::ReadOnly { path: path.to_owned() });
            }
            Ok(metadata) => Some(metadata.permissions()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(source) => return Err(WriteError::Io { action: "inspect", path: path.to_owned(), source }),
        };
        Ok(Self { file, folder, existing })
    }

    /// Creates a temporary file in the target's folder. If the target exists, the temporary file
    /// gets the permissions of the target.
    fn create_temporary_file(&self) -> Result<NamedTempFile, WriteError> {
        let refused = |source| WriteError::Io { action: "create a file in", path: self.folder.clone(), source };
        remove_abandoned_files(&self.folder, SystemTime::now());
        let mut builder = tempfile::Builder::new();
        builder.prefix(TEMPORARY_NAME.0).suffix(TEMPORARY_NAME.1);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Ask for default permissions, from which the system removes the bits of the umask. The
            // default of tempfile is 0600.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let temporary = builder.tempfile_in(&self.folder).map_err(refused)?;
        if let Some(permissions) = &self.existing {
            temporary.as_file().set_permissions(permissions.clone()).map_err(refused)?;
        }
        Ok(temporary)
    }
}

#[cfg(test)]
mod tests;
