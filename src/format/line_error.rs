//! Helpers that the file readers share: messages about bad input, and the byte order mark.

use std::path::{Path, PathBuf};

/// Description of the defect in a file, and a remedy.
pub(in crate::format) type MessageAndRemedy = (String, &'static str);

/// Line of an input file that cannot be understood.
#[derive(Debug, thiserror::Error)]
#[error("{}:{line}: {message}: {remedy}", path.display())]
pub struct LineError {
    /// Path of the file.
    pub path: PathBuf,
    /// Line number, from 1.
    pub line: usize,
    /// Description of the defect.
    pub message: String,
    /// Remedy.
    pub remedy: &'static str,
}

impl LineError {
    pub(in crate::format) fn new(path: &Path, line: usize, (message, remedy): MessageAndRemedy) -> Self {
        Self { path: path.into(), line, message, remedy }
    }
}

/// `word` with control characters escaped, cut to 40 characters for an error message.
pub(in crate::format) fn escaped_excerpt(word: &str) -> String {
    word.escape_debug().take(40).collect()
}

/// `bytes` without the UTF-8 byte order mark that some editors write at the start of a text file.
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
    fn only_a_leading_mark_is_removed() {
        assert_eq!(strip_byte_order_mark(b"\xef\xbb\xbfply"), b"ply");
        assert_eq!(strip_byte_order_mark(b"p\xef\xbb\xbf"), b"p\xef\xbb\xbf");
    }
}
