//! Splits scene text into words, numbers and strings, each with its position.

use crate::format::error::{SceneError, SourceText};
use crate::format::span::{Span, Spanned};

/// Token of scene text: a word, a number or one of `{ } [ ] "`.
///
/// The token is empty at the end of the scene text. It is also empty if the parser asked for a
/// number and none follows.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct Token<'a> {
    pub text: &'a str,
    /// Offset of the token in the scene text \[bytes].
    pub start: usize,
}

impl Token<'_> {
    pub fn span(&self) -> Span {
        Span { start: self.start, len: self.text.len() }
    }

    pub fn is_empty(&self) -> bool {
        self.text.is_empty()
    }
}

/// Lexer of scene text. The length of a token depends on its type, for which the parser asks.
///
/// For example, `20width` starts with the number `20`, but the whole of it is one word.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct Lexer<'a> {
    file_name: &'a str,
    text: &'a str,
    /// Offset of the next unread byte in `text`.
    position: usize,
}

impl<'a> Lexer<'a> {
    /// Returns a lexer at the start of `text`, after its byte order mark if it has one.
    pub fn new(name: &'a str, text: &'a str) -> Self {
        let position = if text.starts_with('\u{feff}') { 3 } else { 0 };
        Self { file_name: name, text, position }
    }

    pub fn source_text(&self) -> SourceText {
        SourceText::new(self.file_name, self.text)
    }

    pub fn text_of_span(&self, span: Span) -> &'a str {
        &self.text[span.start..span.start + span.len]
    }

    pub fn error_at(&self, span: Span, message: String, label: &str, help: String) -> SceneError {
        SceneError::error_at_span(&self.source_text(), span, message, label, help)
    }

    /// Returns the next word or punctuation mark without consuming it.
    pub fn peek_token(&mut self) -> Token<'a> {
        self.skip_space_and_comments();
        let rest = &self.text[self.position..];
        let len = match rest.bytes().next() {
            Some(b'{' | b'}' | b'[' | b']' | b'"') => 1,
            _ => rest.bytes().position(|b| is_white_space(b) || b"{}[]\"".contains(&b)).unwrap_or(rest.len()),
        };
        Token { text: &rest[..len], start: self.position }
    }

    /// Moves past `token`, which was peeked before.
    pub fn consume_token(&mut self, token: Token<'_>) {
        self.position = token.start + token.text.len();
    }

    /// Moves back to the start of `token`, which was consumed before.
    pub fn rewind_to_token(&mut self, token: Token<'_>) {
        self.position = token.start;
    }

    /// Reads the longest decimal number at the current position; empty if no number starts there.
    pub fn read_number_token(&mut self) -> Token<'a> {
        self.skip_space_and_comments();
        self.read_token_of_length(float_prefix_length)
    }

    /// Reads the longest whole number at the current position; empty if no number starts there.
    pub fn read_integer_token(&mut self) -> Token<'a> {
        self.skip_space_and_comments();
        self.read_token_of_length(integer_prefix_length)
    }

    /// Reads a token at the current position and moves past it.
    ///
    /// `length` receives all unread bytes, and returns how many of them form the token.
    fn read_token_of_length(&mut self, length: fn(&[u8]) -> usize) -> Token<'a> {
        let rest = &self.text[self.position..];
        let token = Token { text: &rest[..length(rest.as_bytes())], start: self.position };
        self.consume_token(token);
        token
    }

    /// Reads a name, in quotes or bare, and returns it without quotes.
    ///
    /// A bare name ends at white space, or at a `}` that has no matching `{` in the name. If no
    /// name follows, the result is empty.
    pub fn read_name(&mut self) -> Result<Spanned<String>, SceneError> {
        self.skip_space_and_comments();
        let rest = &self.text[self.position..];
        if rest.starts_with('"') {
            return self.read_quoted_string();
        }
        let mut open_braces = 0_usize;
        let mut len = rest.len();
        for (i, b) in rest.bytes().enumerate() {
            if is_white_space(b) || (b == b'}' && open_braces == 0) {
                len = i;
                break;
            }
            match b {
                b'{' => open_braces += 1,
                b'}' => open_braces -= 1,
                _ => {}
            }
        }
        let span = Span { start: self.position, len };
        self.position += len;
        Ok(Spanned::new(rest[..len].to_owned(), span))
    }

    /// Reads a string in quotes, which must end on its line, and returns its content.
    ///
    /// Inside the quotes, `\"` stands for a quote and `\\` for a backslash.
    pub fn read_quoted_string(&mut self) -> Result<Spanned<String>, SceneError> {
        let start = self.position;
        let mut value = String::new();
        let mut chars = self.text[start..].char_indices().skip(1);
        loop {
            match chars.next() {
                Some((i, '"')) => {
                    self.position = start + i + 1;
                    return Ok(Spanned::new(value, Span { start, len: i + 1 }));
                }
                Some((i, '\\')) => match chars.next() {
                    Some((_, c @ ('"' | '\\'))) => value.push(c),
                    _ => {
                        let span = Span { start: start + i, len: 1 };
                        let help = "write `\\\\` for a backslash and `\\\"` for a quote, or `/` between folders";
                        let message = "a backslash in quotes stands only before `\"` or `\\`".to_owned();
                        return Err(self.error_at(span, message, "this one", help.to_owned()));
                    }
                },
                None | Some((_, '\n' | '\r')) => {
                    let message = "the string does not end on its line".to_owned();
                    let help = "close it with `\"`".to_owned();
                    return Err(self.error_at(Span { start, len: 1 }, message, "opened here", help));
                }
                Some((_, c)) => value.push(c),
            }
        }
    }

    /// Skips white space and comments.
    fn skip_space_and_comments(&mut self) {
        let bytes = self.text.as_bytes();
        while let Some(&b) = bytes.get(self.position) {
            if is_white_space(b) {
                self.position += 1;
            } else if b == b'#' || bytes[self.position..].starts_with(b"//") {
                self.position = self.text[self.position..].find('\n').map_or(bytes.len(), |i| self.position + i);
            } else {
                break;
            }
        }
    }
}

/// True if `b` is a space, tab, line feed, vertical tab, form feed or carriage return.
fn is_white_space(b: u8) -> bool {
    matches!(b, b' ' | b'\t'..=b'\r')
}

/// Returns the number of digits at the start of `bytes`.
fn digit_prefix_length(bytes: &[u8]) -> usize {
    bytes.iter().take_while(|b| b.is_ascii_digit()).count()
}

/// Returns 1 if `bytes` start with a sign, else 0.
fn sign_prefix_length(bytes: &[u8]) -> usize {
    usize::from(matches!(bytes.first(), Some(b'+' | b'-')))
}

/// Returns the length of the whole number at the start of `bytes`; 0 if there is none.
fn integer_prefix_length(bytes: &[u8]) -> usize {
    let sign = sign_prefix_length(bytes);
    match digit_prefix_length(&bytes[sign..]) {
        0 => 0,
        n => sign + n,
    }
}

/// Returns the length of the decimal number at the start of `bytes`; 0 if there is none.
fn float_prefix_length(bytes: &[u8]) -> usize {
    let mut len = sign_prefix_length(bytes);
    let whole = digit_prefix_length(&bytes[len..]);
    len += whole;
    let mut fraction = 0;
    if bytes.get(len) == Some(&b'.') {
        fraction = digit_prefix_length(&bytes[len + 1..]);
        if whole + fraction > 0 {
            len += 1 + fraction;
        }
    }
    if whole + fraction == 0 {
        return 0;
    }
    if matches!(bytes.get(len), Some(b'e' | b'E')) {
        match integer_prefix_length(&bytes[len + 1..]) {
            0 => {}
            exponent => len += 1 + exponent,
        }
    }
    len
}

#[cfg(test)]
mod tests;
