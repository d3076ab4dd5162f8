//! Errors of reading and writing pictures. Each names the path and a remedy.

use std::io;
use std::path::PathBuf;

use super::buffer::SizeError;
use crate::stats::format_bytes;

/// Why a picture was not written. An existing file at the path is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The extension names no picture format.
    #[error("`{}` names no known picture format: give it the extension .png or .exr", path.display())]
    Extension {
        /// The path as given.
        path: PathBuf,
    },
    /// The extension is not `.exr`, the only format with layers.
    #[error("`{}` cannot hold layers: give it the extension .exr", path.display())]
    NoLayers {
        /// The path as given.
        path: PathBuf,
    },
    /// A channel that the format cannot hold.
    #[error("the channel `{channel}` cannot be stored: {reason}")]
    Channel {
        /// Full name of the channel.
        channel: String,
        /// The violated rule.
        reason: &'static str,
    },
    /// The folder of the file does not exist.
    #[error("cannot write `{}`: there is no folder `{}`: create it or choose another path", path.display(), folder.display())]
    NoFolder {
        /// The path as given.
        path: PathBuf,
        /// The missing folder.
        folder: PathBuf,
    },
    /// The path is a folder or a device.
    #[error("cannot write `{}`: a folder or device of this name exists: choose another path", path.display())]
    NotAFile {
        /// The path as given.
        path: PathBuf,
    },
    /// The existing file is read-only.
    #[error("cannot replace `{}`: the file is read-only: make it writable or choose another path", path.display())]
    ReadOnly {
        /// The path as given.
        path: PathBuf,
    },
    /// The system reported an error.
    #[error("cannot {action} `{}`: {source}", path.display())]
    Io {
        /// The operation that failed.
        action: &'static str,
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// Metadata that the format cannot hold.
    #[error("metadata `{key}` cannot be stored: {reason}")]
    Metadata {
        /// Key of the metadata.
        key: String,
        /// The violated rule.
        reason: &'static str,
    },
    /// The exposure is NaN or out of range.
    #[error("an exposure of {stops} stops is out of range: choose one from -{limit} to {limit}")]
    Exposure {
        /// Exposure in stops.
        stops: f32,
        /// Largest absolute exposure in stops.
        limit: f32,
    },
    /// The encoder reported an error.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
}

/// Why a picture was not read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The system reported an error.
    #[error("cannot read `{}`: {source}", path.display())]
    Io {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The signature is not that of PNG, OpenEXR or Radiance HDR.
    #[error("`{}` is not a PNG, OpenEXR or Radiance HDR picture: convert it to one of these", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file is damaged, truncated, or of an unsupported variant.
    #[error("cannot decode `{}`: {reason}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// Cause and, if known, remedy.
        reason: String,
    },
    /// The file states an invalid size.
    #[error("cannot decode `{}`: {source}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// The invalid size.
        source: SizeError,
    },
    /// The picture does not fit into memory.
    #[error(
        "`{}` takes {} of memory, and {} are free: make the picture smaller, or allow more --memory",
        path.display(), format_bytes(*needed), format_bytes(*free)
    )]
    Memory {
        /// The file.
        path: PathBuf,
        /// Bytes that reading the picture takes.
        needed: u64,
        /// Free bytes.
        free: u64,
    },
}

/// Failure of a decoder, which does not know the path.
pub(super) enum DecodeFailure {
    Reason(String),
    Size(SizeError),
    Memory { needed: u64, free: u64 },
}

impl From<SizeError> for DecodeFailure {
    fn from(error: SizeError) -> Self {
        Self::Size(error)
    }
}

impl DecodeFailure {
    /// The error for the file at `path`.
    pub(super) fn into_read_error(self, path: PathBuf) -> ReadError {
        match self {
            Self::Reason(reason) => ReadError::Decode { path, reason },
            Self::Size(source) => ReadError::Size { path, source },
            Self::Memory { needed, free } => ReadError::Memory { path, needed, free },
        }
    }
}

/// Refuses a file of `file` bytes whose header states `raw` bytes of uncompressed data, if that is
/// impossible.
///
/// DEFLATE expands one byte to at most 1032 bytes (zlib technical details: 258 bytes for two bits).
/// The check keeps a false header from allocating memory.
pub(super) fn check_compression_ratio(raw: u64, file: usize) -> Result<(), DecodeFailure> {
    if raw > 1032 * file as u64 {
        return Err(DecodeFailure::Reason("the file is too short for the size that it states".into()));
    }
    Ok(())
}

/// Peak bytes per pixel while a picture is read and made a texture or an environment light.
///
/// The peak is an OpenEXR file: four channels twice in single precision (32), RGB (12), and slack
/// (4). Later stages take less: the picture with its MIP pyramid (12 + 16), or with the tables of
/// light sampling (12 + 24).
const PEAK_BYTES_PER_PIXEL: u64 = 48;

/// Refuses a picture that does not fit into `free` bytes, before it is allocated.
pub(super) fn check_memory(pixels: usize, free: Option<u64>) -> Result<(), DecodeFailure> {
    let needed = PEAK_BYTES_PER_PIXEL * pixels as u64;
    match free {
        Some(free) if needed > free => Err(DecodeFailure::Memory { needed, free }),
        _ => Ok(()),
    }
}
