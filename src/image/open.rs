//! Opening files that end.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Opens a file, and tells its bytes. What is no file is refused before it is opened: a pipe may wait for ever, and a device never end.
pub(crate) fn open_file(path: &Path) -> io::Result<(File, u64)> {
    let found = fs::metadata(path)?;
    if !found.is_file() {
        return Err(io::Error::other("it is a folder, a pipe or a device: name a file"));
    }
    Ok((File::open(path)?, found.len()))
}
