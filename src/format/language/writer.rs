//! Printing of scene text, one line a field.

use std::fmt::{Display, Formatter, Result};

use glam::{DVec2, DVec3, DVec4};

use super::super::description::{Spanned, TexturedValue};
use super::schema::Block;
use super::text::{is_identifier, is_number_word};

/// Prints indented lines of scene text.
pub(super) struct Writer<'f, 'a> {
    out: &'f mut Formatter<'a>,
    depth: usize,
    /// The block whose fields are printed; its table must know them.
    block: Option<&'static Block>,
}

impl<'f, 'a> Writer<'f, 'a> {
    /// A writer at the left margin.
    pub fn new(out: &'f mut Formatter<'a>) -> Self {
        Self { out, depth: 0, block: None }
    }
}

impl Writer<'_, '_> {
    /// Prints one line.
    pub fn line(&mut self, text: impl Display) -> Result {
        writeln!(self.out, "{:1$}{text}", "", 4 * self.depth)
    }

    /// Prints the start of a block without a table.
    pub fn open(&mut self, keyword: impl Display) -> Result {
        self.line(format_args!("{keyword} {{"))?;
        self.depth += 1;
        Ok(())
    }

    /// Prints the end of a block.
    pub fn close(&mut self) -> Result {
        self.depth -= 1;
        self.line("}")
    }

    /// Prints the start of `block`; the fields that follow are its own.
    pub fn start(&mut self, block: &'static Block) -> Result {
        self.block = Some(block);
        self.open(block.keyword)
    }

    /// Prints the start of `block` with the name of the texture, medium or material.
    pub fn start_named(&mut self, block: &'static Block, name: &str) -> Result {
        self.block = Some(block);
        self.open(format_args!("{} {}", block.keyword, Reference(name)))
    }

    /// Prints the field `name`.
    pub fn field(&mut self, name: &str, value: impl Display) -> Result {
        debug_assert!(self.block.is_none_or(|block| block.field(name).is_some()), "no table has `{name}`");
        self.line(format_args!("{name} {value}"))
    }

    /// Prints a field of one number.
    pub fn number(&mut self, name: &str, value: f64) -> Result {
        self.field(name, Number(value))
    }

    /// Prints a field of two numbers.
    pub fn pair(&mut self, name: &str, value: DVec2) -> Result {
        self.field(name, Numbers(&value.to_array()))
    }

    /// Prints a field of three numbers.
    pub fn vector(&mut self, name: &str, value: DVec3) -> Result {
        self.field(name, Numbers(&value.to_array()))
    }

    /// Prints a field of a name or path.
    pub fn name(&mut self, name: &str, value: &str) -> Result {
        self.field(name, Name(value))
    }

    /// Prints the material in force for the objects that follow.
    pub fn material_name(&mut self, name: &str) -> Result {
        self.line(format_args!("MaterialName {}", Name(name)))
    }

    /// Prints a field of a colour or texture.
    pub fn color_or_texture(&mut self, name: &str, value: &TexturedValue<DVec3>) -> Result {
        match value {
            TexturedValue::Plain(value) => self.vector(name, *value),
            TexturedValue::Texture(texture) => self.texture(name, texture),
        }
    }

    /// Prints a field of a number or texture.
    pub fn number_or_texture(&mut self, name: &str, value: &TexturedValue<f64>) -> Result {
        match value {
            TexturedValue::Plain(value) => self.number(name, *value),
            TexturedValue::Texture(texture) => self.texture(name, texture),
        }
    }

    /// Prints a field of a texture where numbers may stand too.
    pub fn texture(&mut self, name: &str, texture: &Spanned<String>) -> Result {
        self.field(name, Reference(texture))
    }

    /// Prints the points of a curve, a line each.
    pub fn points(&mut self, name: &str, points: &[DVec3]) -> Result {
        self.line(name)?;
        points.iter().try_for_each(|p| self.line(format_args!("    [ {} ]", Numbers(&p.to_array()))))
    }

    /// Prints the points of a net, a line each; with their weights unless all are 1.
    pub fn weighted_points(&mut self, name: &str, points: &[DVec4]) -> Result {
        self.line(name)?;
        let numbers = if points.iter().all(|p| p.w == 1.0) { 3 } else { 4 };
        points.iter().try_for_each(|p| self.line(format_args!("    [ {} ]", Numbers(&p.to_array()[..numbers]))))
    }
}

/// The shortest text that reads back as the same number; by exponent if that is far from 1.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.0.abs() {
            0.0 | 1e-5..1e16 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

/// Numbers separated by spaces.
pub(super) struct Numbers<'a>(pub &'a [f64]);

impl Display for Numbers<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, number) in self.0.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}{}", Number(*number))?;
        }
        Ok(())
    }
}

/// A path or name; in quotes only where it would not read back without.
struct Name<'a>(&'a str);

impl Display for Name<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let name = self.0;
        let plain = |c: char| !c.is_whitespace() && !c.is_control() && !"\"{}".contains(c);
        let comment = name.starts_with('#') || name.starts_with("//");
        if !name.is_empty() && !comment && name.chars().all(plain) { f.write_str(name) } else { Quoted(name).fmt(f) }
    }
}

/// A name where numbers or `{` may stand too; in quotes unless it is an identifier.
struct Reference<'a>(&'a str);

impl Display for Reference<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if is_identifier(self.0) && !is_number_word(self.0) { f.write_str(self.0) } else { Quoted(self.0).fmt(f) }
    }
}

/// A name in quotes.
struct Quoted<'a>(&'a str);

impl Display for Quoted<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "\"{}\"", self.0.replace('\\', "\\\\").replace('"', "\\\""))
    }
}
