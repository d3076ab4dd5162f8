//! Parses blocks of named fields in any order, and gives access to the field values.

use glam::{DVec2, DVec3, DVec4};

use super::curves::{BEZIER_PROFILE, BSPLINE_PROFILE, CurveBasis, ProfileCurve};
use super::field_value::{FieldValue, ParsedFieldValue, default_value};
use super::lexer::{Lexer, Token};
use super::parser::Parser;
use super::schema::{BlockParser, BlockSchema, FieldDefault, FieldKind, FieldSchema, block_keywords, find_block};
use super::suggest::nearest_word;
use super::text::{clip_for_message, is_nonfinite_number};
use super::transforms::parse_transform_steps;
use crate::format::error::SceneError;
use crate::format::span::{Span, Spanned};

/// Keyword of a color field, with a function that converts the field's color to a `T`.
///
/// A block has exactly one of several such fields: a light, for example, has `radiance` or `power`.
pub(in crate::format) type ColorFieldAlternative<'a, T> = (&'a str, fn(DVec3) -> T);

/// Parsed fields of one block of scene text.
pub(in crate::format) struct BlockFields<'a> {
    lexer: Lexer<'a>,
    block: &'static BlockSchema,
    keyword: Token<'a>,
    fields: Vec<(&'static FieldSchema, Token<'a>, Spanned<ParsedFieldValue>)>,
}

/// A field that is written in a block of scene text, with its parsed value.
#[derive(Clone, Copy)]
pub(in crate::format) struct ParsedField<'f, 'a> {
    block: &'f BlockFields<'a>,
    field: &'static FieldSchema,
    /// Keyword or alias by which the text names the field.
    keyword: Token<'a>,
    value: &'f Spanned<ParsedFieldValue>,
}

/// Parses the `{ … }` of the block that begins with `keyword`, which the caller has read. Fails if
/// no block of `table` has this keyword.
///
/// Returns the block's entry in `table`, and the parsed fields.
pub(in crate::format) fn parse_block_by_keyword<'a, P>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
    table: &'static [BlockParser<P>],
) -> Result<(&'static BlockParser<P>, BlockFields<'a>), SceneError> {
    let Some(entry) = find_block(table, keyword.text) else {
        return Err(parser.unexpected_word_error(keyword, &block_keywords(&[], table)));
    };
    Ok((entry, parse_block_fields(parser, keyword, entry.block)?))
}

/// Parses the `{ … }` of a block with schema `block`. Each field may occur once, with a value in
/// its range.
///
/// Continues after errors in fields. Appends all errors but the last to `parser.errors`, and
/// returns the last.
pub(in crate::format) fn parse_block_fields<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
    block: &'static BlockSchema,
) -> Result<BlockFields<'a>, SceneError> {
    let mut fields = BlockFields { lexer: parser.lexer, block, keyword, fields: Vec::new() };
    let mut last_error = None;
    parser.open_block(keyword)?;
    let words: Vec<&str> = block.field_keywords().collect();
    loop {
        let mark = parser.current_block_nesting();
        let (word, error) = match parser.next_word_or_close() {
            Ok(None) => break,
            Ok(Some(word)) => match parse_field(parser, &mut fields, word, &words) {
                Ok(()) => continue,
                Err(error) => (Some(word), error),
            },
            Err(error) => (None, error),
        };
        parser.errors.extend(last_error.take());
        // A word that starts another block shows that the `}` of this block is missing.
        let block_start =
            word.filter(|word| block.find_field(word.text).is_none() && looks_like_block_keyword(word.text, &words));
        if let Some(word) = block_start {
            parser.close_block_before(word);
        }
        if block_start.is_some() || parser.has_unclosed_block() {
            return Err(error);
        }
        last_error = Some(error);
        parser.skip_to_next_entry(mark, &words);
    }
    last_error.map_or(Ok(fields), Err)
}

/// True if `word` could be the keyword of a new block: it is capitalized and resembles no field
/// keyword in `fields`.
fn looks_like_block_keyword(word: &str, fields: &[&str]) -> bool {
    word.starts_with(|c: char| c.is_ascii_uppercase()) && nearest_word(word, fields.iter().copied()).is_none()
}

/// Parses the value of the field with the keyword `word`, checks it, and appends the field to
/// `fields`. The caller has read `word`.
///
/// `words` are the keywords that an error message lists as allowed.
fn parse_field<'a>(
    parser: &mut Parser<'a>,
    fields: &mut BlockFields<'a>,
    word: Token<'a>,
    words: &[&str],
) -> Result<(), SceneError> {
    let Some(field) = fields.block.find_field(word.text) else { return Err(parser.unexpected_word_error(word, words)) };
    if let Some((_, earlier, _)) = fields.fields.iter().find(|(earlier, ..)| earlier.keyword == field.keyword) {
        if earlier.text == word.text {
            return Err(parser.repeated_word_error(word));
        }
        let message = format!("`{}` has both `{}` and `{}`", fields.keyword.text, earlier.text, word.text);
        let help = format!("keep one of `{}` or `{}`", earlier.text, word.text);
        return Err(parser.lexer.error_at(word.span(), message, "the second", help));
    }
    let value = parse_field_value(parser, word, field)?;
    fields.fields.push((field, word, value));
    let (_, _, value) = &fields.fields[fields.fields.len() - 1];
    ParsedField { block: fields, field, keyword: word, value }.check_field_value()
}

/// Parses the value of `field`. The caller has read its keyword `word`.
fn parse_field_value<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
    field: &'static FieldSchema,
) -> Result<Spanned<ParsedFieldValue>, SceneError> {
    let mut value = ParsedFieldValue::default();
    let span = match field.kind {
        FieldKind::ColorOrTexture | FieldKind::NumberOrTexture if is_texture_name_next(parser) => {
            let name = parser.parse_name(word)?;
            parser.scope.check_texture_exists(parser.lexer, &name)?;
            value.text = name.value;
            name.span
        }
        FieldKind::Pair => {
            let read = parser.parse_numbers::<2>(word)?;
            value.numbers = DVec2::from_array(read.value).extend(0.0);
            read.span
        }
        FieldKind::Point | FieldKind::Direction | FieldKind::Color | FieldKind::ColorOrTexture => {
            let read = parser.parse_numbers(word)?;
            value.numbers = DVec3::from_array(read.value);
            read.span
        }
        FieldKind::Number | FieldKind::NumberOrTexture => {
            let read = parser.parse_numbers::<1>(word)?;
            value.numbers.x = read.value[0];
            read.span
        }
        FieldKind::WholeNumber => {
            let read = parser.parse_integer(word)?;
            value.numbers.x = f64::from(read.value);
            read.span
        }
        FieldKind::Name | FieldKind::Word(_) => {
            let read = parser.parse_name(word)?;
            value.text = read.value;
            read.span
        }
        FieldKind::TransformSteps => {
            value.steps = parse_transform_steps(parser, word)?;
            word.span()
        }
        FieldKind::Curve => {
            let read = parse_profile_curve(parser)?;
            (value.basis, value.points) = (read.value.basis, read.value.controls);
            read.span
        }
        FieldKind::Points => {
            value.points = parse_points(parser, word)?;
            word.span()
        }
        FieldKind::WeightedPoints => {
            value.weighted_points = parse_weighted_points(parser, word)?;
            word.span()
        }
        FieldKind::NumberList => {
            let mut span = None;
            // A copy of the lexer looks ahead, so that the number stays unread.
            while !{ parser.lexer }.read_number_token().is_empty() {
                let read = parser.parse_numbers::<1>(word)?;
                value.number_list.push(read.value[0]);
                let start = span.map_or(read.span.start, |s: Span| s.start);
                span = Some(Span { start, len: read.span.start + read.span.len - start });
            }
            span.unwrap_or(word.span())
        }
    };
    Ok(Spanned::new(value, span))
}

/// True if the next token is a texture's name rather than a number.
fn is_texture_name_next(parser: &mut Parser<'_>) -> bool {
    let text = parser.lexer.peek_token().text;
    text.starts_with(|c: char| c == '"' || c == '_' || c.is_ascii_alphabetic()) && !is_nonfinite_number(text)
}

/// Parses any number of points `[ x y z ]`; errors name the field `word`.
fn parse_points<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Vec<DVec3>, SceneError> {
    let mut points = Vec::new();
    while parser.lexer.peek_token().text == "[" {
        parser.expect_punctuation("[")?;
        points.push(DVec3::from_array(parser.parse_numbers(word)?.value));
        parser.expect_punctuation("]")?;
    }
    Ok(points)
}

/// Parses any number of points `[ x y z ]` or `[ x y z weight ]`; the default weight is 1.
fn parse_weighted_points<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Vec<DVec4>, SceneError> {
    let mut points = Vec::new();
    while parser.lexer.peek_token().text == "[" {
        parser.expect_punctuation("[")?;
        let point = DVec3::from_array(parser.parse_numbers(word)?.value);
        let mut weight = 1.0;
        if parser.lexer.peek_token().text != "]" {
            let read = parser.parse_numbers::<1>(word)?;
            weight = read.value[0];
            if weight <= 0.0 {
                let message = format!("the weight of a point of `{}` cannot be `{weight}`", word.text);
                let help = "weights are above 0; write `[ x y z ]` or `[ x y z weight ]`".to_owned();
                return Err(parser.lexer.error_at(read.span, message, "not allowed", help));
            }
        }
        parser.expect_punctuation("]")?;
        points.push(point.extend(weight));
    }
    Ok(points)
}

/// Parses the curve block that follows the keyword `profile`.
///
/// The span of the result is the position of the block's keyword, such as `BezierCurve`.
fn parse_profile_curve(parser: &mut Parser<'_>) -> Result<Spanned<ProfileCurve>, SceneError> {
    let keyword = parser.lexer.peek_token();
    let (block, basis) = match keyword.text {
        "BezierCurve" => (&BEZIER_PROFILE, CurveBasis::Bezier),
        "BsplineCurve" => (&BSPLINE_PROFILE, CurveBasis::Bspline),
        "" => return Err(parser.unclosed_block_error()),
        text => {
            let message = format!("`profile` wants a curve, found `{}`", clip_for_message(text));
            let help = "write `profile BezierCurve { … }` or `profile BsplineCurve { … }`".to_owned();
            return Err(parser.lexer.error_at(keyword.span(), message, "a curve belongs here", help));
        }
    };
    parser.lexer.consume_token(keyword);
    let f = parse_block_fields(parser, keyword, block)?;
    Ok(Spanned::new(f.require_field("controls")?.curve_with_basis(basis)?, keyword.span()))
}

impl<'a> BlockFields<'a> {
    /// Returns an error at `span` of the scene text. `label` is printed under the text of the span.
    pub fn error_at(&self, span: Span, message: String, label: &str, help: String) -> SceneError {
        self.lexer.error_at(span, message, label, help)
    }

    /// Returns the field `name` of the block; `None` if it is absent.
    pub fn get(&self, name: &str) -> Option<ParsedField<'_, 'a>> {
        debug_assert!(self.block.find_field(name).is_some(), "`{}` has no field `{name}`", self.block.keyword);
        let (field, word, value) = self.fields.iter().find(|(field, ..)| field.keyword == name)?;
        Some(ParsedField { block: self, field, keyword: *word, value })
    }

    /// Returns the field `name`.
    ///
    /// # Errors
    /// If the field is absent.
    pub fn require_field(&self, name: &str) -> Result<ParsedField<'_, 'a>, SceneError> {
        self.get(name).ok_or_else(|| {
            let alias = self.block.find_field(name).map_or("", |field| field.alias);
            let listed = if alias.is_empty() { format!("`{name}`") } else { format!("`{name}` or `{alias}`") };
            let message = format!("`{}` has no {listed}", self.keyword.text);
            self.error_at(self.keyword.span(), message, "this block", format!("add {listed} to it"))
        })
    }

    /// Returns the field of the block whose name is among `names`. The block must have exactly one
    /// such field.
    ///
    /// # Errors
    /// If no field or more than one field of `names` is present.
    pub fn require_one_field_of(&self, names: &[&str]) -> Result<ParsedField<'_, 'a>, SceneError> {
        let mut found = self.fields.iter().filter(|(field, ..)| names.contains(&field.keyword));
        let block = self.keyword.text;
        let listed = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" or ");
        let Some((field, word, value)) = found.next() else {
            let message = format!("`{block}` has no {listed}");
            return Err(self.error_at(self.keyword.span(), message, "this block", format!("add {listed} to it")));
        };
        if let Some((_, second, _)) = found.next() {
            let message = format!("`{block}` has both `{}` and `{}`", word.text, second.text);
            return Err(self.error_at(second.span(), message, "the second", format!("keep one of {listed}")));
        }
        Ok(ParsedField { block: self, field, keyword: *word, value })
    }

    /// Returns the value of the only field among `variants` that is present in the block.
    ///
    /// Each of `variants` holds a keyword and the function that converts this field's color to a
    /// `T`.
    ///
    /// # Errors
    /// If no field or more than one field of `variants` is present.
    pub fn require_one_color_field<T>(&self, variants: &[ColorFieldAlternative<'_, T>]) -> Result<T, SceneError> {
        let names: Vec<&str> = variants.iter().map(|(name, _)| *name).collect();
        let field = self.require_one_field_of(&names)?;
        let index = names.iter().position(|name| *name == field.field.keyword).unwrap_or_default();
        Ok(variants[index].1(field.value()))
    }

    /// Fails if any field of `names` is present in the block.
    ///
    /// The error's help text is the name of that field, followed by `rule`.
    pub fn forbid_fields(&self, names: &[&str], rule: &str) -> Result<(), SceneError> {
        names.iter().find_map(|name| self.get(name)).map_or(Ok(()), |field| field.ensure_valid(false, rule))
    }

    /// Fails if the fields `first` and `second` are both present.
    pub fn forbid_both_fields(&self, first: &str, second: &str) -> Result<(), SceneError> {
        match (self.get(first), self.get(second)) {
            (Some(_), Some(_)) => self.require_one_field_of(&[first, second]).map(|_| ()),
            _ => Ok(()),
        }
    }

    /// Returns the value of the field `name`. If the field is absent, returns its default.
    ///
    /// # Errors
    /// If the field is absent and must be present.
    pub fn value_or_default<T: FieldValue>(&self, name: &str) -> Result<T, SceneError> {
        if self.get(name).is_none()
            && let Some(default) = self.block.find_field(name).and_then(default_value)
        {
            return Ok(default);
        }
        self.require_field(name).map(|field| field.value())
    }

    /// Returns the value of the field `name`; `None` if the field is absent.
    pub fn optional_value<T: FieldValue>(&self, name: &str) -> Option<T> {
        self.get(name).map(|field| field.value())
    }

    /// Returns the word in the field `name`. If the field is absent, returns the default word of
    /// the field's schema.
    ///
    /// # Errors
    /// If the field is absent and its schema has no default word.
    pub fn field_word_or_default(&self, name: &str) -> Result<&str, SceneError> {
        match (self.get(name), self.block.find_field(name).map(|field| field.default)) {
            (Some(found), _) => Ok(&found.value.value.text),
            (None, Some(FieldDefault::Word(word))) => Ok(word),
            (None, _) => self.require_field(name).map(|_| ""),
        }
    }
}

impl<'f, 'a> ParsedField<'f, 'a> {
    /// Returns the keyword or alias by which the text names the field.
    pub fn name(&self) -> &'a str {
        self.keyword.text
    }

    /// Returns the position of the value in the scene text.
    pub fn span(&self) -> Span {
        self.value.span
    }

    /// Returns the field's value, converted to `T`.
    pub fn value<T: FieldValue>(&self) -> T {
        T::from_parsed_value(self.value)
    }

    /// Returns a curve whose control points are those in this field, and whose polynomial basis is
    /// `basis`.
    ///
    /// # Errors
    /// If a Bézier curve has fewer than 2 points, or a B-spline fewer than 4.
    pub fn curve_with_basis(&self, basis: CurveBasis) -> Result<ProfileCurve, SceneError> {
        let controls = self.value.points.clone();
        let fewest = match basis {
            CurveBasis::Bezier => 2,
            CurveBasis::Bspline => 4,
        };
        self.ensure_valid(controls.len() >= fewest, &format!("must hold at least {fewest} points"))?;
        Ok(ProfileCurve { basis, controls })
    }

    /// Returns the control points (x, y, z, weight) of a field of kind
    /// [`FieldKind::WeightedPoints`].
    pub fn weighted_points(&self) -> &'f [DVec4] {
        &self.value.weighted_points
    }

    /// Returns the numbers of a field of kind [`FieldKind::NumberList`].
    pub fn number_list(&self) -> &'f [f64] {
        &self.value.number_list
    }

    /// Fails with an error at this field's value if `is_valid` is false.
    ///
    /// `rule` says what the value must be. The error's help text is the field's name, then `rule`.
    pub fn ensure_valid(&self, is_valid: bool, rule: &str) -> Result<(), SceneError> {
        if is_valid {
            return Ok(());
        }
        let (name, block) = (self.keyword.text, self.block.keyword.text);
        let value = clip_for_message(self.block.lexer.text_of_span(self.value.span));
        let message = format!("`{name}` of `{block}` cannot be `{value}`");
        Err(self.block.error_at(self.value.span, message, "not allowed", format!("`{name}` {rule}")))
    }

    /// Fails if the value is outside the range or the list of words in the field's schema.
    fn check_field_value(&self) -> Result<(), SceneError> {
        let violated_rule = match self.field.kind {
            FieldKind::Word(words) if !words.contains(&self.value.text.as_str()) => {
                let listed: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
                let joint = if listed.len() == 2 { " or " } else { ", " };
                let one_of = if listed.len() == 2 { "" } else { "one of " };
                Some(format!("must be {one_of}{}", listed.join(joint)))
            }
            FieldKind::ColorOrTexture | FieldKind::NumberOrTexture if !self.value.text.is_empty() => None,
            FieldKind::Point | FieldKind::Direction | FieldKind::Color | FieldKind::ColorOrTexture => {
                self.field.violated_rule(&self.value.numbers.to_array())
            }
            FieldKind::Pair => self.field.violated_rule(&self.value.numbers.to_array()[..2]),
            FieldKind::Number | FieldKind::NumberOrTexture | FieldKind::WholeNumber => {
                self.field.violated_rule(&[self.value.numbers.x])
            }
            FieldKind::Name
            | FieldKind::Word(_)
            | FieldKind::Curve
            | FieldKind::Points
            | FieldKind::WeightedPoints
            | FieldKind::NumberList
            | FieldKind::TransformSteps => None,
        };
        violated_rule.map_or(Ok(()), |rule| self.ensure_valid(false, &rule))
    }
}
