//! Helpers for HTML: escaped text, inline pictures and table cells.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Escapes `text` for the content of HTML elements and double-quoted attributes.
pub(super) fn escape_html(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // Control characters are errors in HTML, but file names may contain them.
            c if c.is_control() && c != '\n' => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Makes an HTML image element that contains the bytes of a PNG.
///
/// (`width`, `height`) is its size on the page \[px]. `words` is its alternative text.
pub(super) fn inline_png(png: &[u8], (width, height): (u32, u32), words: &str) -> String {
    let data = STANDARD.encode(png);
    let words = escape_html(words);
    format!("<img src=\"data:image/png;base64,{data}\" width=\"{width}\" height=\"{height}\" alt=\"{words}\"/>")
}

/// Returns HTML table cells that hold numbers; escapes their text.
pub(super) fn number_cells_html(cells: &[String]) -> String {
    cells.iter().map(|cell| format!("<td class=\"n\">{}</td>", escape_html(cell))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn html_markup_is_escaped() {
        assert_eq!(escape_html("a<b & \"c\">\u{7}é\n"), "a&lt;b &amp; &quot;c&quot;&gt;\u{fffd}é\n");
    }

    #[test]
    fn inline_pictures_are_data_urls() {
        let image = inline_png(b"\x89PNG", (2, 1), "a \"b\"");
        assert_eq!(
            image,
            "<img src=\"data:image/png;base64,iVBORw==\" width=\"2\" height=\"1\" alt=\"a &quot;b&quot;\"/>"
        );
    }
}
