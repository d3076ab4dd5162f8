//! Errors of a scene file, each with its position in the text and a remedy.

use std::fmt::{Debug, Display, Formatter};
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use super::span::Span;

/// Greatest number of errors of one scene file that are reported at once.
pub(super) const MAX_REPORTED_ERRORS: usize = 20;

/// Greatest number of bytes of the scene text that a message shows on either side of an error.
/// Without this limit, a message could show a whole file that is one long line.
const CONTEXT_BYTES: usize = 200;
/// Greatest number of bytes that an error message underlines.
const MAX_UNDERLINED_BYTES: usize = 80;

/// Name and text of a scene file; cheap to clone.
#[derive(Clone, Debug)]
pub struct SourceText {
    file_name: Arc<str>,
    text: Arc<str>,
}

impl SourceText {
    /// Makes a source from the `text` that was read from the file `name`.
    #[must_use]
    pub fn new(name: &str, text: &str) -> Self {
        Self { file_name: name.into(), text: text.into() }
    }

    /// Returns the name of the scene file.
    #[must_use]
    pub fn file_name(&self) -> &str {
        &self.file_name
    }

    /// Returns the text of the scene file.
    #[must_use]
    pub fn scene_text(&self) -> &str {
        &self.text
    }

    /// Returns a one-line warning: file name, line and column of `span`, then `message`. Line and
    /// column are left out if the text of the scene file is empty.
    pub(super) fn warning_at_span(&self, span: Span, message: &str) -> String {
        if self.text.is_empty() {
            return format!("{}: warning: {message}", self.file_name);
        }
        let (line, column) = self.zero_based_line_column(span.start.min(self.text.len()));
        format!("{}:{}:{}: warning: {message}", self.file_name, line + 1, column + 1)
    }

    /// Returns line and column, both from 0, of the byte at offset `at`. Columns count characters.
    fn zero_based_line_column(&self, at: usize) -> (usize, usize) {
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
            let window = text.ceil_char_boundary(from.saturating_sub(CONTEXT_BYTES));
            text[window..from].rmatch_indices('\n').nth(lines_before).map_or(window, |(i, _)| window + i + 1)
        };
        let window = text.floor_char_boundary(to.saturating_add(CONTEXT_BYTES));
        let end = text[to..window].match_indices('\n').nth(lines_after).map_or(window, |(i, _)| to + i);
        let (line, column) = self.zero_based_line_column(start);
        let shown = SourceSpan::from(start..end);
        let name = self.file_name.to_string();
        Ok(Box::new(MietteSpanContents::new_named(name, &text.as_bytes()[start..end], shown, line, column, 1)))
    }
}

/// Error of a scene file: defect, position and remedy.
///
/// It may carry further errors of the same file. `Display` gives `file:line:column: message`, or
/// `file: message` for an error without a position. [`miette`] adds the offending text, the remedy
/// and the further errors.
///
/// ```
/// let error = caustica::format::parse("a.txt", "Group {\n  Spere { }\n}").unwrap_err();
/// assert_eq!(error.to_string(), "a.txt:2:3: unexpected `Spere` in `Group`");
/// assert_eq!(error.remedy(), "did you mean `Sphere`?");
/// ```
#[derive(Clone, Debug, thiserror::Error)]
pub struct SceneError(Box<SceneErrorData>);

impl Display for SceneError {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let SceneErrorData { source, line, column, message, .. } = &*self.0;
        match line {
            0 => write!(f, "{}: {message}", source.file_name),
            _ => write!(f, "{}:{line}:{column}: {message}", source.file_name),
        }
    }
}

#[derive(Clone, Debug)]
struct SceneErrorData {
    source: SourceText,
    span: Span,
    /// Copy of the scene text with the control characters near the error escaped, and the error's
    /// span in this copy; `None` if there is nothing to escape.
    escaped_source: Option<(SourceText, Span)>,
    message: String,
    label: Option<String>,
    help: String,
    line: usize,
    column: usize,
    /// True if the scene is valid but exceeds the memory limit.
    is_out_of_memory: bool,
    further_errors: Vec<SceneError>,
}

impl SceneError {
    /// Returns an error at `span`.
    ///
    /// `message` describes the defect, `label` is printed under the text of the span, and `help` is
    /// the remedy.
    #[must_use]
    pub fn error_at_span(
        source: &SourceText,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self::new(source, span, message.into(), Some(label.into()), help.into())
    }

    /// Returns an error that concerns the whole file. Its position is the first character.
    #[must_use]
    pub fn error_for_whole_file(source: &SourceText, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::new(source, Span::default(), message.into(), None, help.into())
    }

    /// Returns an error that names the `file`, but no line and column.
    #[must_use]
    pub fn error_without_position(file: &str, message: impl Into<String>, help: impl Into<String>) -> Self {
        let mut error = Self::error_for_whole_file(&SourceText::new(file, ""), message, help);
        (error.0.line, error.0.column) = (0, 0);
        error
    }

    /// Sorts `errors` by position and returns the first, which carries the others as further
    /// errors.
    ///
    /// Returns `None` if `errors` is empty. Keeps at most 20 errors. None of `errors` may carry
    /// further errors of its own.
    #[must_use]
    pub fn from_errors(mut errors: Vec<Self>) -> Option<Self> {
        errors.sort_by_key(|error| error.0.span.start);
        errors.truncate(MAX_REPORTED_ERRORS);
        let mut errors = errors.into_iter();
        let mut first = errors.next()?;
        first.0.further_errors.extend(errors);
        Some(first)
    }

    /// Returns the further errors of the file, in the order of the text.
    #[must_use]
    pub fn further_errors(&self) -> &[Self] {
        &self.0.further_errors
    }

    fn new(source: &SourceText, span: Span, message: String, label: Option<String>, help: String) -> Self {
        // Clamp the span to its first line and to the text: an importer may pass any span.
        let text = source.scene_text();
        let start = text.floor_char_boundary(span.start.min(text.len()));
        let most = span.len.min(MAX_UNDERLINED_BYTES);
        let mut end = text.floor_char_boundary(start.saturating_add(most).min(text.len())).max(start);
        if let Some(i) = text[start..end].find(['\n', '\r']) {
            end = start + i;
        }
        let (line, column) = source.zero_based_line_column(start);
        let span = Span { start, len: end - start };
        let (source, escaped_source) = (source.clone(), escape_near_span(source, span));
        let (line, column, is_out_of_memory, further_errors) = (line + 1, column + 1, false, Vec::new());
        Self(Box::new(SceneErrorData {
            source,
            span,
            escaped_source,
            message,
            label,
            help,
            line,
            column,
            is_out_of_memory,
            further_errors,
        }))
    }

    /// Marks the error as caused by lack of memory: the scene is valid but exceeds the memory
    /// limit.
    #[must_use]
    pub fn marked_out_of_memory(mut self) -> Self {
        self.0.is_out_of_memory = true;
        self
    }

    /// True if the scene is valid but exceeds the memory limit.
    #[must_use]
    pub fn is_out_of_memory(&self) -> bool {
        self.0.is_out_of_memory
    }

    /// Returns the description of the defect, without its position.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// Returns advice on how to correct the defect.
    #[must_use]
    pub fn remedy(&self) -> &str {
        &self.0.help
    }

    /// Returns the name of the scene file.
    #[must_use]
    pub fn file_name(&self) -> &str {
        self.0.source.file_name()
    }

    /// Returns the text at the error's position: at most 80 bytes of one line. Empty if the error
    /// concerns the whole file or has no position.
    #[must_use]
    pub fn offending_text(&self) -> &str {
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
        Some(self.0.escaped_source.as_ref().map_or(&self.0.source, |(source, _)| source))
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = self.0.label.clone()?;
        let span = self.0.escaped_source.as_ref().map_or(self.0.span, |(_, span)| *span);
        let span = SourceSpan::from((span.start, span.len));
        Some(Box::new(std::iter::once(LabeledSpan::new_primary_with_span(Some(label), span))))
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let others = &self.0.further_errors;
        (!others.is_empty()).then(|| Box::new(others.iter().map(|e| e as &dyn Diagnostic)) as Box<_>)
    }
}

/// Returns a copy of the text with control characters near `span` escaped, and the span in the
/// copy.
///
/// Escaping keeps a terminal from obeying the control characters. Line ends and tabs stay.
/// Returns `None` if there is nothing to escape.
fn escape_near_span(source: &SourceText, span: Span) -> Option<(SourceText, Span)> {
    let text = source.scene_text();
    let is_unsafe = |c: char| c.is_control() && !['\n', '\r', '\t'].contains(&c);
    let from = text.floor_char_boundary(span.start.saturating_sub(CONTEXT_BYTES));
    let to = text.ceil_char_boundary((span.start + span.len).saturating_add(CONTEXT_BYTES).min(text.len()));
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
    Some((SourceText::new(source.file_name(), &text), span))
}

#[cfg(test)]
mod tests;
