//! Blocks of named fields in any order, read and checked by their tables.

use glam::{DVec2, DVec3, DVec4};

use super::super::description::{CurveBasis, ProfileCurve, Span, Spanned, TexturedValue, TransformStep};
use super::super::error::SceneError;
use super::curves::{BEZIER_PROFILE, BSPLINE_PROFILE};
use super::lexer::{Lexer, Token};
use super::maps::bare_maps;
use super::reader::Parser;
use super::schema::{Block, Default, Field, Kind};
use super::suggest::nearest;
use super::text::{clip, is_number_word};

/// Value of a field. The [`Kind`] of the field determines which member is filled.
#[derive(Default)]
struct FieldValue {
    /// One, two or three numbers.
    numbers: DVec3,
    /// A name, path or word; the name of the texture that replaces numbers.
    name: String,
    maps: Vec<TransformStep>,
    basis: CurveBasis,
    points: Vec<DVec3>,
    weighted: Vec<DVec4>,
    list: Vec<f64>,
}

/// The fields of a block that was read to its end.
pub(super) struct Fields<'a> {
    lexer: Lexer<'a>,
    block: &'static Block,
    keyword: Token<'a>,
    list: Vec<(&'static Field, Token<'a>, Spanned<FieldValue>)>,
}

/// A field of a block that the text sets, with its value.
#[derive(Clone, Copy)]
pub(super) struct PresentField<'f, 'a> {
    fields: &'f Fields<'a>,
    field: &'static Field,
    word: Token<'a>,
    value: &'f Spanned<FieldValue>,
}

/// Reads `{ … }` with the fields of `block`, each at most once and within its range.
pub(super) fn fields<'a>(
    parser: &mut Parser<'a>,
    keyword: Token<'a>,
    block: &'static Block,
) -> Result<Fields<'a>, SceneError> {
    let mut fields = Fields { lexer: parser.lexer, block, keyword, list: Vec::new() };
    let mut failed = None;
    parser.open(keyword)?;
    let words: Vec<&str> = block.words().collect();
    loop {
        let mark = parser.mark();
        let read = match parser.word() {
            Ok(None) => break,
            Ok(Some(word)) => read_field(parser, &mut fields, word, &words).map_err(|error| (Some(word), error)),
            Err(error) => Err((None, error)),
        };
        let Err((word, error)) = read else { continue };
        if let Some(earlier) = failed.take() {
            parser.errors.push(earlier);
        }
        // A word that starts a block elsewhere: this block lacks its `}`.
        let unknown = word.filter(|word| block.field(word.text).is_none() && starts_block(word.text, &words));
        if let Some(word) = unknown {
            parser.close_before(word);
        }
        if unknown.is_some() || parser.has_ended() {
            return Err(error);
        }
        failed = Some(error);
        parser.skip(mark, &words);
    }
    failed.map_or(Ok(fields), Err)
}

/// True if `word` looks like the keyword of a block rather than a misspelt field.
fn starts_block(word: &str, fields: &[&str]) -> bool {
    word.starts_with(|c: char| c.is_ascii_uppercase()) && nearest(word, fields.iter().copied()).is_none()
}

/// Reads the field that starts with `word` into `fields`.
fn read_field<'a>(
    parser: &mut Parser<'a>,
    fields: &mut Fields<'a>,
    word: Token<'a>,
    words: &[&str],
) -> Result<(), SceneError> {
    let Some(field) = fields.block.field(word.text) else { return Err(parser.unexpected(word, words)) };
    if let Some((_, earlier, _)) = fields.list.iter().find(|(earlier, ..)| earlier.name == field.name) {
        if earlier.text == word.text {
            return Err(parser.repeated(word));
        }
        let message = format!("`{}` has both `{}` and `{}`", fields.keyword.text, earlier.text, word.text);
        let help = format!("keep one of `{}` or `{}`", earlier.text, word.text);
        return Err(parser.lexer.error(word.span(), message, "the second", help));
    }
    let value = read_value(parser, word, field)?;
    fields.list.push((field, word, value));
    let (_, _, value) = &fields.list[fields.list.len() - 1];
    PresentField { fields, field, word, value }.check()
}

/// Reads the value of `field` after its keyword `word`.
fn read_value<'a>(
    parser: &mut Parser<'a>,
    word: Token<'a>,
    field: &'static Field,
) -> Result<Spanned<FieldValue>, SceneError> {
    let mut value = FieldValue::default();
    let span = match field.kind {
        Kind::ColorOrTexture | Kind::NumberOrTexture if name_follows(parser) => {
            let name = parser.name(word)?;
            parser.scope.check_texture(parser.lexer, &name)?;
            value.name = name.value;
            name.span
        }
        Kind::Pair => {
            let read = parser.numbers::<2>(word)?;
            value.numbers = DVec2::from_array(read.value).extend(0.0);
            read.span
        }
        Kind::Point | Kind::Direction | Kind::Color | Kind::ColorOrTexture => {
            let read = parser.numbers(word)?;
            value.numbers = DVec3::from_array(read.value);
            read.span
        }
        Kind::Number | Kind::NumberOrTexture => {
            let read = parser.numbers::<1>(word)?;
            value.numbers.x = read.value[0];
            read.span
        }
        Kind::Whole => {
            let read = parser.integer(word)?;
            value.numbers.x = f64::from(read.value);
            read.span
        }
        Kind::Name | Kind::Word(_) => {
            let read = parser.name(word)?;
            value.name = read.value;
            read.span
        }
        Kind::Maps => {
            value.maps = bare_maps(parser, word)?;
            word.span()
        }
        Kind::Curve => {
            let read = curve(parser)?;
            (value.basis, value.points) = (read.value.basis, read.value.controls);
            read.span
        }
        Kind::Points => {
            value.points = points(parser, word)?;
            word.span()
        }
        Kind::WeightedPoints => {
            value.weighted = weighted_points(parser, word)?;
            word.span()
        }
        Kind::Numbers => {
            let mut span = None;
            while !{ parser.lexer }.number().is_end() {
                let read = parser.numbers::<1>(word)?;
                value.list.push(read.value[0]);
                let start = span.map_or(read.span.start, |s: Span| s.start);
                span = Some(Span { start, len: read.span.start + read.span.len - start });
            }
            span.unwrap_or(word.span())
        }
    };
    Ok(Spanned::new(value, span))
}

/// True if a name comes next, where numbers may come too.
fn name_follows(parser: &mut Parser<'_>) -> bool {
    let text = parser.lexer.peek().text;
    text.starts_with(|c: char| c == '"' || c == '_' || c.is_ascii_alphabetic()) && !is_number_word(text)
}

/// Reads points in brackets.
fn points<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Vec<DVec3>, SceneError> {
    let mut points = Vec::new();
    while parser.lexer.peek().text == "[" {
        parser.punctuation("[")?;
        points.push(DVec3::from_array(parser.numbers(word)?.value));
        parser.punctuation("]")?;
    }
    Ok(points)
}

/// Reads points in brackets with a weight, which is 1 if left out.
fn weighted_points<'a>(parser: &mut Parser<'a>, word: Token<'a>) -> Result<Vec<DVec4>, SceneError> {
    let mut points = Vec::new();
    while parser.lexer.peek().text == "[" {
        parser.punctuation("[")?;
        let point = DVec3::from_array(parser.numbers(word)?.value);
        let mut weight = 1.0;
        if parser.lexer.peek().text != "]" {
            let read = parser.numbers::<1>(word)?;
            weight = read.value[0];
            if weight <= 0.0 {
                let message = format!("the weight of a point of `{}` cannot be `{weight}`", word.text);
                let help = "weights are above 0; write `[ x y z ]` or `[ x y z weight ]`".to_owned();
                return Err(parser.lexer.error(read.span, message, "not allowed", help));
            }
        }
        parser.punctuation("]")?;
        points.push(point.extend(weight));
    }
    Ok(points)
}

/// Reads the curve block after `profile`; its span is its keyword.
fn curve(parser: &mut Parser<'_>) -> Result<Spanned<ProfileCurve>, SceneError> {
    let keyword = parser.lexer.peek();
    let (block, basis) = match keyword.text {
        "BezierCurve" => (&BEZIER_PROFILE, CurveBasis::Bezier),
        "BsplineCurve" => (&BSPLINE_PROFILE, CurveBasis::Bspline),
        "" => return Err(parser.unclosed()),
        text => {
            let message = format!("`profile` wants a curve, found `{}`", clip(text));
            let help = "write `profile BezierCurve { … }` or `profile BsplineCurve { … }`".to_owned();
            return Err(parser.lexer.error(keyword.span(), message, "a curve belongs here", help));
        }
    };
    parser.lexer.take(keyword);
    let f = fields(parser, keyword, block)?;
    Ok(Spanned::new(f.require("controls")?.curve_of(basis)?, keyword.span()))
}

impl<'a> Fields<'a> {
    /// Returns an error with its position at `span`.
    pub fn error(&self, span: Span, message: String, label: &str, help: String) -> SceneError {
        self.lexer.error(span, message, label, help)
    }

    /// Returns the field `name` if it is present.
    pub fn get(&self, name: &str) -> Option<PresentField<'_, 'a>> {
        debug_assert!(self.block.field(name).is_some(), "`{}` has no field `{name}`", self.block.keyword);
        let (field, word, value) = self.list.iter().find(|(field, ..)| field.name == name)?;
        Some(PresentField { fields: self, field, word: *word, value })
    }

    /// Returns the field `name`, which must be present.
    pub fn require(&self, name: &str) -> Result<PresentField<'_, 'a>, SceneError> {
        self.get(name).ok_or_else(|| {
            let alias = self.block.field(name).map_or("", |field| field.alias);
            let listed = if alias.is_empty() { format!("`{name}`") } else { format!("`{name}` or `{alias}`") };
            let message = format!("`{}` has no {listed}", self.keyword.text);
            self.error(self.keyword.span(), message, "this block", format!("add {listed} to it"))
        })
    }

    /// Returns the only field among `names` that is present; none or several are an error.
    pub fn one_of(&self, names: &[&str]) -> Result<PresentField<'_, 'a>, SceneError> {
        let mut found = self.list.iter().filter(|(field, ..)| names.contains(&field.name));
        let block = self.keyword.text;
        let listed = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" or ");
        let Some((field, word, value)) = found.next() else {
            let message = format!("`{block}` has no {listed}");
            return Err(self.error(self.keyword.span(), message, "this block", format!("add {listed} to it")));
        };
        if let Some((_, second, _)) = found.next() {
            let message = format!("`{block}` has both `{}` and `{}`", word.text, second.text);
            return Err(self.error(second.span(), message, "the second", format!("keep one of {listed}")));
        }
        Ok(PresentField { fields: self, field, word: *word, value })
    }

    /// Returns an error if a field among `names` is present. `rule` completes the help text after
    /// the name of the field.
    pub fn refuse(&self, names: &[&str], rule: &str) -> Result<(), SceneError> {
        names.iter().find_map(|name| self.get(name)).map_or(Ok(()), |field| field.ensure(false, rule))
    }

    /// Returns an error if the fields `first` and `second` are both present.
    pub fn exclude(&self, first: &str, second: &str) -> Result<(), SceneError> {
        match (self.get(first), self.get(second)) {
            (Some(_), Some(_)) => self.one_of(&[first, second]).map(|_| ()),
            _ => Ok(()),
        }
    }

    /// Returns the three numbers of the field `name`, or its default.
    pub fn vector(&self, name: &str) -> Result<DVec3, SceneError> {
        match self.default(name) {
            Some(default) => Ok(DVec3::from_slice(default)),
            None => self.require(name).map(|found| found.vector()),
        }
    }

    /// Returns the two numbers of the field `name`, or its default.
    pub fn pair(&self, name: &str) -> Result<DVec2, SceneError> {
        match self.default(name) {
            Some(default) => Ok(DVec2::from_slice(default)),
            None => self.require(name).map(|found| found.pair()),
        }
    }

    /// Returns the number of the field `name`, or its default.
    pub fn number(&self, name: &str) -> Result<f64, SceneError> {
        match self.default(name) {
            Some(default) => Ok(default[0]),
            None => self.require(name).map(|found| found.number()),
        }
    }

    /// Returns the whole number of the field `name`, or its default.
    pub fn whole(&self, name: &str) -> Result<u32, SceneError> {
        self.number(name).map(|number| number as u32)
    }

    /// Returns the word of the field `name`, or its default.
    pub fn word(&self, name: &str) -> Result<&str, SceneError> {
        match (self.get(name), self.block.field(name).map(|field| field.default)) {
            (Some(found), _) => Ok(&found.value.value.name),
            (None, Some(Default::Word(word))) => Ok(word),
            (None, _) => self.require(name).map(|_| ""),
        }
    }

    /// Returns the colour or texture of the field `name`, or its default.
    pub fn color_or_texture(&self, name: &str) -> Result<TexturedValue<DVec3>, SceneError> {
        match self.get(name).and_then(|found| found.texture()) {
            Some(texture) => Ok(TexturedValue::Texture(texture)),
            None => self.vector(name).map(TexturedValue::Plain),
        }
    }

    /// Returns the number or texture of the field `name`, or its default.
    pub fn number_or_texture(&self, name: &str) -> Result<TexturedValue<f64>, SceneError> {
        match self.get(name).and_then(|found| found.texture()) {
            Some(texture) => Ok(TexturedValue::Texture(texture)),
            None => self.number(name).map(TexturedValue::Plain),
        }
    }

    /// Returns the transform steps of the field `name`; empty if it is absent.
    pub fn maps(&self, name: &str) -> Vec<TransformStep> {
        self.get(name).map_or(Vec::new(), |found| found.value.value.maps.clone())
    }

    /// Returns the default numbers of an absent field; `None` if it is present or has none.
    fn default(&self, name: &str) -> Option<&'static [f64]> {
        match (self.get(name), self.block.field(name).map(|field| field.default)) {
            (None, Some(Default::Numbers(default))) => Some(default),
            _ => None,
        }
    }
}

impl<'a> PresentField<'_, 'a> {
    /// Returns the field's keyword as written.
    pub fn name(&self) -> &'a str {
        self.word.text
    }

    /// Returns the span of the value.
    pub fn span(&self) -> Span {
        self.value.span
    }

    /// Returns the value of a field with three numbers.
    pub fn vector(&self) -> DVec3 {
        self.value.numbers
    }

    /// Returns the value of a field with one number.
    pub fn number(&self) -> f64 {
        self.value.numbers.x
    }

    /// Returns the value of a field with two numbers.
    pub fn pair(&self) -> DVec2 {
        self.value.numbers.truncate()
    }

    /// Returns the value of a field that holds a name or path, with its span.
    pub fn text(&self) -> Spanned<String> {
        Spanned::new(self.value.name.clone(), self.value.span)
    }

    /// Returns the name of the texture that the field has in place of numbers; `None` for numbers.
    pub fn texture(&self) -> Option<Spanned<String>> {
        (!self.value.name.is_empty()).then(|| self.text())
    }

    /// Returns the curve of a profile field.
    pub fn curve(&self) -> ProfileCurve {
        ProfileCurve { basis: self.value.basis, controls: self.value.points.clone() }
    }

    /// Returns the curve whose control points are the value of this field.
    ///
    /// # Errors
    /// [`SceneError`] if the field holds fewer control points than `basis` needs.
    pub fn curve_of(&self, basis: CurveBasis) -> Result<ProfileCurve, SceneError> {
        let controls = self.value.points.clone();
        let fewest = match basis {
            CurveBasis::Bezier => 2,
            CurveBasis::Bspline => 4,
        };
        self.ensure(controls.len() >= fewest, &format!("must hold at least {fewest} points"))?;
        Ok(ProfileCurve { basis, controls })
    }

    /// Returns the control points of a surface, with weights.
    pub fn weighted_points(&self) -> &[DVec4] {
        &self.value.weighted
    }

    /// Returns the value of a field that holds a list of numbers.
    pub fn list(&self) -> &[f64] {
        &self.value.list
    }

    /// Returns an error at the value of this field unless `ok`.
    ///
    /// `rule` says what the value must be; the help text is the name of the field, then `rule`.
    pub fn ensure(&self, ok: bool, rule: &str) -> Result<(), SceneError> {
        if ok {
            return Ok(());
        }
        let (name, block) = (self.word.text, self.fields.keyword.text);
        let value = clip(self.fields.lexer.slice(self.value.span));
        let message = format!("`{name}` of `{block}` cannot be `{value}`");
        Err(self.fields.error(self.value.span, message, "not allowed", format!("`{name}` {rule}")))
    }

    /// Checks that the value is within the range and the words that the table of the block allows.
    fn check(&self) -> Result<(), SceneError> {
        let violation = match self.field.kind {
            Kind::Word(words) if !words.contains(&self.value.name.as_str()) => {
                let listed: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
                let joint = if listed.len() == 2 { " or " } else { ", " };
                let one_of = if listed.len() == 2 { "" } else { "one of " };
                Some(format!("must be {one_of}{}", listed.join(joint)))
            }
            Kind::ColorOrTexture | Kind::NumberOrTexture if !self.value.name.is_empty() => None,
            Kind::Point | Kind::Direction | Kind::Color | Kind::ColorOrTexture => {
                self.field.violation(&self.vector().to_array())
            }
            Kind::Pair => self.field.violation(&self.pair().to_array()),
            Kind::Number | Kind::NumberOrTexture | Kind::Whole => self.field.violation(&[self.number()]),
            Kind::Name
            | Kind::Word(_)
            | Kind::Curve
            | Kind::Points
            | Kind::WeightedPoints
            | Kind::Numbers
            | Kind::Maps => None,
        };
        violation.map_or(Ok(()), |rule| self.ensure(false, &rule))
    }
}
