//! Transforms and motions: maps, then what they place.

use glam::{DMat4, DVec3};

use super::super::description::{Map, Object, Span, Spanned};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::Parser;
use super::objects::OBJECTS;
use crate::math::Transform;

const MAPS: [&str; 9] =
    ["Scale", "UniformScale", "Translate", "XRotate", "YRotate", "ZRotate", "Rotate", "Matrix4f", "Matrix"];

/// Maps, and what stands after them.
type Placed<T> = (Vec<Map>, T);

/// Reads what a keyword begins.
type Reader<'a, T> = fn(&mut Parser<'a>, Token<'a>) -> Result<T, SceneError>;

impl<'a> Parser<'a> {
    pub fn transform(&mut self, keyword: Token<'a>) -> Result<Placed<Box<Spanned<Object>>>, SceneError> {
        let placed = self.placed(keyword, &OBJECTS, Self::boxed)?;
        self.check_transform(keyword, &placed.0)?;
        Ok(placed)
    }

    /// What a `Moving` block holds: maps that grow while the shutter is open, then what they move, one of `known`.
    pub fn moving<T>(
        &mut self,
        keyword: Token<'a>,
        known: &[&str],
        read: Reader<'a, T>,
    ) -> Result<Placed<T>, SceneError> {
        let placed = self.placed(keyword, known, read)?;
        self.check_motion(keyword, &placed.0)?;
        Ok(placed)
    }

    /// Maps, then one thing of those `known`.
    fn placed<T>(&mut self, keyword: Token<'a>, known: &[&str], read: Reader<'a, T>) -> Result<Placed<T>, SceneError> {
        self.descend(keyword)?;
        let mut maps = Vec::new();
        let word = self.maps(keyword, known, &mut maps)?;
        let placed = read(self, word)?;
        self.end(keyword)?;
        Ok((maps, placed))
    }

    // What follows stands apart from `placed`, so that what nests keeps small frames on the stack.

    /// Reads maps up to a word of those `known`.
    #[inline(never)]
    fn maps(&mut self, keyword: Token<'a>, known: &[&str], maps: &mut Vec<Map>) -> Result<Token<'a>, SceneError> {
        let name = keyword.text;
        loop {
            match self.word()? {
                None => {
                    let what = if known.contains(&"Sphere") { "object" } else { "camera or light" };
                    let message = format!("`{name}` holds no {what}");
                    let last = if known.contains(&"Sphere") { "Sphere" } else { known[known.len() - 1] };
                    let help = format!("put one after its maps: `{name} {{ Translate 2 2 2 {last} {{ … }} }}`");
                    return Err(self.lexer.error(keyword.span(), message, "this block", help));
                }
                Some(word) if MAPS.contains(&word.text) => maps.push(self.map(word)?),
                Some(word) if known.contains(&word.text) => return Ok(word),
                Some(word) => return Err(self.unexpected(word, &[&MAPS[..], known].concat())),
            }
        }
    }

    /// The maps of a block that places nothing.
    pub fn maps_alone(&mut self, keyword: Token<'a>) -> Result<Vec<Map>, SceneError> {
        let mut maps = Vec::new();
        self.open(keyword)?;
        while let Some(word) = self.word()? {
            if !MAPS.contains(&word.text) {
                return Err(self.unexpected(word, &MAPS));
            }
            maps.push(self.map(word)?);
        }
        self.check_transform(keyword, &maps)?;
        Ok(maps)
    }

    /// Reads the end of a block that has placed something.
    #[inline(never)]
    fn end(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
        if let Some(word) = self.word()? {
            let message = format!("unexpected `{}` after what `{}` places", super::clip(word.text), keyword.text);
            let help = "maps stand before it; put several objects into a Group".to_owned();
            return Err(self.lexer.error(word.span(), message, "`}` belongs here", help));
        }
        self.depth -= 1;
        Ok(())
    }

    #[inline(never)]
    fn check_transform(&self, keyword: Token<'a>, maps: &[Map]) -> Result<(), SceneError> {
        match Transform::new(Map::product(maps)) {
            Ok(_) => Ok(()),
            Err(_) => Err(self.singular(keyword.span(), "this `Transform` flattens its object")),
        }
    }

    #[inline(never)]
    fn check_motion(&self, keyword: Token<'a>, maps: &[Map]) -> Result<(), SceneError> {
        const THROUGH_FLAT: (&str, &str) =
            ("a scale of 0 or below", "a motion cannot go through flat: scale by more than 0");
        for map in maps {
            let (what, help) = match *map {
                Map::Matrix(_) => {
                    ("a matrix", "write Translate, Rotate and Scale instead, or put it into a Transform inside")
                }
                Map::Scale(s) if s.min_element() <= 0.0 => THROUGH_FLAT,
                Map::UniformScale(s) if s <= 0.0 => THROUGH_FLAT,
                _ => continue,
            };
            let message = format!("`{}` cannot grow by {what}", keyword.text);
            return Err(self.lexer.error(keyword.span(), message, "this motion", help.to_owned()));
        }
        Ok(())
    }

    #[inline(never)]
    fn map(&mut self, word: Token<'a>) -> Result<Map, SceneError> {
        let (map, span) = match word.text {
            "Scale" | "Translate" => {
                let v = self.numbers(word)?;
                let vector = DVec3::from_array(v.value);
                (if word.text == "Scale" { Map::Scale(vector) } else { Map::Translate(vector) }, v.span)
            }
            "Rotate" => {
                self.open(word)?;
                let v = self.numbers::<4>(word)?;
                let [x, y, z, angle] = v.value;
                let axis = DVec3::new(x, y, z);
                self.close()?;
                if !super::has_direction(axis) {
                    let message = "the axis of `Rotate` must have a length above 0 (and below 1e154)".to_owned();
                    let help = "write axis and degrees: `Rotate { 0 1 0 90 }`".to_owned();
                    return Err(self.lexer.error(v.span, message, "this axis", help));
                }
                (Map::Rotate { axis, angle }, v.span)
            }
            "Matrix4f" | "Matrix" => {
                self.open(word)?;
                let m = self.numbers::<16>(word)?;
                self.close()?;
                let matrix = DMat4::from_cols_array(&m.value);
                if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
                    let message = format!("the fourth row of `{}` must be 0 0 0 1", word.text);
                    let help = "columns are listed one after the other: every fourth number is 0, the last is 1";
                    return Err(self.lexer.error(m.span, message, "this matrix", help.to_owned()));
                }
                (Map::Matrix(matrix), m.span)
            }
            _ => {
                let v = self.numbers::<1>(word)?;
                let map = match (word.text, v.value[0]) {
                    ("XRotate", angle) => Map::RotateX(angle),
                    ("YRotate", angle) => Map::RotateY(angle),
                    ("ZRotate", angle) => Map::RotateZ(angle),
                    (_, scale) => Map::UniformScale(scale),
                };
                (map, v.span)
            }
        };
        match Transform::new(map.matrix()) {
            Ok(_) => Ok(map),
            Err(_) => Err(self.singular(span, &format!("`{}` flattens its object", word.text))),
        }
    }

    fn singular(&self, span: Span, message: &str) -> SceneError {
        let help = "scales must not be 0, nor the columns of a matrix lie in one plane; for flat shapes use Disc, \
                    Rectangle or Triangle";
        self.lexer.error(span, message.to_owned(), "singular", help.to_owned())
    }
}
