//! Checks of words and numbers that several parts of the language share.

use glam::DVec3;

/// True if `v` can be normalised: its squared length neither vanishes nor overflows.
pub(super) fn is_normalizable(v: DVec3) -> bool {
    v.length_squared().is_normal()
}

/// True if a name needs no quotes.
pub(super) fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || b"_-.".contains(&b))
}

/// True if `word` is a number that is not finite.
pub(super) fn is_nonfinite_number(word: &str) -> bool {
    ["nan", "inf", "infinity"].contains(&word.to_ascii_lowercase().as_str())
}

/// Returns at most 40 characters of `text` for a message, with control characters escaped.
pub(super) fn clip_for_message(text: &str) -> String {
    let start: String = text.chars().take(40).collect();
    let more = if start.len() < text.len() { "…" } else { "" };
    let words: Vec<&str> = start.split_whitespace().collect();
    let escape = |c: char| if c.is_control() { c.escape_unicode().to_string() } else { c.to_string() };
    words.join(" ").chars().map(escape).collect::<String>() + more
}
