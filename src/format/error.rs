//! Errors of a scene file, which show the place and the remedy.

use std::fmt::Debug;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use super::description::Span;

/// Most bytes shown on either side of an offending place, so that a file of one long line stays readable.
const WINDOW: usize = 200;
/// Most bytes underlined.
const UNDERLINED: usize = 80;

/// The text of a scene file with the name to call it by; cheap to clone.
#[derive(Clone, Debug)]
pub struct Source {
    name: Arc<str>,
    text: Arc<str>,
}

impl Source {
    /// `text` as read from the file `name`.
    #[must_use]
    pub fn new(name: &str, text: &str) -> Self {
        Self { name: name.into(), text: text.into() }
    }

    /// The file's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file's text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Line and column of the byte `at`, both from 0; columns count characters.
    fn place(&self, at: usize) -> (usize, usize) {
        let before = &self.text[..self.text.floor_char_boundary(at)];
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.bytes().filter(|&b| b == b'\n').count(), before[start..].chars().count())
    }
}

impl SourceCode for Source {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let text: &str = &self.text;
        let (from, to) = (span.offset(), span.offset() + span.len());
        if !text.is_char_boundary(from) || !text.is_char_boundary(to) {
            return Err(MietteError::OutOfBounds);
        }
        let start = if lines_before == 0 {
            from
        } else {
            let window = text.ceil_char_boundary(from.saturating_sub(WINDOW));
            text[window..from].rmatch_indices('\n').nth(lines_before).map_or(window, |(i, _)| window + i + 1)
        };
        let window = text.floor_char_boundary(to.saturating_add(WINDOW));
        let end = text[to..window].match_indices('\n').nth(lines_after).map_or(window, |(i, _)| to + i);
        let (line, column) = self.place(start);
        let shown = SourceSpan::from(start..end);
        let name = self.name.to_string();
        Ok(Box::new(MietteSpanContents::new_named(name, &text.as_bytes()[start..end], shown, line, column, 1)))
    }
}

/// What is wrong with a scene file: what, where, and what would be right.
///
/// `Display` gives `file:line:column: message`; [`miette`] adds the offending text and the remedy.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}:{}:{}: {}", .0.source.name, self.line(), self.column(), .0.message)]
pub struct SceneError(Box<Parts>);

#[derive(Clone, Debug)]
struct Parts {
    source: Source,
    span: Span,
    message: String,
    label: Option<String>,
    help: String,
    line: usize,
    column: usize,
    exhausts: bool,
}

impl SceneError {
    /// An error at a place: `message` says what is wrong, `label` stands under the text, `help` says what would be right.
    #[must_use]
    pub fn at(
        source: &Source,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self::new(source, span, message.into(), Some(label.into()), help.into())
    }

    /// An error of the file as a whole, placed at its first character.
    #[must_use]
    pub fn of_file(source: &Source, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::new(source, Span::default(), message.into(), None, help.into())
    }

    fn new(source: &Source, span: Span, message: String, label: Option<String>, help: String) -> Self {
        // Underline within the line and the text only, wherever the span came from.
        let text = source.text();
        let start = text.floor_char_boundary(span.start.min(text.len()));
        let most = span.len.min(UNDERLINED);
        let mut end = text.floor_char_boundary(start.saturating_add(most).min(text.len())).max(start);
        if let Some(i) = text[start..end].find(['\n', '\r']) {
            end = start + i;
        }
        let (line, column) = source.place(start);
        let span = Span { start, len: end - start };
        let source = source.clone();
        Self(Box::new(Parts {
            source,
            span,
            message,
            label,
            help,
            line: line + 1,
            column: column + 1,
            exhausts: false,
        }))
    }

    /// The same, of a scene that is sound but takes more memory than it may.
    #[must_use]
    pub fn exhausting(mut self) -> Self {
        self.0.exhausts = true;
        self
    }

    /// Whether the scene is sound but takes more memory than it may.
    #[must_use]
    pub fn exhausts_memory(&self) -> bool {
        self.0.exhausts
    }

    /// What is wrong, without its place.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// What would be right.
    #[must_use]
    pub fn remedy(&self) -> &str {
        &self.0.help
    }

    /// The file's name.
    #[must_use]
    pub fn file(&self) -> &str {
        self.0.source.name()
    }

    /// The offending text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0.source.text[self.0.span.start..][..self.0.span.len]
    }

    /// From 1.
    #[must_use]
    pub fn line(&self) -> usize {
        self.0.line
    }

    /// From 1, in characters.
    #[must_use]
    pub fn column(&self) -> usize {
        self.0.column
    }
}

impl Diagnostic for SceneError {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        Some(Box::new(&self.0.help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.0.source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = self.0.label.clone()?;
        let span = SourceSpan::from((self.0.span.start, self.0.span.len));
        Some(Box::new(std::iter::once(LabeledSpan::new_primary_with_span(Some(label), span))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn render(error: &SceneError) -> String {
        let mut text = String::new();
        let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::unicode_nocolor());
        handler.render_report(&mut text, error).unwrap();
        text
    }

    fn error(text: &str, start: usize, len: usize) -> SceneError {
        SceneError::at(&Source::new("a.txt", text), Span { start, len }, "no such word", "here", "write `right`")
    }

    #[test]
    fn the_report_shows_place_text_and_remedy() {
        let error = error("one\r\n  über wrong\r\nthree", 13, 5);
        assert_eq!((error.line(), error.column(), error.text()), (2, 8, "wrong"));
        assert_eq!(error.to_string(), "a.txt:2:8: no such word");
        let report = render(&error);
        for part in ["a.txt:2:8", "no such word", "über wrong", "here", "write `right`"] {
            assert!(report.contains(part), "{part} is not in\n{report}");
        }
    }

    #[test]
    fn long_lines_are_shown_in_part() {
        let error = error(&"word ".repeat(100_000), 200_000, 100_000);
        assert_eq!(error.column(), 200_001);
        let report = render(&error);
        assert!(report.len() < 3000 && report.contains("a.txt:1:200001"), "{report}");
    }

    #[test]
    fn any_span_can_be_shown() {
        for text in ["", "\n", "ü", "a\r\nb"] {
            for (start, len) in [(0, 0), (0, 9), (1, 1), (9, 9), (usize::MAX, usize::MAX)] {
                assert!(render(&error(text, start, len)).contains("write `right`"));
            }
        }
        let file = SceneError::of_file(&Source::new("a.txt", ""), "nothing here", "write something");
        assert!(render(&file).contains("a.txt:1:1: nothing here") && render(&file).contains("write something"));
    }
}
