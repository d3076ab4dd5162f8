//! Options of writing pictures.

use super::error::WriteError;
use super::tone::ToneMap;

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

/// Options of [`write`](fn@super::write).
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

/// Checks the rules of PNG keywords (ISO/IEC 15948, 11.3.4.2), restricted to ASCII.
///
/// The rules apply to OpenEXR too, so that both formats accept the same pairs.
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
