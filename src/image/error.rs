//! Errors of reading and writing pictures. Messages name the file and, if known, a remedy.

use std::io;
use std::path::PathBuf;

use super::buffer::PictureSizeError;
use crate::stats::format_bytes;

/// Error: a picture was not written. An existing file at the path is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The extension of the output file is neither `.png` nor `.exr`.
    #[error("`{}` names no known picture format: give it the extension .png or .exr", path.display())]
    Extension {
        /// Path of the output file, as given by the caller.
        path: PathBuf,
    },
    /// A file with layers was requested, but its extension is not `.exr`.
    #[error("`{}` cannot hold layers: give it the extension .exr", path.display())]
    LayersNotSupported {
        /// Path of the output file, as given by the caller.
        path: PathBuf,
    },
    /// A channel breaks a rule of OpenEXR.
    #[error("the channel `{channel}` cannot be stored: {reason}")]
    Channel {
        /// Name of the channel with its layer, such as `noise.R`.
        channel: String,
        /// The rule of OpenEXR that the channel breaks.
        reason: &'static str,
    },
    /// The folder in which the output file should be created does not exist.
    #[error("cannot write `{}`: there is no folder `{}`: create it or choose another path", path.display(), folder.display())]
    NoFolder {
        /// Path of the output file, as given by the caller.
        path: PathBuf,
        /// The folder that does not exist.
        folder: PathBuf,
    },
    /// The output path is a folder or a device.
    #[error("cannot write `{}`: a folder or device of this name exists: choose another path", path.display())]
    NotAFile {
        /// Path of the output file, as given by the caller.
        path: PathBuf,
    },
    /// The existing output file is read-only.
    #[error("cannot replace `{}`: the file is read-only: make it writable or choose another path", path.display())]
    ReadOnly {
        /// Path of the output file, as given by the caller.
        path: PathBuf,
    },
    /// An operation on the file failed with an error of the operating system.
    #[error("cannot {action} `{}`: {source}", path.display())]
    Io {
        /// The operation that failed. The words stand between "cannot" and a path in the message,
        /// such as `create a file in`.
        action: &'static str,
        /// Path of the file or folder on which the operation failed.
        path: PathBuf,
        /// Error that the operating system reported.
        source: io::Error,
    },
    /// A metadata entry (key and text) breaks a rule of the file format.
    #[error("metadata `{key}` cannot be stored: {reason}")]
    Metadata {
        /// Key of the refused metadata entry.
        key: String,
        /// The rule of the file format that the key or the text breaks.
        reason: &'static str,
    },
    /// The exposure is NaN or outside ±[`MAX_EXPOSURE_STOPS`](super::MAX_EXPOSURE_STOPS).
    #[error("an exposure of {stops} stops is out of range: choose one from -{limit} to {limit}")]
    Exposure {
        /// The given exposure \[stops].
        stops: f32,
        /// Largest accepted absolute exposure \[stops].
        limit: f32,
    },
    /// The encoder of the file format failed. Holds the encoder's message.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
}

/// Error: a picture was not read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// An operation on the file failed with an error of the operating system.
    #[error("cannot read `{}`: {source}", path.display())]
    Io {
        /// Path of the picture file.
        path: PathBuf,
        /// Error that the operating system reported.
        source: io::Error,
    },
    /// The first bytes are not a signature of PNG, OpenEXR or Radiance HDR.
    #[error("`{}` is not a PNG, OpenEXR or Radiance HDR picture: convert it to one of these", path.display())]
    UnknownFormat {
        /// Path of the picture file.
        path: PathBuf,
    },
    /// The file is damaged, truncated, or of an unsupported variant.
    #[error("cannot decode `{}`: {reason}", path.display())]
    Decode {
        /// Path of the picture file.
        path: PathBuf,
        /// Cause of the failure and, if known, its remedy.
        reason: String,
    },
    /// The header of the file contains an invalid picture size.
    #[error("cannot decode `{}`: {source}", path.display())]
    Size {
        /// Path of the picture file.
        path: PathBuf,
        /// Reason why the size is invalid.
        source: PictureSizeError,
    },
    /// Reading the picture takes more memory than is free.
    #[error(
        "`{}` takes {} of memory, and {} are free: make the picture smaller, or allow more --memory",
        path.display(), format_bytes(*needed), format_bytes(*free)
    )]
    Memory {
        /// Path of the picture file.
        path: PathBuf,
        /// Needed memory \[bytes]: the length of the file if the file alone is longer than `free`,
        /// else the peak memory of decoding the picture.
        needed: u64,
        /// Memory that the reader was allowed to use \[bytes].
        free: u64,
    },
}

/// Error of a decoder: a [`ReadError`] without the path of the file, which decoders do not know.
pub(super) enum DecodeFailure {
    Reason(String),
    Size(PictureSizeError),
    Memory { needed: u64, free: u64 },
}

impl From<PictureSizeError> for DecodeFailure {
    fn from(error: PictureSizeError) -> Self {
        Self::Size(error)
    }
}

impl DecodeFailure {
    /// Converts the failure to a [`ReadError`] of the file at `path`.
    pub(super) fn into_read_error(self, path: PathBuf) -> ReadError {
        match self {
            Self::Reason(reason) => ReadError::Decode { path, reason },
            Self::Size(source) => ReadError::Size { path, source },
            Self::Memory { needed, free } => ReadError::Memory { path, needed, free },
        }
    }
}

/// Fails if a compressed file of `file` bytes is too short to hold the pixels that its header
/// claims: `uncompressed` bytes after decompression.
///
/// The check prevents huge allocations for a damaged header. The largest compression ratio of
/// DEFLATE is 1032 : 1 (zlib technical details).
pub(super) fn check_compression_ratio(uncompressed: u64, file: usize) -> Result<(), DecodeFailure> {
    if uncompressed > 1032 * file as u64 {
        return Err(DecodeFailure::Reason("the file is too short for the size that it states".into()));
    }
    Ok(())
}

/// Peak memory per pixel while a picture is read and turned into a texture or an environment light
/// \[bytes].
///
/// The peak occurs while an OpenEXR file is read: two buffers of four single-precision channels (32
/// bytes), a copy in RGB (12 bytes) and 4 bytes to spare. Less is needed later: 28 bytes for a
/// texture with its MIP pyramid, 36 bytes for an environment light with its sampling tables.
const PEAK_BYTES_PER_PIXEL: u64 = 48;

/// Fails if reading a picture of `pixels` pixels needs more than `free` bytes of memory; `None`
/// means no limit.
pub(super) fn check_memory(pixels: usize, free: Option<u64>) -> Result<(), DecodeFailure> {
    let needed = PEAK_BYTES_PER_PIXEL * pixels as u64;
    match free {
        Some(free) if needed > free => Err(DecodeFailure::Memory { needed, free }),
        _ => Ok(()),
    }
}
