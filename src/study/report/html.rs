//! What a page is made of.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Text with what HTML would take for markup escaped, for elements and for attributes in double quotes.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // Other control characters are errors in HTML, and a file's name may hold them.
            c if c.is_control() && c != '\n' => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A picture within the page, with words for those who do not see it.
pub(super) fn picture(png: &[u8], (width, height): (u32, u32), words: &str) -> String {
    let data = STANDARD.encode(png);
    let words = escape(words);
    format!("<img src=\"data:image/png;base64,{data}\" width=\"{width}\" height=\"{height}\" alt=\"{words}\"/>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_text_is_text() {
        assert_eq!(escape("a<b & \"c\">\u{7}é\n"), "a&lt;b &amp; &quot;c&quot;&gt;\u{fffd}é\n");
    }

    #[test]
    fn pictures_travel_in_base_64() {
        let image = picture(b"\x89PNG", (2, 1), "a \"b\"");
        assert_eq!(
            image,
            "<img src=\"data:image/png;base64,iVBORw==\" width=\"2\" height=\"1\" alt=\"a &quot;b&quot;\"/>"
        );
    }
}
