//! Errors of a scene file, with position and remedy.

use std::fmt::{Debug, Display, Formatter};
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use super::description::Span;

/// Greatest number of errors that are reported at once.
pub(super) const MAX_ERRORS: usize = 20;

/// Bytes shown on either side of an error, at most: a file may be one long line.
const WINDOW: usize = 200;
/// Bytes underlined, at most.
const UNDERLINED: usize = 80;

/// Text of a scene file with the file's name; cheap to clone.
#[derive(Clone, Debug)]
pub struct SourceText {
    name: Arc<str>,
    text: Arc<str>,
}

impl SourceText {
    /// A source of `text`, as read from the file `name`.
    #[must_use]
    pub fn new(name: &str, text: &str) -> Self {
        Self { name: name.into(), text: text.into() }
    }

    /// Returns the file's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the file's text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns `message` as a warning at `span`, in one line; without a position if there is no
    /// text.
    pub(super) fn warning(&self, span: Span, message: &str) -> String {
        if self.text.is_empty() {
            return format!("{}: warning: {message}", self.name);
        }
        let (line, column) = self.line_and_column(span.start.min(self.text.len()));
        format!("{}:{}:{}: warning: {message}", self.name, line + 1, column + 1)
    }

    /// Returns line and column of the byte `at`, both from 0; columns count characters.
    fn line_and_column(&self, at: usize) -> (usize, usize) {
        let before = &self.text[..self.text.floor_char_boundary(at)];
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.bytes().filter(|&b| b == b'\n').count(), before[start..].chars().count())
    }
}

impl SourceCode for SourceText {
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
        let (line, column) = self.line_and_column(start);
        let shown = SourceSpan::from(start..end);
        let name = self.name.to_string();
        Ok(Box::new(MietteSpanContents::new_named(name, &text.as_bytes()[start..end], shown, line, column, 1)))
    }
}

/// Error of a scene file: defect, position and remedy. It may carry further errors of the
/// same file.
///
/// `Display` gives `file:line:column: message`, without the numbers if the error has no position;
/// [`miette`] adds the offending text, the remedy and the further errors.
///
/// ```
/// let error = caustica::format::parse("a.txt", "Group {\n  Spere { }\n}").unwrap_err();
/// assert_eq!(error.to_string(), "a.txt:2:3: unexpected `Spere` in `Group`");
/// assert_eq!(error.remedy(), "did you mean `Sphere`?");
/// ```
#[derive(Clone, Debug, thiserror::Error)]
pub struct SceneError(Box<Parts>);

impl Display for SceneError {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let Parts { source, line, column, message, .. } = &*self.0;
        match line {
            0 => write!(f, "{}: {message}", source.name),
            _ => write!(f, "{}:{line}:{column}: {message}", source.name),
        }
    }
}

#[derive(Clone, Debug)]
struct Parts {
    source: SourceText,
    span: Span,
    /// Text and span with control characters escaped, if there are any near the span.
    escaped: Option<(SourceText, Span)>,
    message: String,
    label: Option<String>,
    help: String,
    line: usize,
    column: usize,
    exhausts: bool,
    others: Vec<SceneError>,
}

impl SceneError {
    /// An error at `span`: `message` describes the defect, `label` stands under the text, `help` is
    /// the remedy.
    #[must_use]
    pub fn at(
        source: &SourceText,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self::new(source, span, message.into(), Some(label.into()), help.into())
    }

    /// An error of the file as a whole, at its first character.
    #[must_use]
    pub fn of_file(source: &SourceText, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::new(source, Span::default(), message.into(), None, help.into())
    }

    /// An error of an imported file without a position in a text.
    #[must_use]
    pub fn without_position(file: &str, message: impl Into<String>, help: impl Into<String>) -> Self {
        let mut error = Self::of_file(&SourceText::new(file, ""), message, help);
        (error.0.line, error.0.column) = (0, 0);
        error
    }

    /// Returns `errors` as one error in the order of the text, with the others as further errors;
    /// `None` if empty.
    ///
    /// At most 20 are kept. Errors must not carry further errors already.
    #[must_use]
    pub fn join(mut errors: Vec<Self>) -> Option<Self> {
        errors.sort_by_key(|error| error.0.span.start);
        errors.truncate(MAX_ERRORS);
        let mut errors = errors.into_iter();
        let mut first = errors.next()?;
        first.0.others.extend(errors);
        Some(first)
    }

    /// Returns the further errors of the file, in the order of the text.
    #[must_use]
    pub fn others(&self) -> &[Self] {
        &self.0.others
    }

    fn new(source: &SourceText, span: Span, message: String, label: Option<String>, help: String) -> Self {
        // Underline within the line and the text only, wherever the span came from.
        let text = source.text();
        let start = text.floor_char_boundary(span.start.min(text.len()));
        let most = span.len.min(UNDERLINED);
        let mut end = text.floor_char_boundary(start.saturating_add(most).min(text.len())).max(start);
        if let Some(i) = text[start..end].find(['\n', '\r']) {
            end = start + i;
        }
        let (line, column) = source.line_and_column(start);
        let span = Span { start, len: end - start };
        let (source, escaped) = (source.clone(), escape(source, span));
        let (line, column, exhausts, others) = (line + 1, column + 1, false, Vec::new());
        Self(Box::new(Parts { source, span, escaped, message, label, help, line, column, exhausts, others }))
    }

    /// The error, marked as one of a valid scene that exceeds the memory limit.
    #[must_use]
    pub fn marked_out_of_memory(mut self) -> Self {
        self.0.exhausts = true;
        self
    }

    /// True if the scene is valid but exceeds the memory limit.
    #[must_use]
    pub fn is_out_of_memory(&self) -> bool {
        self.0.exhausts
    }

    /// Returns the description of the error, without its position.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// Returns the remedy.
    #[must_use]
    pub fn remedy(&self) -> &str {
        &self.0.help
    }

    /// Returns the file's name.
    #[must_use]
    pub fn file(&self) -> &str {
        self.0.source.name()
    }

    /// Returns the offending text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0.source.text[self.0.span.start..][..self.0.span.len]
    }

    /// Returns the line, from 1; 0 if the error has no position.
    #[must_use]
    pub fn line(&self) -> usize {
        self.0.line
    }

    /// Returns the column in characters, from 1; 0 if the error has no position.
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
        Some(self.0.escaped.as_ref().map_or(&self.0.source, |(source, _)| source))
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = self.0.label.clone()?;
        let span = self.0.escaped.as_ref().map_or(self.0.span, |(_, span)| *span);
        let span = SourceSpan::from((span.start, span.len));
        Some(Box::new(std::iter::once(LabeledSpan::new_primary_with_span(Some(label), span))))
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let others = &self.0.others;
        (!others.is_empty()).then(|| Box::new(others.iter().map(|e| e as &dyn Diagnostic)) as Box<_>)
    }
}

/// Returns the text with control characters escaped, and the span in it, if there are such
/// characters near the span.
///
/// A terminal must not obey what a scene file holds.
fn escape(source: &SourceText, span: Span) -> Option<(SourceText, Span)> {
    let text = source.text();
    let is_unsafe = |c: char| c.is_control() && !['\n', '\r', '\t'].contains(&c);
    let from = text.floor_char_boundary(span.start.saturating_sub(WINDOW));
    let to = text.ceil_char_boundary((span.start + span.len).saturating_add(WINDOW).min(text.len()));
    if !text[from..to].contains(is_unsafe) {
        return None;
    }
    let escape = |part: &str| -> String {
        part.chars().map(|c| if is_unsafe(c) { c.escape_unicode().to_string() } else { c.to_string() }).collect()
    };
    let end = span.start + span.len;
    let (before, inside, after) =
        (escape(&text[from..span.start]), escape(&text[span.start..end]), escape(&text[end..to]));
    let span = Span { start: from + before.len(), len: inside.len() };
    let text = format!("{}{before}{inside}{after}{}", &text[..from], &text[to..]);
    Some((SourceText::new(source.name(), &text), span))
}

#[cfg(test)]
mod tests;
