//! Opens regular files for reading, and refuses pipes and devices.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Opens a regular file, and returns it with its length \[bytes].
///
/// Fails for pipes and devices, because reading from them might never end.
pub(crate) fn open_file(path: &Path) -> io::Result<(File, u64)> {
    let found = fs::metadata(path)?;
    if !found.is_file() {
        return Err(io::Error::other("it is a folder, a pipe or a device: choose a regular file"));
    }
    Ok((File::open(path)?, found.len()))
}
