//! Splits pbrt's text format into tokens: words, numbers, quoted texts and brackets.

use super::files::{PbrtSourceLocation, ReadResult};
use std::borrow::Cow;
use std::rc::Rc;

/// A token of a pbrt file, with its line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PbrtToken<'t> {
    /// Kind of the token, with its text.
    pub kind: TokenKind<'t>,
    /// Line of the token, from 1.
    pub line: u32,
}

/// Kind of a token, with its text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum TokenKind<'t> {
    /// A word without quotes: a directive, a number or a truth value.
    Unquoted(&'t str),
    /// Content of a text in quotes, without the quotes.
    Quoted(Cow<'t, str>),
    /// An opening bracket.
    OpenBracket,
    /// A closing bracket.
    CloseBracket,
}

/// Reader of the tokens of one pbrt file.
pub(super) struct Tokenizer<'t> {
    text: &'t str,
    /// Position in `text` of the next byte to read.
    byte_offset: usize,
    /// Line of the byte at `byte_offset`, from 1.
    line: u32,
    file: Rc<str>,
    /// Token that was read ahead by `peek_token`.
    peeked: Option<PbrtToken<'t>>,
}

impl<'t> Tokenizer<'t> {
    /// Starts reading the tokens of `text`. Errors name `file`.
    pub fn new(text: &'t str, file: Rc<str>) -> Self {
        Self { text, byte_offset: 0, line: 1, file, peeked: None }
    }

    /// Returns the position of `line` in this file, for messages.
    pub fn place(&self, line: u32) -> PbrtSourceLocation {
        PbrtSourceLocation { file: Rc::clone(&self.file), line }
    }

    /// Returns the next token and moves past it; `None` at the end of the file.
    pub fn next_token(&mut self) -> ReadResult<Option<PbrtToken<'t>>> {
        if let Some(token) = self.peeked.take() {
            return Ok(Some(token));
        }
        self.read_token()
    }

    /// Returns the next token without moving past it; `None` at the end of the file.
    pub fn peek_token(&mut self) -> ReadResult<Option<&PbrtToken<'t>>> {
        if self.peeked.is_none() {
            self.peeked = self.read_token()?;
        }
        Ok(self.peeked.as_ref())
    }

    fn read_token(&mut self) -> ReadResult<Option<PbrtToken<'t>>> {
        self.skip_blanks();
        let line = self.line;
        let rest = &self.text[self.byte_offset..];
        let Some(first) = rest.bytes().next() else { return Ok(None) };
        let kind = match first {
            b'[' => {
                self.byte_offset += 1;
                TokenKind::OpenBracket
            }
            b']' => {
                self.byte_offset += 1;
                TokenKind::CloseBracket
            }
            b'"' => TokenKind::Quoted(self.read_quoted_text(&rest[1..])?),
            _ => {
                let ends = |c: u8| c.is_ascii_whitespace() || matches!(c, b'"' | b'[' | b']' | b'#');
                let length = rest.bytes().position(ends).unwrap_or(rest.len());
                self.byte_offset += length;
                TokenKind::Unquoted(&rest[..length])
            }
        };
        Ok(Some(PbrtToken { kind, line }))
    }

    /// Skips white space and comments.
    fn skip_blanks(&mut self) {
        let bytes = self.text.as_bytes();
        while let Some(byte) = bytes.get(self.byte_offset) {
            match byte {
                b'\n' => self.line += 1,
                b'#' => {
                    let rest = &bytes[self.byte_offset..];
                    self.byte_offset += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
                    continue;
                }
                byte if byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.byte_offset += 1;
        }
    }

    /// Returns the quoted text at the start of `rest`, and moves past its closing quote.
    ///
    /// `rest` starts after the opening quote.
    fn read_quoted_text(&mut self, rest: &'t str) -> ReadResult<Cow<'t, str>> {
        let mut is_escaped = false;
        for (i, byte) in rest.bytes().enumerate() {
            match byte {
                b'\n' => break,
                b'\\' if !is_escaped => is_escaped = true,
                b'"' if !is_escaped => {
                    self.byte_offset += i + 2;
                    let text = &rest[..i];
                    return Ok(if text.contains('\\') { unescaped_text(text).into() } else { text.into() });
                }
                _ => is_escaped = false,
            }
        }
        Err(self.place(self.line).error("a text in quotes does not end on its line", "close it with `\"`"))
    }
}

/// Returns `text` with its escape sequences replaced by the characters that they stand for.
fn unescaped_text(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        let escaped = if c == '\\' { characters.next() } else { None };
        out.push(match escaped {
            Some('n') => '\n',
            Some('t') => '\t',
            Some('r') => '\r',
            Some(other) => other,
            None => c,
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn token_kinds(text: &str) -> Vec<TokenKind<'_>> {
        let mut tokens = Tokenizer::new(text, "test".into());
        std::iter::from_fn(|| tokens.next_token().unwrap().map(|token| token.kind)).collect()
    }

    #[test]
    fn comments_and_blanks_separate_tokens() {
        use TokenKind::{CloseBracket, OpenBracket, Quoted, Unquoted};
        let found = token_kinds("Shape\"a b\"[.5#x\n-1e3]#end");
        assert_eq!(
            found,
            [Unquoted("Shape"), Quoted("a b".into()), OpenBracket, Unquoted(".5"), Unquoted("-1e3"), CloseBracket]
        );
        assert_eq!(token_kinds(r#""a\"b\\c\n""#), [Quoted("a\"b\\c\n".into())]);
        assert!(token_kinds(" \r\n# only a comment").is_empty());
    }

    #[test]
    fn an_open_quote_is_an_error_with_its_line() {
        let mut tokens = Tokenizer::new("a\n\"b\n\"", "test".into());
        assert!(tokens.next_token().is_ok());
        assert!(tokens.next_token().unwrap_err().to_string().contains("line 2"));
    }
}
