//! Writes PNG and OpenEXR files.

use std::path::Path;

use super::buffer::Image;
use super::error::WriteError;
use super::options::{WriteOptions, check_metadata};
use super::replace::{check_replaceable, replace_file};
use super::tone::ClippedPixelReport;
use super::{exr, png};

/// Picture file format that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// PNG with 8 or 16 bits per channel. A tone map converts radiance to integer levels.
    Png,
    /// OpenEXR with 16 or 32 bits per channel, for linear radiance.
    Exr,
}

impl OutputFormat {
    /// Returns the file format by the extension of `path`, in upper or lower case.
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

/// Encodes a picture as the bytes of a file.
///
/// Also returns the numbers of pixels with clamped or non-finite values.
///
/// # Errors
/// [`WriteError::Exposure`] or [`WriteError::Metadata`] if an option is invalid.
/// [`WriteError::Encode`] if the encoder fails.
pub fn encode(
    format: OutputFormat,
    image: &Image,
    options: &WriteOptions,
) -> Result<(Vec<u8>, ClippedPixelReport), WriteError> {
    check_metadata(&options.metadata)?;
    match format {
        OutputFormat::Png => png::encode(image, options),
        OutputFormat::Exr => exr::encode(image, options.exr_precision, &options.metadata),
    }
}

/// Writes a picture to `path`, whose extension determines the file format.
///
/// Returns the numbers of pixels with clamped or non-finite values. The file is replaced
/// atomically, see [`replace_file`].
///
/// # Errors
/// [`WriteError`]; an existing file is then unchanged.
pub fn write(path: &Path, image: &Image, options: &WriteOptions) -> Result<ClippedPixelReport, WriteError> {
    let (file, report) = encode(OutputFormat::from_path(path)?, image, options)?;
    replace_file(path, &file)?;
    Ok(report)
}

/// Checks whether [`write`](fn@write) can write to `path`, without changing the file.
///
/// # Errors
/// [`WriteError`] that [`write`](fn@write) would return.
pub fn check_writable(path: &Path) -> Result<(), WriteError> {
    OutputFormat::from_path(path)?;
    check_replaceable(path)
}

#[cfg(test)]
mod tests;
