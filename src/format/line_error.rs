//! Helpers of all file readers: errors with a line number, excerpts of bad input, byte order mark.

use std::path::{Path, PathBuf};

/// Text that describes a defect in a file, and advice on how to correct the defect.
pub(in crate::format) type MessageAndRemedy = (String, &'static str);

/// Error in one line of an input file.
#[derive(Debug, thiserror::Error)]
#[error("{}:{line}: {message}: {remedy}", path.display())]
pub struct LineError {
    /// Path of the input file.
    pub path: PathBuf,
    /// Line number, from 1.
    pub line: usize,
    /// Description of the defect.
    pub message: String,
    /// Advice on how to correct the line.
    pub remedy: &'static str,
}

impl LineError {
    pub(in crate::format) fn new(path: &Path, line: usize, (message, remedy): MessageAndRemedy) -> Self {
        Self { path: path.into(), line, message, remedy }
    }
}

/// Returns `word` with control characters, quotes and backslashes escaped, cut to 40 characters.
pub(in crate::format) fn escaped_excerpt(word: &str) -> String {
    word.escape_debug().take(40).collect()
}

/// Returns `bytes` without a leading UTF-8 byte order mark, which some editors write.
pub(in crate::format) fn strip_byte_order_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excerpts_are_short_and_escaped() {
        assert_eq!(escaped_excerpt("a\u{7}b"), "a\\u{7}b");
        assert_eq!(escaped_excerpt(&"x".repeat(100)).len(), 40);
    }

    #[test]
    fn only_a_leading_byte_order_mark_is_removed() {
        assert_eq!(strip_byte_order_mark(b"\xef\xbb\xbfply"), b"ply");
        assert_eq!(strip_byte_order_mark(b"p\xef\xbb\xbf"), b"p\xef\xbb\xbf");
    }
}
