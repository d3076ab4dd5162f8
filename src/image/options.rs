//! Options of writing pictures: tone curve, bits per channel and metadata.

use super::error::WriteError;
use super::tone::ToneMap;

/// Bits per channel of a PNG file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BitDepth {
    /// 8 bits per channel: 256 levels.
    #[default]
    Eight,
    /// 16 bits per channel: 65,536 levels.
    Sixteen,
}

/// Floating-point precision of the channels of an OpenEXR file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExrPrecision {
    /// 16 bits: half precision, with 11 significant bits, up to 65504.
    Half,
    /// 32 bits: single precision.
    #[default]
    Single,
}

/// Options of [`write`](fn@super::write).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// Exposure and tone curve of PNG files. OpenEXR files hold linear radiance.
    pub tone: ToneMap,
    /// Bits per channel of PNG files, 8 or 16.
    pub bit_depth: BitDepth,
    /// Floating-point precision of OpenEXR files.
    pub exr_precision: ExrPrecision,
    /// Metadata of the file: pairs of key and text.
    ///
    /// PNG stores them as text chunks, OpenEXR as lines `key: text` of the attribute `comments`. A
    /// key has 1 to 79 printable ASCII characters, without leading, trailing or repeated spaces. A
    /// text has no NUL character.
    pub metadata: Vec<(String, String)>,
}

/// Checks that metadata keys follow the rules of PNG keywords, restricted to ASCII (ISO/IEC 15948,
/// 11.3.4.2).
///
/// The rules also apply to OpenEXR, so both formats accept the same metadata.
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
