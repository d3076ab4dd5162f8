//! Blocks of named fields in any order.

use glam::{DVec2, DVec3, DVec4};

use super::super::description::{Curve, CurveBasis, Emission, Map, Span, Spanned, Value as Textured};
use super::super::error::SceneError;
use super::super::lexer::{Lexer, Token};
use super::{Parser, clip, has_direction, suggest};

/// What single precision holds.
const LARGEST: f64 = f32::MAX as f64;

const TOO_LARGE: &str = "must be below 3.4e38, which single precision holds: choose other units";

/// What single precision holds, also times densities and lengths.
pub(super) const DENSEST: f64 = 1e12;

/// What follows a field's name.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// Three numbers.
    Vector,
    /// Three numbers, or the name of a texture.
    Tint,
    /// A number.
    Number,
    /// A number, or the name of a texture.
    Degree,
    /// Two numbers.
    Pair,
    /// A whole number.
    Integer,
    /// A path or name, quoted or bare.
    Name,
    /// A curve block.
    Curve,
    /// Points in brackets.
    Controls,
    /// Points in brackets, which may have a weight.
    Net,
    /// Any number of numbers.
    Numbers,
    /// Maps in braces.
    Maps,
}

/// What followed a field's name: only the part that its kind fills.
#[derive(Default)]
struct Value {
    numbers: DVec3,
    /// Of a texture too, where it stands for numbers.
    name: String,
    maps: Vec<Map>,
    basis: CurveBasis,
    controls: Vec<DVec3>,
    net: Vec<DVec4>,
    list: Vec<f64>,
}

/// The fields of a block that has been read to its end.
pub(super) struct Fields<'a> {
    lexer: Lexer<'a>,
    block: Token<'a>,
    list: Vec<(Token<'a>, Spanned<Value>)>,
}

/// A field that is there.
#[derive(Clone, Copy)]
pub(super) struct Found<'f, 'a> {
    fields: &'f Fields<'a>,
    word: Token<'a>,
    value: &'f Spanned<Value>,
}

impl<'a> Parser<'a> {
    /// Reads `{ … }` with the fields that `known` lists, each at most once.
    pub fn fields(&mut self, block: Token<'a>, known: &[(&str, Kind)]) -> Result<Fields<'a>, SceneError> {
        let mut list: Vec<(Token<'a>, Spanned<Value>)> = Vec::new();
        self.open(block)?;
        while let Some(word) = self.word()? {
            let Some(&(_, kind)) = known.iter().find(|(name, _)| *name == word.text) else {
                let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
                return Err(self.unexpected(word, &names));
            };
            if list.iter().any(|(earlier, _)| earlier.text == word.text) {
                return Err(self.twice(word));
            }
            list.push((word, self.value(word, kind)?));
        }
        Ok(Fields { lexer: self.lexer, block, list })
    }

    fn value(&mut self, word: Token<'a>, kind: Kind) -> Result<Spanned<Value>, SceneError> {
        let mut value = Value::default();
        let span = match kind {
            Kind::Tint | Kind::Degree if self.names_follow() => {
                let read = self.texture_by_name(word)?;
                value.name = read.value;
                read.span
            }
            Kind::Pair => {
                let read = self.numbers::<2>(word)?;
                value.numbers = DVec2::from_array(read.value).extend(0.0);
                read.span
            }
            Kind::Maps => {
                value.maps = self.maps_alone(word)?;
                word.span()
            }
            Kind::Vector | Kind::Tint => {
                let read = self.numbers(word)?;
                value.numbers = DVec3::from_array(read.value);
                read.span
            }
            Kind::Number | Kind::Degree => {
                let read = self.numbers::<1>(word)?;
                value.numbers.x = read.value[0];
                read.span
            }
            Kind::Integer => {
                let read = self.integer(word)?;
                value.numbers.x = f64::from(read.value);
                read.span
            }
            Kind::Name => {
                let read = self.name(word)?;
                value.name = read.value;
                read.span
            }
            Kind::Curve => {
                let read = self.profile()?;
                (value.basis, value.controls) = (read.value.basis, read.value.controls);
                read.span
            }
            Kind::Controls => {
                value.controls = self.controls(word)?;
                word.span()
            }
            Kind::Net => {
                value.net = self.net(word)?;
                word.span()
            }
            Kind::Numbers => {
                let mut span = None;
                while !{ self.lexer }.number().is_end() {
                    let read = self.numbers::<1>(word)?;
                    value.list.push(read.value[0]);
                    let start = span.map_or(read.span.start, |s: Span| s.start);
                    span = Some(Span { start, len: read.span.start + read.span.len - start });
                }
                span.unwrap_or(word.span())
            }
        };
        Ok(Spanned::new(value, span))
    }

    /// Whether a name comes next, where numbers may come too.
    fn names_follow(&mut self) -> bool {
        let token = self.lexer.peek();
        let number = ["nan", "inf", "infinity"].contains(&token.text.to_ascii_lowercase().as_str());
        token.text.starts_with(|c: char| c == '"' || c == '_' || c.is_ascii_alphabetic()) && !number
    }

    fn texture_by_name(&mut self, owner: Token<'a>) -> Result<Spanned<String>, SceneError> {
        let name = self.name(owner)?;
        if self.textures.iter().any(|texture| texture.value.name == name.value) {
            return Ok(name);
        }
        let message = format!("no texture is called `{}`", clip(&name.value));
        let nearest = suggest::nearest(&name.value, self.textures.iter().map(|t| t.value.name.as_str()));
        let help = match nearest {
            Some(nearest) => format!("did you mean `{}`?", clip(nearest)),
            None => "write numbers, or define it ahead of the Materials: `Textures { Checker name { … } }`".to_owned(),
        };
        Err(self.lexer.error(name.span, message, "unknown name", help))
    }

    /// A path or name after `owner`, quoted or bare.
    pub fn name(&mut self, owner: Token<'a>) -> Result<Spanned<String>, SceneError> {
        let read = self.lexer.name()?;
        if !read.value.is_empty() {
            return Ok(read);
        }
        let token = self.lexer.peek();
        if token.is_end() && read.span.len == 0 {
            return Err(self.unclosed());
        }
        let span = if read.span.len == 0 { token.span() } else { read.span };
        let name = owner.text;
        let help = format!("write a name after `{name}`, in quotes if it holds spaces");
        Err(self.lexer.error(span, format!("`{name}` wants a name"), "a name belongs here", help))
    }

    fn controls(&mut self, word: Token<'a>) -> Result<Vec<DVec3>, SceneError> {
        let mut controls = Vec::new();
        while self.lexer.peek().text == "[" {
            self.punctuation("[")?;
            controls.push(DVec3::from_array(self.numbers(word)?.value));
            self.punctuation("]")?;
        }
        Ok(controls)
    }
}

impl<'a> Parser<'a> {
    /// Points of three numbers and a weight, which is 1 where it is left out.
    fn net(&mut self, word: Token<'a>) -> Result<Vec<DVec4>, SceneError> {
        let mut net = Vec::new();
        while self.lexer.peek().text == "[" {
            self.punctuation("[")?;
            let point = DVec3::from_array(self.numbers(word)?.value);
            let mut weight = 1.0;
            if self.lexer.peek().text != "]" {
                let read = self.numbers::<1>(word)?;
                weight = read.value[0];
                if weight <= 0.0 {
                    let message = format!("the weight of a point of `{}` cannot be `{weight}`", word.text);
                    let help = "weights are above 0; write `[ x y z ]` or `[ x y z weight ]`".to_owned();
                    return Err(self.lexer.error(read.span, message, "not allowed", help));
                }
            }
            self.punctuation("]")?;
            net.push(point.extend(weight));
        }
        Ok(net)
    }
}

impl<'a> Fields<'a> {
    pub fn error(&self, span: Span, message: String, label: &str, help: String) -> SceneError {
        self.lexer.error(span, message, label, help)
    }

    pub fn get(&self, name: &str) -> Option<Found<'_, 'a>> {
        let (word, value) = self.list.iter().find(|(word, _)| word.text == name)?;
        Some(Found { fields: self, word: *word, value })
    }

    pub fn need(&self, name: &str) -> Result<Found<'_, 'a>, SceneError> {
        self.get(name).ok_or_else(|| {
            let message = format!("`{}` has no `{name}`", self.block.text);
            self.error(self.block.span(), message, "this block", format!("add `{name}` to it"))
        })
    }

    /// The one field of `names` that is there.
    pub fn one_of(&self, names: &[&str]) -> Result<Found<'_, 'a>, SceneError> {
        let mut found = self.list.iter().filter(|(word, _)| names.contains(&word.text));
        let block = self.block.text;
        let listed = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" or ");
        let Some((word, value)) = found.next() else {
            let message = format!("`{block}` has no {listed}");
            return Err(self.error(self.block.span(), message, "this block", format!("add {listed} to it")));
        };
        if let Some((second, _)) = found.next() {
            let message = format!("`{block}` has both `{}` and `{}`", word.text, second.text);
            return Err(self.error(second.span(), message, "the second", format!("keep one of {listed}")));
        }
        Ok(Found { fields: self, word: *word, value })
    }

    /// `emission`, on shapes.
    pub fn emission(&self) -> Result<Option<DVec3>, SceneError> {
        self.get("emission").map(|emission| emission.colour()).transpose()
    }

    /// `emission` and `emissionScale`, on materials.
    pub fn emission_or_texture(&self) -> Result<Option<Emission>, SceneError> {
        let (emission, scale) = (self.get("emission"), self.get("emissionScale"));
        let name = emission.and_then(|e| e.texture());
        match (emission, scale) {
            (_, Some(scale)) if name.is_none() => {
                scale.ensure(false, "says nothing without a texture as `emission`")?;
            }
            (_, Some(scale)) => drop(scale.amount()?),
            _ => {}
        }
        let plain = |emission: Found<'_, 'a>| emission.colour().map(Emission::Radiance);
        match name {
            Some(name) => Ok(Some(Emission::Texture { name, scale: scale.map_or(1.0, |s| s.number()) })),
            None => emission.map(plain).transpose(),
        }
    }
}

impl<'a> Found<'_, 'a> {
    pub fn name(&self) -> &'a str {
        self.word.text
    }

    /// Where the value stands.
    pub fn span(&self) -> Span {
        self.value.span
    }

    pub fn vector(&self) -> DVec3 {
        self.value.numbers
    }

    pub fn number(&self) -> f64 {
        self.value.numbers.x
    }

    pub fn pair(&self) -> DVec2 {
        self.value.numbers.truncate()
    }

    pub fn maps(&self) -> Vec<Map> {
        self.value.maps.clone()
    }

    /// The name of the texture that stands for numbers.
    pub fn texture(&self) -> Option<Spanned<String>> {
        (!self.value.name.is_empty()).then(|| self.text())
    }

    /// What is `read` of its numbers, or its texture.
    pub fn or_texture<T>(&self, read: impl FnOnce(&Self) -> Result<T, SceneError>) -> Result<Textured<T>, SceneError> {
        self.texture().map_or_else(|| read(self).map(Textured::Plain), |name| Ok(Textured::Texture(name)))
    }

    pub fn text(&self) -> Spanned<String> {
        Spanned::new(self.value.name.clone(), self.value.span)
    }

    /// The curve of a profile field.
    pub fn curve(&self) -> Curve {
        Curve { basis: self.value.basis, controls: self.value.controls.clone() }
    }

    /// A curve of these control points; too few are an error.
    pub fn controls(&self, basis: CurveBasis) -> Result<Curve, SceneError> {
        let controls = self.value.controls.clone();
        let (fewest, rule) = match basis {
            CurveBasis::Bezier => (2, "must hold at least 2 points"),
            CurveBasis::Bspline => (4, "must hold at least 4 points"),
        };
        self.ensure(controls.len() >= fewest, rule)?;
        Ok(Curve { basis, controls })
    }

    /// The points of a net.
    pub fn net(&self) -> &[DVec4] {
        &self.value.net
    }

    /// Numbers in a row.
    pub fn list(&self) -> &[f64] {
        &self.value.list
    }

    /// An error at the value unless `ok`; `rule` goes on from the field's name and says what would be right.
    pub fn ensure(&self, ok: bool, rule: &str) -> Result<(), SceneError> {
        if ok {
            return Ok(());
        }
        let (name, block) = (self.word.text, self.fields.block.text);
        let value = clip(self.fields.lexer.slice(self.value.span));
        let message = format!("`{name}` of `{block}` cannot be `{value}`");
        Err(self.fields.error(self.value.span, message, "not allowed", format!("`{name}` {rule}")))
    }

    pub fn positive(&self) -> Result<f64, SceneError> {
        self.ensure(self.number() > 0.0, "must be above 0")?;
        self.fits()
    }

    /// A number of 0 or more.
    pub fn amount(&self) -> Result<f64, SceneError> {
        self.ensure(self.number() >= 0.0, "must not be negative")?;
        self.fits()
    }

    /// A number that single precision holds.
    pub fn fits(&self) -> Result<f64, SceneError> {
        self.ensure(self.number().abs() <= LARGEST, TOO_LARGE)?;
        Ok(self.number())
    }

    /// A colour, radiance, or other spectrum.
    pub fn colour(&self) -> Result<DVec3, SceneError> {
        self.ensure(self.vector().min_element() >= 0.0, "must not be negative")?;
        self.ensure(self.vector().max_element() <= LARGEST, TOO_LARGE)?;
        Ok(self.vector())
    }

    /// Something per length.
    pub fn coefficient(&self) -> Result<DVec3, SceneError> {
        let ok = self.vector().min_element() >= 0.0 && self.vector().max_element() <= DENSEST;
        self.ensure(ok, "must lie between 0 and 1e12 in each component")?;
        Ok(self.vector())
    }

    /// A colour that sends back at most the light that comes.
    pub fn reflectance(&self) -> Result<DVec3, SceneError> {
        let ok = self.vector().min_element() >= 0.0 && self.vector().max_element() <= 1.0;
        self.ensure(ok, "must lie between 0 and 1 in each component")?;
        Ok(self.vector())
    }

    /// A vector whose length does not matter, but must not be 0.
    pub fn direction(&self) -> Result<DVec3, SceneError> {
        self.ensure(has_direction(self.vector()), "must have a length above 0 (and below 1e154)")?;
        Ok(self.vector())
    }
}
