//! Writes pictures to files.

use std::path::Path;

use super::buffer::Image;
use super::error::WriteError;
use super::options::{WriteOptions, check_metadata};
use super::replace::{check_replaceable, replace_file};
use super::tone::WriteReport;
use super::{exr, png};

/// File format that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// PNG with 8 or 16 bits per channel, after the tone map.
    Png,
    /// OpenEXR with 16- or 32-bit float RGB: linear radiance without a tone map.
    Exr,
}

impl OutputFormat {
    /// Format of a path by its extension, in upper or lower case.
    ///
    /// # Errors
    /// [`WriteError::Extension`] if the extension is neither `.png` nor `.exr`.
    pub fn from_path(path: &Path) -> Result<Self, WriteError> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("png") => Ok(Self::Png),
            Some(extension) if extension.eq_ignore_ascii_case("exr") => Ok(Self::Exr),
            _ => Err(WriteError::Extension { path: path.to_owned() }),
        }
    }
}

/// Encodes a picture to the bytes of a file.
///
/// # Errors
/// [`WriteError::Exposure`] or [`WriteError::Metadata`] if an option is invalid, or
/// [`WriteError::Encode`].
pub fn encode(
    format: OutputFormat,
    image: &Image,
    options: &WriteOptions,
) -> Result<(Vec<u8>, WriteReport), WriteError> {
    check_metadata(&options.metadata)?;
    match format {
        OutputFormat::Png => png::encode(image, options),
        OutputFormat::Exr => exr::encode(image, options.floats, &options.metadata),
    }
}

/// Writes a picture in the format of the path's extension. The file is replaced atomically (see
/// [`replace_file`]).
///
/// Returns how many pixels the format could not hold, which callers should show to the user.
///
/// # Errors
/// [`WriteError`]; an existing file is then unchanged.
pub fn write(path: &Path, image: &Image, options: &WriteOptions) -> Result<WriteReport, WriteError> {
    let (file, report) = encode(OutputFormat::from_path(path)?, image, options)?;
    replace_file(path, &file)?;
    Ok(report)
}

/// Checks before a long render that [`write`](fn@write) can write to `path`. Leaves no trace.
///
/// # Errors
/// [`WriteError`] that [`write`](fn@write) would return.
pub fn check_writable(path: &Path) -> Result<(), WriteError> {
    OutputFormat::from_path(path)?;
    check_replaceable(path)
}

#[cfg(test)]
mod tests;
