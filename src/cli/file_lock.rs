//! Locks of files against use by two processes.

use crate::image::canonical_output_path;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Advisory lock that keeps two processes of `caustica` from using one file. The process locks a
/// second file in the same folder, which has the name of the file with `.lock` added.
///
/// Symbolic links are resolved before `.lock` is added, so all links to a file share its lock.
pub(super) struct FileLock {
    path: PathBuf,
    /// Open file that holds the lock. The system releases the lock when the process ends.
    _file: File,
}

impl FileLock {
    /// Locks the file at `path`, which need not exist. Returns `None` if another process holds the
    /// lock.
    pub fn acquire(path: &Path) -> io::Result<Option<Self>> {
        let mut name = canonical_output_path(path).into_os_string();
        name.push(".lock");
        let lock = PathBuf::from(name);
        loop {
            let file = File::create(&lock)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(error)) => return Err(error),
            }
            // If another process has removed the lock file meanwhile, try again.
            if is_file_at(&file, &lock) {
                return Ok(Some(Self { path: lock, _file: file }));
            }
        }
    }
}

impl Drop for FileLock {
    fn drop(&mut self) {
        // A lock file that cannot be removed does no harm: the next process locks it again.
        let _ = fs::remove_file(&self.path);
    }
}

/// True if the file at `path` is the open file `file`, not a later file of this name: device and
/// inode are equal.
#[cfg(unix)]
fn is_file_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (open, named) = (file.metadata(), fs::metadata(path));
    open.is_ok_and(|open| named.is_ok_and(|named| (open.dev(), open.ino()) == (named.dev(), named.ino())))
}

/// True if the file at `path` is the open file `file`. On systems other than Unix, an open file
/// cannot be removed, so any file at `path` is `file`.
#[cfg(not(unix))]
fn is_file_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn symbolic_links_share_the_lock_of_their_file() {
        let folder = tempfile::tempdir().unwrap();
        let [film, link] = ["a.film", "link.film"].map(|name| folder.path().join(name));
        fs::write(&film, "").unwrap();
        std::os::unix::fs::symlink(&film, &link).unwrap();
        let lock = FileLock::acquire(&link).unwrap();
        assert!(lock.is_some() && FileLock::acquire(&film).unwrap().is_none());
        drop(lock);
        assert!(FileLock::acquire(&film).unwrap().is_some());
    }
}
