//! Parses the elements of scene text: blocks, numbers, names and counts. Recovers from errors.

use super::lexer::{Lexer, Token};
use super::scope::ParserScope;
use super::suggest::{keyword_synonym, nearest_word};
use super::text::clip_for_message;
use crate::format::MAX_NESTING_DEPTH;
use crate::format::error::{MAX_REPORTED_ERRORS, SceneError};
use crate::format::span::{Span, Spanned};

/// Parser of a scene text: its position, and the definitions and errors so far.
pub(in crate::format) struct Parser<'a> {
    /// Lexer, which holds the scene text and the current position.
    pub lexer: Lexer<'a>,
    /// Textures, media and materials defined so far.
    pub scope: ParserScope<'a>,
    /// Errors so far, in no particular order.
    pub errors: Vec<SceneError>,
    /// Keywords of the blocks around the current position, outermost first.
    open_blocks: Vec<Token<'a>>,
    /// Number of `Group`, `Transform` and `Moving` blocks around the current position.
    nesting_depth: usize,
    /// Number of blocks parsed to their end since the start of the text.
    closed_block_count: usize,
    /// True if the text ended inside a block.
    has_unclosed_block: bool,
}

/// Counts of open and closed blocks, saved before an entry of a block is parsed.
///
/// If the entry has an error, the parser compares these counts with the current ones to find the
/// end of the entry.
#[derive(Clone, Copy)]
pub(in crate::format) struct SavedBlockNesting {
    open_block_count: usize,
    nesting_depth: usize,
    closed_block_count: usize,
}

impl<'a> Parser<'a> {
    /// Returns a parser at the start of `text`; errors call the text `name`.
    pub fn new(name: &'a str, text: &'a str) -> Self {
        Self {
            lexer: Lexer::new(name, text),
            scope: ParserScope::default(),
            errors: Vec::new(),
            open_blocks: Vec::new(),
            nesting_depth: 0,
            closed_block_count: 0,
            has_unclosed_block: false,
        }
    }

    /// Joins the recorded errors and `last` into one [`SceneError`], in the order of the text;
    /// `None` without errors.
    ///
    /// `last` is the error that stopped the parser, if any. If the text ends inside a block, `last`
    /// is probably a consequence of an earlier error. Then `last` is dropped unless it is the only
    /// error.
    pub fn into_joined_error(mut self, last: Option<SceneError>) -> Option<SceneError> {
        self.errors.extend(last.filter(|_| !self.has_unclosed_block || self.errors.is_empty()));
        SceneError::from_errors(self.errors)
    }

    /// Calls `parse_entry` to parse one entry of a block. If it fails, records the error and skips
    /// to the next entry, which starts with a word of `allowed`.
    ///
    /// # Errors
    /// The error of `parse_entry`, if the text ended inside a block or the list of errors is full.
    pub fn parse_entry_with_recovery(
        &mut self,
        allowed: &[&str],
        parse_entry: impl FnOnce(&mut Self) -> Result<(), SceneError>,
    ) -> Result<(), SceneError> {
        let mark = self.current_block_nesting();
        if let Err(error) = parse_entry(self) {
            self.record_error(error)?;
            self.skip_to_next_entry(mark, allowed);
        }
        Ok(())
    }

    /// Adds `error` to the list of errors, so that parsing continues.
    ///
    /// If the text ended inside a block or the list is full, returns `Err(error)` instead, which
    /// ends parsing.
    #[inline(never)]
    pub fn record_error(&mut self, error: SceneError) -> Result<(), SceneError> {
        if self.has_unclosed_block || self.errors.len() + 1 >= MAX_REPORTED_ERRORS {
            return Err(error);
        }
        self.errors.push(error);
        Ok(())
    }

    /// Returns the current numbers of open and closed blocks, for
    /// [`skip_to_next_entry`](Self::skip_to_next_entry).
    pub fn current_block_nesting(&self) -> SavedBlockNesting {
        SavedBlockNesting {
            open_block_count: self.open_blocks.len(),
            nesting_depth: self.nesting_depth,
            closed_block_count: self.closed_block_count,
        }
    }

    /// Skips the rest of a block's entry that has a syntax error. An entry is a field or an object.
    ///
    /// `mark` is the block nesting that was saved before the entry was parsed. Each word of
    /// `allowed` can start an entry.
    ///
    /// - If the entry opened blocks that are still open, skips past their ends.
    /// - If the entry opened and closed a block, it has ended, so nothing is skipped.
    /// - Otherwise, skips to a word of `allowed` or a `}`, or past the next block.
    #[inline(never)]
    pub fn skip_to_next_entry(&mut self, mark: SavedBlockNesting, allowed: &[&str]) {
        let mut braces = self.open_blocks.len().saturating_sub(mark.open_block_count);
        let has_open_blocks = braces > 0;
        self.open_blocks.truncate(mark.open_block_count);
        self.nesting_depth = mark.nesting_depth;
        if !has_open_blocks && self.closed_block_count > mark.closed_block_count {
            return;
        }
        loop {
            let token = self.lexer.peek_token();
            let stops = braces == 0 && (has_open_blocks || token.text == "}" || allowed.contains(&token.text));
            if token.is_empty() || stops {
                return;
            }
            if token.text == "\"" && self.lexer.read_quoted_string().is_ok() {
                continue;
            }
            self.lexer.consume_token(token);
            match token.text {
                "{" => braces += 1,
                "}" => {
                    braces -= 1;
                    if braces == 0 {
                        return;
                    }
                }
                _ => {}
            }
        }
    }

    /// Parses a list block such as `Lights`: its entries, and an optional field that states their
    /// number.
    ///
    /// `count` is the keyword of the optional field, such as `numLights`. Each entry starts with a
    /// word of `allowed`, and `parse_entry` parses the rest of the entry. Error messages call an
    /// entry `what`. Fails if the stated number differs from the number of entries.
    pub fn parse_list_block(
        &mut self,
        keyword: Token<'a>,
        (count, what): (&str, &str),
        allowed: &[&str],
        mut parse_entry: impl FnMut(&mut Self, Token<'a>) -> Result<(), SceneError>,
    ) -> Result<(), SceneError> {
        let mut stated = None;
        let mut found = 0;
        self.open_block(keyword)?;
        while let Some(word) = self.next_word_or_close()? {
            let is_count = word.text == count;
            found += usize::from(!is_count);
            self.parse_entry_with_recovery(allowed, |parser| {
                if is_count {
                    parser.parse_count(word, &mut stated)
                } else if allowed.contains(&word.text) {
                    parse_entry(parser, word)
                } else {
                    Err(parser.unexpected_word_error(word, allowed))
                }
            })?;
        }
        self.check_entry_count(count, stated, found, what)
    }

    /// Parses the `{` after a block's `keyword`, and marks the block as open.
    pub fn open_block(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
        self.open_blocks.push(keyword);
        self.expect_punctuation("{")
    }

    /// Parses the `}` of the innermost block, and marks the block as closed.
    pub fn close_block(&mut self) -> Result<(), SceneError> {
        self.expect_punctuation("}")?;
        self.open_blocks.pop();
        self.closed_block_count += 1;
        Ok(())
    }

    /// Parses the `{` of a `Group`, `Transform` or `Moving` block. Fails if such blocks nest deeper
    /// than `MAX_NESTING_DEPTH`.
    pub fn open_nested_block(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
        if self.nesting_depth == MAX_NESTING_DEPTH {
            let message = format!("groups and transforms nest more than {MAX_NESTING_DEPTH} deep");
            let help = "list the objects side by side instead".to_owned();
            return Err(self.lexer.error_at(keyword.span(), message, "too deep", help));
        }
        self.nesting_depth += 1;
        self.open_block(keyword)
    }

    /// Counts a `Group`, `Transform` or `Moving` block as left: decrements the nesting depth. The
    /// caller has parsed the block's `}`.
    pub fn decrement_nesting_depth(&mut self) {
        self.nesting_depth -= 1;
    }

    /// True if the parser has reached the end of the text inside a block, that is, before the
    /// block's `}`.
    pub fn has_unclosed_block(&self) -> bool {
        self.has_unclosed_block
    }

    /// Closes the innermost block as if its missing `}` stood before `word`, and moves back to
    /// `word`.
    pub fn close_block_before(&mut self, word: Token<'a>) {
        self.open_blocks.pop();
        self.closed_block_count += 1;
        self.lexer.rewind_to_token(word);
    }

    /// Consumes the punctuation `mark`, or returns an error if another token follows.
    pub fn expect_punctuation(&mut self, mark: &str) -> Result<(), SceneError> {
        let token = self.lexer.peek_token();
        if token.text == mark {
            self.lexer.consume_token(token);
            return Ok(());
        }
        if token.is_empty() {
            return Err(self.unclosed_block_error());
        }
        let block = self.innermost_block_name();
        let message = format!("expected `{mark}` in {block}, found `{}`", clip_for_message(token.text));
        Err(self.lexer.error_at(token.span(), message, "here", format!("put `{mark}` before it")))
    }

    /// Reads the next word of the innermost block. If the block's `}` follows instead, reads it,
    /// closes the block and returns `None`.
    ///
    /// # Errors
    /// If the text ends inside the block.
    pub fn next_word_or_close(&mut self) -> Result<Option<Token<'a>>, SceneError> {
        let token = self.lexer.peek_token();
        if token.is_empty() {
            return Err(self.unclosed_block_error());
        }
        self.lexer.consume_token(token);
        if token.text == "}" {
            self.open_blocks.pop();
            self.closed_block_count += 1;
            return Ok(None);
        }
        Ok(Some(token))
    }

    /// Parses `N` finite numbers. Error messages name `owner`, the keyword before the numbers.
    pub fn parse_numbers<const N: usize>(&mut self, owner: Token<'a>) -> Result<Spanned<[f64; N]>, SceneError> {
        let mut values = [0.0; N];
        let mut span: Option<Span> = None;
        for value in &mut values {
            let token = self.lexer.read_number_token();
            if token.is_empty() {
                return Err(self.missing_number_error(owner, N, "number"));
            }
            // The token is a valid number, but its value may overflow to infinity.
            *value = token.text.parse().unwrap_or(f64::NAN);
            if !value.is_finite() {
                let message = format!("`{}` is too large for a number", clip_for_message(token.text));
                let help = "numbers reach up to 1.7e308".to_owned();
                return Err(self.lexer.error_at(token.span(), message, "too large", help));
            }
            let start = span.map_or(token.start, |s| s.start);
            span = Some(Span { start, len: token.start + token.text.len() - start });
        }
        Ok(Spanned::new(values, span.unwrap_or_default()))
    }

    /// Parses a whole number from 0 to 2³² − 1. Error messages name `owner`, the keyword before the
    /// number.
    pub fn parse_integer(&mut self, owner: Token<'a>) -> Result<Spanned<u32>, SceneError> {
        let fraction = { self.lexer }.read_number_token();
        let token = self.lexer.read_integer_token();
        if token.is_empty() {
            return Err(self.missing_number_error(owner, 1, "whole number"));
        }
        let name = owner.text;
        let help = format!("write a whole number: `{name} 1`");
        if token.text.len() < fraction.text.len() {
            let message = format!("`{name}` wants a whole number, found `{}`", clip_for_message(fraction.text));
            return Err(self.lexer.error_at(fraction.span(), message, "not whole", help));
        }
        match token.text.parse() {
            Ok(value) => Ok(Spanned::new(value, token.span())),
            Err(_) => {
                let message = format!("`{name}` lies outside 0 … {}", u32::MAX);
                Err(self.lexer.error_at(token.span(), message, "out of range", help))
            }
        }
    }

    /// Returns the error for a token that stands where a number after the keyword `owner` belongs.
    ///
    /// `wanted` is how many numbers must follow `owner`; `kind` is "number" or "whole number".
    fn missing_number_error(&mut self, owner: Token<'a>, wanted: usize, kind: &str) -> SceneError {
        let token = self.lexer.peek_token();
        if token.is_empty() {
            return self.unclosed_block_error();
        }
        let (name, found) = (owner.text, clip_for_message(token.text));
        let bare = token.text.trim_start_matches(['+', '-']).to_ascii_lowercase();
        if ["nan", "inf", "infinity"].contains(&bare.as_str()) {
            let message = format!("`{found}` is not a finite number");
            return self.lexer.error_at(token.span(), message, "not finite", format!("give `{name}` a finite value"));
        }
        let message = match wanted {
            1 => format!("`{name}` wants a {kind}, found `{found}`"),
            n => format!("`{name}` wants {n} numbers, found `{found}`"),
        };
        let help = match wanted {
            _ if token.text.starts_with(',') => "separate numbers by spaces, not by commas".to_owned(),
            1 => format!("write a {kind}: `{name} 1`"),
            3 => format!("write three numbers: `{name} 0 0 1`"),
            n => format!("write {n} numbers, separated by spaces"),
        };
        self.lexer.error_at(token.span(), message, &format!("a {kind} belongs here"), help)
    }

    /// Parses a path or name, in quotes or bare. Error messages name `owner`, the keyword before
    /// the path or name.
    pub fn parse_name(&mut self, owner: Token<'a>) -> Result<Spanned<String>, SceneError> {
        let read = self.lexer.read_name()?;
        if !read.value.is_empty() {
            return Ok(read);
        }
        let token = self.lexer.peek_token();
        if token.is_empty() && read.span.len == 0 {
            return Err(self.unclosed_block_error());
        }
        let span = if read.span.len == 0 { token.span() } else { read.span };
        let name = owner.text;
        let help = format!("write a name after `{name}`, in quotes if it holds spaces");
        Err(self.lexer.error_at(span, format!("`{name}` wants a name"), "a name belongs here", help))
    }

    /// Parses the number after the keyword `word` of a field such as `numLights`, and stores it in
    /// `count`. The caller has read `word`.
    ///
    /// Fails if `count` already holds a number.
    pub fn parse_count(&mut self, word: Token<'a>, count: &mut Option<Spanned<u32>>) -> Result<(), SceneError> {
        if count.is_some() {
            return Err(self.repeated_word_error(word));
        }
        *count = Some(self.parse_integer(word)?);
        Ok(())
    }

    /// Fails if `count`, the number of entries that the text states, differs from `found`, the
    /// number of entries that were parsed.
    ///
    /// `name` is the keyword before the stated number. Error messages call an entry `what`.
    pub fn check_entry_count(
        &self,
        name: &str,
        count: Option<Spanned<u32>>,
        found: usize,
        what: &str,
    ) -> Result<(), SceneError> {
        match count {
            Some(count) if count.value as usize != found => {
                let follow = if found == 1 { " follows" } else { "s follow" };
                let message = format!("`{name}` is {}, but {found} {what}{follow}", count.value);
                let help = format!("write `{name} {found}`, or leave the count out");
                Err(self.lexer.error_at(count.span, message, "does not match", help))
            }
            _ => Ok(()),
        }
    }

    /// Returns the error for a second occurrence of `word`, a field or block that may occur only
    /// once.
    pub fn repeated_word_error(&self, word: Token<'a>) -> SceneError {
        let message = format!("`{}` is given twice in {}", word.text, self.innermost_block_name());
        self.lexer.error_at(word.span(), message, "the second", "keep one of them".to_owned())
    }

    /// Returns the error for a text that ends inside a block, and sets `has_unclosed_block`.
    pub fn unclosed_block_error(&mut self) -> SceneError {
        self.has_unclosed_block = true;
        let block = self.open_blocks.last().copied().unwrap_or(Token { text: "", start: 0 });
        let message = format!("the file ends inside `{}`", block.text);
        self.lexer.error_at(block.span(), message, "opened here", "close it with `}`".to_owned())
    }

    /// Returns the keyword of the innermost block in backticks, or "the file".
    fn innermost_block_name(&self) -> String {
        self.open_blocks.last().map_or("the file".to_owned(), |block| format!("`{}`", block.text))
    }

    /// Returns the error for a `word` that is not in `allowed`.
    ///
    /// The help text suggests a synonym or a similar word of `allowed`, or lists these words.
    #[inline(never)]
    pub fn unexpected_word_error(&self, word: Token<'a>, allowed: &[&str]) -> SceneError {
        let block = self.innermost_block_name();
        let help = if let Some(synonym) = keyword_synonym(word.text, allowed) {
            format!("write `{synonym}`")
        } else if let Some(nearest) = nearest_word(word.text, allowed.iter().copied()) {
            format!("did you mean `{nearest}`?")
        } else if self.open_blocks.is_empty() && word.text == "}" {
            "it closes nothing: remove it, or look for one too many before it".to_owned()
        } else {
            let or = if self.open_blocks.is_empty() { "" } else { "; or is a `}` missing before it?" };
            format!("{block} may hold {}{or}", allowed.join(", "))
        };
        self.lexer.error_at(
            word.span(),
            format!("unexpected `{}` in {block}", clip_for_message(word.text)),
            "not known here",
            help,
        )
    }
}
