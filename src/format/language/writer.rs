//! Printing of scene text, one line a field.

use std::fmt::{Display, Formatter, Result};

use glam::{DVec2, DVec3, DVec4};

use super::super::description::{Spanned, TexturedValue};
use super::schema::BlockSchema;
use super::text::{is_identifier, is_nonfinite_number};

/// Prints indented lines of scene text.
pub(super) struct SceneWriter<'f, 'a> {
    out: &'f mut Formatter<'a>,
    depth: usize,
    /// The block whose fields are printed; its table must know them.
    block: Option<&'static BlockSchema>,
}

impl<'f, 'a> SceneWriter<'f, 'a> {
    /// A writer at the left margin.
    pub fn new(out: &'f mut Formatter<'a>) -> Self {
        Self { out, depth: 0, block: None }
    }
}

impl SceneWriter<'_, '_> {
    /// Prints one line.
    pub fn write_line(&mut self, text: impl Display) -> Result {
        writeln!(self.out, "{:1$}{text}", "", 4 * self.depth)
    }

    /// Prints the start of a block without a table.
    pub fn begin_block(&mut self, keyword: impl Display) -> Result {
        self.write_line(format_args!("{keyword} {{"))?;
        self.depth += 1;
        Ok(())
    }

    /// Prints the end of a block.
    pub fn end_block(&mut self) -> Result {
        self.depth -= 1;
        self.write_line("}")
    }

    /// Prints the start of `block`; the fields that follow are its own.
    pub fn begin_table_block(&mut self, block: &'static BlockSchema) -> Result {
        self.block = Some(block);
        self.begin_block(block.keyword)
    }

    /// Prints the start of `block` with the name of the texture, medium or material.
    pub fn begin_named_block(&mut self, block: &'static BlockSchema, name: &str) -> Result {
        self.block = Some(block);
        self.begin_block(format_args!("{} {}", block.keyword, QuotedUnlessIdentifier(name)))
    }

    /// Prints the field `name`.
    pub fn write_field(&mut self, name: &str, value: impl Display) -> Result {
        debug_assert!(self.block.is_none_or(|block| block.find_field(name).is_some()), "no table has `{name}`");
        self.write_line(format_args!("{name} {value}"))
    }

    /// Prints a field of one number.
    pub fn write_number(&mut self, name: &str, value: f64) -> Result {
        self.write_field(name, ShortestNumber(value))
    }

    /// Prints a field of two numbers.
    pub fn write_pair(&mut self, name: &str, value: DVec2) -> Result {
        self.write_field(name, SpacedNumbers(&value.to_array()))
    }

    /// Prints a field of three numbers.
    pub fn write_vector(&mut self, name: &str, value: DVec3) -> Result {
        self.write_field(name, SpacedNumbers(&value.to_array()))
    }

    /// Prints a field of a name or path.
    pub fn write_name(&mut self, name: &str, value: &str) -> Result {
        self.write_field(name, QuotedIfNeeded(value))
    }

    /// Prints the material in force for the objects that follow.
    pub fn write_material_name(&mut self, name: &str) -> Result {
        self.write_line(format_args!("MaterialName {}", QuotedIfNeeded(name)))
    }

    /// Prints a field of a colour or texture.
    pub fn write_color_or_texture(&mut self, name: &str, value: &TexturedValue<DVec3>) -> Result {
        match value {
            TexturedValue::Plain(value) => self.write_vector(name, *value),
            TexturedValue::Texture(texture) => self.write_texture_name(name, texture),
        }
    }

    /// Prints a field of a number or texture.
    pub fn write_number_or_texture(&mut self, name: &str, value: &TexturedValue<f64>) -> Result {
        match value {
            TexturedValue::Plain(value) => self.write_number(name, *value),
            TexturedValue::Texture(texture) => self.write_texture_name(name, texture),
        }
    }

    /// Prints a field of a texture where numbers may stand too.
    pub fn write_texture_name(&mut self, name: &str, texture: &Spanned<String>) -> Result {
        self.write_field(name, QuotedUnlessIdentifier(texture))
    }

    /// Prints the points of a curve, a line each.
    pub fn write_points(&mut self, name: &str, points: &[DVec3]) -> Result {
        self.write_line(name)?;
        points.iter().try_for_each(|p| self.write_line(format_args!("    [ {} ]", SpacedNumbers(&p.to_array()))))
    }

    /// Prints the points of a net, a line each; with their weights unless all are 1.
    pub fn write_weighted_points(&mut self, name: &str, points: &[DVec4]) -> Result {
        self.write_line(name)?;
        let numbers = if points.iter().all(|p| p.w == 1.0) { 3 } else { 4 };
        points
            .iter()
            .try_for_each(|p| self.write_line(format_args!("    [ {} ]", SpacedNumbers(&p.to_array()[..numbers]))))
    }
}

/// The shortest text that reads back as the same number; by exponent if that is far from 1.
struct ShortestNumber(f64);

impl Display for ShortestNumber {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.0.abs() {
            0.0 | 1e-5..1e16 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

/// SpacedNumbers separated by spaces.
pub(super) struct SpacedNumbers<'a>(pub &'a [f64]);

impl Display for SpacedNumbers<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, number) in self.0.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}{}", ShortestNumber(*number))?;
        }
        Ok(())
    }
}

/// A path or name; in quotes only where it would not read back without.
struct QuotedIfNeeded<'a>(&'a str);

impl Display for QuotedIfNeeded<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let name = self.0;
        let plain = |c: char| !c.is_whitespace() && !c.is_control() && !"\"{}".contains(c);
        let comment = name.starts_with('#') || name.starts_with("//");
        if !name.is_empty() && !comment && name.chars().all(plain) {
            f.write_str(name)
        } else {
            QuotedString(name).fmt(f)
        }
    }
}

/// A name where numbers or `{` may stand too; in quotes unless it is an identifier.
struct QuotedUnlessIdentifier<'a>(&'a str);

impl Display for QuotedUnlessIdentifier<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if is_identifier(self.0) && !is_nonfinite_number(self.0) {
            f.write_str(self.0)
        } else {
            QuotedString(self.0).fmt(f)
        }
    }
}

/// A name in quotes.
struct QuotedString<'a>(&'a str);

impl Display for QuotedString<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "\"{}\"", self.0.replace('\\', "\\\\").replace('"', "\\\""))
    }
}
