//! What can go wrong between a picture and its file, with the path and the remedy.

use std::io;
use std::path::PathBuf;

use super::buffer::SizeError;
use super::tone::MAX_EXPOSURE_STOPS;

/// Why a picture was not written. The file that stood at the path before is untouched.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The extension names no format.
    #[error("`{}` names no known picture format: give it the extension .png or .exr", path.display())]
    Extension {
        /// The path as given.
        path: PathBuf,
    },
    /// The extension is not that of the one format that holds layers.
    #[error("`{}` cannot hold layers: give it the extension .exr", path.display())]
    NoLayers {
        /// The path as given.
        path: PathBuf,
    },
    /// A layer that the format cannot hold.
    #[error("the channel `{channel}` cannot be stored: {reason}")]
    Channel {
        /// Its whole name.
        channel: String,
        /// The rule it breaks.
        reason: &'static str,
    },
    /// The folder that should hold the file is missing.
    #[error("cannot write `{}`: there is no folder `{}`: create it or choose another path", path.display(), folder.display())]
    NoFolder {
        /// The path as given.
        path: PathBuf,
        /// The missing folder.
        folder: PathBuf,
    },
    /// Something other than a file stands at the path.
    #[error("cannot write `{}`: a folder or device of this name exists: choose another path", path.display())]
    NotAFile {
        /// The path as given.
        path: PathBuf,
    },
    /// The existing file is marked read-only.
    #[error("cannot replace `{}`: the file is read-only: make it writable or choose another path", path.display())]
    ReadOnly {
        /// The path as given.
        path: PathBuf,
    },
    /// The system refused.
    #[error("cannot {action} `{}`: {source}", path.display())]
    Io {
        /// What was tried.
        action: &'static str,
        /// Where.
        path: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// A metadata pair that the formats cannot hold.
    #[error("metadata `{key}` cannot be stored: {reason}")]
    Metadata {
        /// The pair's key.
        key: String,
        /// The rule it breaks.
        reason: &'static str,
    },
    /// The exposure is no number or out of range.
    #[error(
        "an exposure of {stops} stops is out of range: choose one from {} to {MAX_EXPOSURE_STOPS}",
        -MAX_EXPOSURE_STOPS
    )]
    Exposure {
        /// The exposure as given, in stops.
        stops: f32,
    },
    /// The encoder refused the picture.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
}

/// Why a picture was not read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The system refused.
    #[error("cannot read `{}`: {source}", path.display())]
    Io {
        /// Where.
        path: PathBuf,
        /// The system's answer.
        source: io::Error,
    },
    /// The first bytes are not those of PNG, OpenEXR or Radiance HDR.
    #[error("`{}` is not a PNG, OpenEXR or Radiance HDR picture: convert it to one of these", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file is damaged, cut short, or of a kind that is not supported.
    #[error("cannot decode `{}`: {reason}", path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong and, where known, the remedy.
        reason: String,
    },
    /// The file states a size that cannot be used.
    #[error("cannot decode `{}`: {source}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// What is wrong with the size.
        source: SizeError,
    },
    /// The picture takes more memory than there is.
    #[error(
        "`{}` takes {:.1} MB of memory, and {:.1} MB are free: make the picture smaller, or let it have more (--memory)",
        path.display(), *needed as f64 * 1e-6, *free as f64 * 1e-6
    )]
    Memory {
        /// The file.
        path: PathBuf,
        /// Bytes that it takes, with what reading it takes.
        needed: u64,
        /// Bytes that it may take.
        free: u64,
    },
}

/// A decoder's failure, before the path is known.
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
    pub(super) fn at(self, path: PathBuf) -> ReadError {
        match self {
            Self::Reason(reason) => ReadError::Decode { path, reason },
            Self::Size(source) => ReadError::Size { path, source },
            Self::Memory { needed, free } => ReadError::Memory { path, needed, free },
        }
    }
}

/// DEFLATE expands a byte to at most 1032 (258 bytes for two bits, zlib technical details), so a smaller file cannot hold
/// `raw` bytes; memory is not taken on the word of a header alone.
pub(super) fn check_plausible(raw: u64, file: usize) -> Result<(), DecodeFailure> {
    if raw > 1032 * file as u64 {
        return Err(DecodeFailure::Reason("the file is too short for the size that it states".into()));
    }
    Ok(())
}

/// Bytes a pixel while a picture is read and made a texture or an environment. At most: an OpenEXR's four channels twice in single
/// precision (32), their colours (12), and what is kept of them (4 more of slack); later the picture with its pyramid (12 + 16), or with
/// the tables that its light is drawn from (12 + 24).
const PER_PIXEL: u64 = 48;

/// Checks that a picture may take the memory that it will, before it takes any.
pub(super) fn check_room(pixels: usize, free: Option<u64>) -> Result<(), DecodeFailure> {
    let needed = PER_PIXEL * pixels as u64;
    match free {
        Some(free) if needed > free => Err(DecodeFailure::Memory { needed, free }),
        _ => Ok(()),
    }
}
