//! Stamps that tell whether a file has changed.

use std::fs;
use std::path::Path;
use std::time::SystemTime;

/// Time of the last change of a file, and its length. They tell whether the file has changed since
/// it was read.
///
/// Equal stamps are taken to mean equal content. A change that keeps both time and length is not
/// seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileStamp {
    modified: SystemTime,
    /// Length of the file \[bytes].
    length: u64,
}

impl FileStamp {
    /// Returns the stamp of the file at `path`; `None` if there is no such file, or the system does
    /// not tell the time of its last change.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Self> {
        let data = fs::metadata(path).ok()?;
        Some(Self { modified: data.modified().ok()?, length: data.len() })
    }
}
