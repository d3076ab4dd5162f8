//! Writes pictures to files.

use std::path::Path;

use super::buffer::Image;
use super::error::WriteError;
use super::replace::{check_replaceable, replace_file};
use super::tone::{ToneMap, WriteReport};
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

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BitDepth {
    /// 256 levels.
    #[default]
    Eight,
    /// 65,536 levels.
    Sixteen,
}

/// Bits per channel of an OpenEXR file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatDepth {
    /// Half precision: 11 significant bits, up to 65504.
    Half,
    /// Single precision.
    #[default]
    Single,
}

/// Options of [`write`](fn@write).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// Exposure and tone curve of PNG.
    pub tone: ToneMap,
    /// Bits per channel of PNG.
    pub depth: BitDepth,
    /// Bits per channel of OpenEXR.
    pub floats: FloatDepth,
    /// Pairs of key and text: text chunks of PNG, lines `key: text` of the attribute `comments` of
    /// OpenEXR. A key has 1 to 79 printable ASCII characters, without leading, trailing or repeated
    /// spaces. A text has no NUL.
    pub metadata: Vec<(String, String)>,
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

/// Checks the rules of PNG keywords (ISO/IEC 15948, 11.3.4.2), restricted to ASCII.
///
/// They apply to OpenEXR too, so that both formats accept the same pairs.
pub(super) fn check_metadata(metadata: &[(String, String)]) -> Result<(), WriteError> {
    for (key, text) in metadata {
        let violated = if !(1..=79).contains(&key.len()) {
            Some("a key must have 1 to 79 characters")
        } else if !key.bytes().all(|byte| (32..127).contains(&byte)) {
            Some("a key must consist of printable ASCII characters")
        } else if key.starts_with(' ') || key.ends_with(' ') || key.contains("  ") {
            Some("a key must not have leading, trailing or repeated spaces")
        } else if text.contains('\0') {
            Some("its text contains a NUL character")
        } else {
            None
        };
        if let Some(reason) = violated {
            return Err(WriteError::Metadata { key: key.clone(), reason });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
