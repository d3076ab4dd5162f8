//! Checks of words and vectors, and shortening of text for messages.

use glam::DVec3;

/// True if `v` can be normalized: its squared length neither underflows nor overflows.
pub(in crate::format) fn is_normalizable(v: DVec3) -> bool {
    v.length_squared().is_normal()
}

/// True if `name` is a letter or `_`, then letters, digits and `_`, `-` or `.`; all ASCII.
pub(in crate::format) fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-.".contains(&b))
}

/// True if `word` is "nan", "inf" or "infinity" in any case.
pub(in crate::format) fn is_nonfinite_number(word: &str) -> bool {
    ["nan", "inf", "infinity"].contains(&word.to_ascii_lowercase().as_str())
}

/// Returns at most the first 40 characters of `text` on one line, for messages. Control characters
/// are escaped, and `…` marks a cut.
pub(in crate::format) fn clip_for_message(text: &str) -> String {
    let start: String = text.chars().take(40).collect();
    let more = if start.len() < text.len() { "…" } else { "" };
    let words: Vec<&str> = start.split_whitespace().collect();
    let escape = |c: char| if c.is_control() { c.escape_unicode().to_string() } else { c.to_string() };
    words.join(" ").chars().map(escape).collect::<String>() + more
}
