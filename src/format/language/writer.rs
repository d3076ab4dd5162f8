//! Writes scene text, one field on each line.

use std::fmt::{Display, Formatter, Result};

use glam::{DVec2, DVec3, DVec4};

use super::schema::BlockSchema;
use super::text::{is_identifier, is_nonfinite_number};
use crate::format::span::Spanned;

/// Writer of indented lines of scene text.
pub(in crate::format) struct SceneWriter<'f, 'a> {
    out: &'f mut Formatter<'a>,
    indent_depth: usize,
    /// Schema of the current block: the block that was begun last, not counting blocks without a
    /// schema.
    ///
    /// Debug builds check that this schema has each field that is written.
    block: Option<&'static BlockSchema>,
}

impl<'f, 'a> SceneWriter<'f, 'a> {
    /// Returns a writer at the left margin.
    pub fn new(out: &'f mut Formatter<'a>) -> Self {
        Self { out, indent_depth: 0, block: None }
    }
}

impl SceneWriter<'_, '_> {
    /// Writes one line at the current indent.
    pub fn write_line(&mut self, text: impl Display) -> Result {
        writeln!(self.out, "{:1$}{text}", "", 4 * self.indent_depth)
    }

    /// Writes `keyword {`, and indents the lines that follow.
    pub fn begin_block(&mut self, keyword: impl Display) -> Result {
        self.write_line(format_args!("{keyword} {{"))?;
        self.indent_depth += 1;
        Ok(())
    }

    /// Reduces the indent, and writes the `}` of a block.
    pub fn end_block(&mut self) -> Result {
        self.indent_depth -= 1;
        self.write_line("}")
    }

    /// Writes the keyword of `block` and `{`. The caller then writes its fields.
    pub fn begin_schema_block(&mut self, block: &'static BlockSchema) -> Result {
        self.block = Some(block);
        self.begin_block(block.keyword)
    }

    /// Writes the keyword of `block`, the given `name` and `{`. The caller then writes the block's
    /// fields.
    pub fn begin_named_block(&mut self, block: &'static BlockSchema, name: &str) -> Result {
        self.block = Some(block);
        self.begin_block(format_args!("{} {}", block.keyword, QuotedUnlessIdentifier(name)))
    }

    /// Writes the line `name value`, the field `name` of the current block.
    pub fn write_field(&mut self, name: &str, value: impl Display) -> Result {
        debug_assert!(self.block.is_none_or(|block| block.find_field(name).is_some()), "no table has `{name}`");
        self.write_line(format_args!("{name} {value}"))
    }

    /// Writes the field `name` with one number.
    pub fn write_number(&mut self, name: &str, value: f64) -> Result {
        self.write_field(name, ShortestNumber(value))
    }

    /// Writes the field `name` with two numbers.
    pub fn write_vec2(&mut self, name: &str, value: DVec2) -> Result {
        self.write_field(name, SpacedNumbers(&value.to_array()))
    }

    /// Writes the field `name` with three numbers.
    pub fn write_vec3(&mut self, name: &str, value: DVec3) -> Result {
        self.write_field(name, SpacedNumbers(&value.to_array()))
    }

    /// Writes the field `name` with the name or path `value`.
    pub fn write_name_field(&mut self, name: &str, value: &str) -> Result {
        self.write_field(name, QuotedIfNeeded(value))
    }

    /// Writes the line `MaterialName name`, which sets the material of the objects that follow.
    pub fn write_material_name(&mut self, name: &str) -> Result {
        self.write_line(format_args!("MaterialName {}", QuotedIfNeeded(name)))
    }

    /// Writes the name of a texture as the value of the field `name`, which also accepts numbers.
    pub fn write_texture_name_field(&mut self, name: &str, texture: &Spanned<String>) -> Result {
        self.write_field(name, QuotedUnlessIdentifier(texture))
    }

    /// Writes the field `name` with `points`, one on each line.
    pub fn write_points(&mut self, name: &str, points: &[DVec3]) -> Result {
        self.write_line(name)?;
        points.iter().try_for_each(|p| self.write_line(format_args!("    [ {} ]", SpacedNumbers(&p.to_array()))))
    }

    /// Writes the field `name` with weighted points, one on each line. Omits the weights if all are
    /// 1.
    pub fn write_weighted_points(&mut self, name: &str, points: &[DVec4]) -> Result {
        self.write_line(name)?;
        let numbers = if points.iter().all(|p| p.w == 1.0) { 3 } else { 4 };
        points
            .iter()
            .try_for_each(|p| self.write_line(format_args!("    [ {} ]", SpacedNumbers(&p.to_array()[..numbers]))))
    }
}

/// Displays a number as the shortest decimal text that parses to the same number.
///
/// An exponent is used if the magnitude is below 1e-5 but not 0, or if it is 1e16 or more.
struct ShortestNumber(f64);

impl Display for ShortestNumber {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.0.abs() {
            0.0 | 1e-5..1e16 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

/// Displays numbers, separated by spaces.
pub(in crate::format) struct SpacedNumbers<'a>(pub &'a [f64]);

impl Display for SpacedNumbers<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, number) in self.0.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}{}", ShortestNumber(*number))?;
        }
        Ok(())
    }
}

/// Displays a path or name. Puts it in quotes only if the parser would misread it without them.
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

/// Displays the name of a texture or block, in quotes unless it is an identifier.
///
/// Without quotes, the parser could take other words at this place for a number or for `{`.
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

/// Displays a string in quotes, with a backslash before each quote and backslash.
struct QuotedString<'a>(&'a str);

impl Display for QuotedString<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "\"{}\"", self.0.replace('\\', "\\\\").replace('"', "\\\""))
    }
}
