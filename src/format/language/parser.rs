//! Token-level reading of scene text: blocks, numbers, names, counts, and recovery from errors.

use super::super::MAX_NESTING_DEPTH;
use super::super::description::{Span, Spanned};
use super::super::error::{MAX_ERRORS, SceneError};
use super::lexer::{Lexer, Token};
use super::scope::ParserScope;
use super::suggest::{keyword_synonym, nearest_word};
use super::text::clip_for_message;

/// A scene text that is being read.
pub(super) struct Parser<'a> {
    /// The text that is left.
    pub lexer: Lexer<'a>,
    /// Textures, media and materials defined so far.
    pub scope: ParserScope<'a>,
    /// Errors so far, in no particular order.
    pub errors: Vec<SceneError>,
    /// Keywords of the blocks around the current position, outermost first.
    open: Vec<Token<'a>>,
    /// Number of groups and transforms around the current position.
    depth: usize,
    /// Number of blocks that were read to their end.
    closed: usize,
    /// True if the text ended inside a block.
    ended: bool,
}

/// Nesting at the start of an entry, to which the parser returns after an error in it.
#[derive(Clone, Copy)]
pub(super) struct NestingMark {
    level: usize,
    depth: usize,
    closed: usize,
}

impl<'a> Parser<'a> {
    /// A parser at the start of `text`; errors call the text `name`.
    pub fn new(name: &'a str, text: &'a str) -> Self {
        Self {
            lexer: Lexer::new(name, text),
            scope: ParserScope::default(),
            errors: Vec::new(),
            open: Vec::new(),
            depth: 0,
            closed: 0,
            ended: false,
        }
    }

    /// Returns all errors as one, in the order of the text; `last` is the error that ended the
    /// reading, if one did.
    pub fn into_joined_error(mut self, last: Option<SceneError>) -> Option<SceneError> {
        // A text that ends inside a block often does so because of an earlier error.
        self.errors.extend(last.filter(|_| !self.ended || self.errors.is_empty()));
        SceneError::join(self.errors)
    }

    /// Runs `read`. Records its error, if any, and continues at the next of the words `allowed` or
    /// at the block's end.
    ///
    /// # Errors
    /// The error itself, if the text has ended or the list of errors is full.
    pub fn recover_from_error<T>(
        &mut self,
        allowed: &[&str],
        read: impl FnOnce(&mut Self) -> Result<T, SceneError>,
    ) -> Result<Option<T>, SceneError> {
        let mark = self.nesting_mark();
        match read(self) {
            Ok(value) => Ok(Some(value)),
            Err(error) => {
                self.record_error(error)?;
                self.skip_to_next_entry(mark, allowed);
                Ok(None)
            }
        }
    }

    /// Records an error, or returns it if the text has ended or the list of errors is full.
    #[inline(never)]
    pub fn record_error(&mut self, error: SceneError) -> Result<(), SceneError> {
        if self.ended || self.errors.len() + 1 >= MAX_ERRORS {
            return Err(error);
        }
        self.errors.push(error);
        Ok(())
    }

    /// Returns the nesting at the current position.
    pub fn nesting_mark(&self) -> NestingMark {
        NestingMark { level: self.open.len(), depth: self.depth, closed: self.closed }
    }

    /// Skips the rest of the blocks opened since `mark`.
    ///
    /// If none were, skips to the next of the words `allowed`, past one block in braces, or to a
    /// `}`. If a block was read to its end since `mark`, skips nothing.
    #[inline(never)]
    pub fn skip_to_next_entry(&mut self, mark: NestingMark, allowed: &[&str]) {
        let mut braces = self.open.len().saturating_sub(mark.level);
        let closes = braces > 0;
        self.open.truncate(mark.level);
        self.depth = mark.depth;
        if !closes && self.closed > mark.closed {
            return;
        }
        loop {
            let token = self.lexer.peek();
            let stops = braces == 0 && (closes || token.text == "}" || allowed.contains(&token.text));
            if token.is_end() || stops {
                return;
            }
            if token.text == "\"" && self.lexer.read_quoted_string().is_ok() {
                continue;
            }
            self.lexer.consume(token);
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

    /// Reads the list block of `keyword`: a count named `count`, and entries that start with a word
    /// of `allowed`.
    ///
    /// Each entry goes to `read` with its keyword. `what` names one entry in the error of a wrong
    /// count.
    pub fn parse_list_block(
        &mut self,
        keyword: Token<'a>,
        (count, what): (&str, &str),
        allowed: &[&str],
        mut read: impl FnMut(&mut Self, Token<'a>) -> Result<(), SceneError>,
    ) -> Result<(), SceneError> {
        let mut stated = None;
        let mut found = 0;
        self.open_block(keyword)?;
        while let Some(word) = self.next_word()? {
            let is_count = word.text == count;
            found += usize::from(!is_count);
            self.recover_from_error(allowed, |parser| {
                if is_count {
                    parser.parse_count(word, &mut stated)
                } else if allowed.contains(&word.text) {
                    read(parser, word)
                } else {
                    Err(parser.unexpected_word_error(word, allowed))
                }
            })?;
        }
        self.check_entry_count(count, stated, found, what)
    }

    /// Reads the `{` after a block's keyword.
    pub fn open_block(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
        self.open.push(keyword);
        self.expect_punctuation("{")
    }

    /// Reads the `}` of a block without fields.
    pub fn close_block(&mut self) -> Result<(), SceneError> {
        self.expect_punctuation("}")?;
        self.open.pop();
        self.closed += 1;
        Ok(())
    }

    /// Opens a block that may hold blocks of its own kind.
    pub fn open_nested_block(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
        if self.depth == MAX_NESTING_DEPTH {
            let message = format!("groups and transforms nest more than {MAX_NESTING_DEPTH} deep");
            let help = "list the objects side by side instead".to_owned();
            return Err(self.lexer.error_at(keyword.span(), message, "too deep", help));
        }
        self.depth += 1;
        self.open_block(keyword)
    }

    /// Ends what [`descend`](Self::open_nested_block) began, once its `}` was read.
    pub fn leave_nested_block(&mut self) {
        self.depth -= 1;
    }

    /// True if the text ended inside a block.
    pub fn has_unclosed_block(&self) -> bool {
        self.ended
    }

    /// Closes the innermost block without reading a `}`, and makes `word` unread again.
    pub fn close_block_before(&mut self, word: Token<'a>) {
        self.open.pop();
        self.closed += 1;
        self.lexer.rewind_to(word);
    }

    /// Reads the punctuation `mark`.
    pub fn expect_punctuation(&mut self, mark: &str) -> Result<(), SceneError> {
        let token = self.lexer.peek();
        if token.text == mark {
            self.lexer.consume(token);
            return Ok(());
        }
        if token.is_end() {
            return Err(self.unclosed_block_error());
        }
        let block = self.innermost_block_name();
        let message = format!("expected `{mark}` in {block}, found `{}`", clip_for_message(token.text));
        Err(self.lexer.error_at(token.span(), message, "here", format!("put `{mark}` before it")))
    }

    /// Reads the next word of the innermost block; `None` at its `}`.
    pub fn next_word(&mut self) -> Result<Option<Token<'a>>, SceneError> {
        let token = self.lexer.peek();
        if token.is_end() {
            return Err(self.unclosed_block_error());
        }
        self.lexer.consume(token);
        if token.text == "}" {
            self.open.pop();
            self.closed += 1;
            return Ok(None);
        }
        Ok(Some(token))
    }

    /// Reads the `N` numbers of the field `owner`.
    pub fn parse_numbers<const N: usize>(&mut self, owner: Token<'a>) -> Result<Spanned<[f64; N]>, SceneError> {
        let mut values = [0.0; N];
        let mut span: Option<Span> = None;
        for value in &mut values {
            let token = self.lexer.number_token();
            if token.is_end() {
                return Err(self.missing_number_error(owner, N, "number"));
            }
            // The prefix is a number by construction; what overflows becomes infinite.
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

    /// Reads the whole number of the field `owner`.
    pub fn parse_integer(&mut self, owner: Token<'a>) -> Result<Spanned<u32>, SceneError> {
        let fraction = { self.lexer }.number_token();
        let token = self.lexer.integer_token();
        if token.is_end() {
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

    /// Returns the error of a field `owner` whose numbers do not follow.
    fn missing_number_error(&mut self, owner: Token<'a>, wanted: usize, kind: &str) -> SceneError {
        let token = self.lexer.peek();
        if token.is_end() {
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

    /// Reads the path or name after `owner`, quoted or bare.
    pub fn parse_name(&mut self, owner: Token<'a>) -> Result<Spanned<String>, SceneError> {
        let read = self.lexer.read_name()?;
        if !read.value.is_empty() {
            return Ok(read);
        }
        let token = self.lexer.peek();
        if token.is_end() && read.span.len == 0 {
            return Err(self.unclosed_block_error());
        }
        let span = if read.span.len == 0 { token.span() } else { read.span };
        let name = owner.text;
        let help = format!("write a name after `{name}`, in quotes if it holds spaces");
        Err(self.lexer.error_at(span, format!("`{name}` wants a name"), "a name belongs here", help))
    }

    /// Reads a count, which [`check_count`](Self::check_entry_count) compares with the number of entries.
    pub fn parse_count(&mut self, word: Token<'a>, count: &mut Option<Spanned<u32>>) -> Result<(), SceneError> {
        if count.is_some() {
            return Err(self.repeated_word_error(word));
        }
        *count = Some(self.parse_integer(word)?);
        Ok(())
    }

    /// Refuses a count that differs from the number of entries `found`.
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

    /// Returns the error of a word that its block holds already.
    pub fn repeated_word_error(&self, word: Token<'a>) -> SceneError {
        let message = format!("`{}` is given twice in {}", word.text, self.innermost_block_name());
        self.lexer.error_at(word.span(), message, "the second", "keep one of them".to_owned())
    }

    /// Returns the error of a text that ends inside a block.
    pub fn unclosed_block_error(&mut self) -> SceneError {
        self.ended = true;
        let block = self.open.last().copied().unwrap_or(Token { text: "", start: 0 });
        let message = format!("the file ends inside `{}`", block.text);
        self.lexer.error_at(block.span(), message, "opened here", "close it with `}`".to_owned())
    }

    /// Returns the innermost block in words.
    fn innermost_block_name(&self) -> String {
        self.open.last().map_or("the file".to_owned(), |block| format!("`{}`", block.text))
    }

    /// Returns the error of a word that is none of those `allowed` here.
    #[inline(never)]
    pub fn unexpected_word_error(&self, word: Token<'a>, allowed: &[&str]) -> SceneError {
        let block = self.innermost_block_name();
        let help = if let Some(synonym) = keyword_synonym(word.text, allowed) {
            format!("write `{synonym}`")
        } else if let Some(nearest) = nearest_word(word.text, allowed.iter().copied()) {
            format!("did you mean `{nearest}`?")
        } else if self.open.is_empty() && word.text == "}" {
            "it closes nothing: remove it, or look for one too many before it".to_owned()
        } else {
            let or = if self.open.is_empty() { "" } else { "; or is a `}` missing before it?" };
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
