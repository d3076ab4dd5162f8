//! Tables of the scene language: which blocks exist, their fields, units, ranges, defaults and
//! help.
//!
//! The reader checks values by these tables, the writer takes keywords from them, and the reference
//! part of `docs/guide/scene-language.md` is printed from them.

use std::fmt::Write;

use glam::DVec3;

use super::text::has_direction;

/// Largest value that single precision holds.
const LARGEST: f64 = f32::MAX as f64;

/// Largest coefficient per length: its products with densities and lengths still fit single
/// precision.
pub(super) const MAX_COEFFICIENT: f64 = 1e12;

/// Type of the value that follows a field's name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Three numbers: a position or an offset.
    Point,
    /// Three numbers of any length above 0.
    Direction,
    /// Three numbers: linear RGB.
    Color,
    /// Linear RGB, or the name of a texture.
    ColorOrTexture,
    /// One number.
    Number,
    /// One number, or the name of a texture.
    NumberOrTexture,
    /// Two numbers.
    Pair,
    /// A whole number from 0 to 2³² − 1.
    Whole,
    /// A path or name, quoted or bare.
    Name,
    /// One of the listed words.
    Word(&'static [&'static str]),
    /// A `BezierCurve` or `BsplineCurve` block.
    Curve,
    /// Points in brackets, `[ x y z ]`.
    Points,
    /// Points in brackets with an optional weight, `[ x y z w ]`.
    WeightedPoints,
    /// Any number of numbers.
    Numbers,
    /// Transform steps in braces.
    Maps,
}

/// Allowed values of each component of a numeric field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Range {
    /// Any finite number.
    Any,
    /// Any number that single precision holds.
    Single,
    /// At least 0.
    NonNegative,
    /// Above 0.
    Positive,
    /// Not 0.
    NonZero,
    /// From the first bound to the second, both included.
    Within(f64, f64),
    /// Between the bounds, both excluded.
    Between(f64, f64),
    /// Above the first bound, up to and including the second.
    UpTo(f64, f64),
    /// Range stated by this text and checked by the reader of the block.
    Special(&'static str),
}

/// Value of a field that is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Default {
    /// The field must be given.
    Required,
    /// The field may be absent; the text says what absence means.
    Absent(&'static str),
    /// These numbers.
    Numbers(&'static [f64]),
    /// This word.
    Word(&'static str),
}

/// One field of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    /// Its keyword.
    pub name: &'static str,
    /// Another accepted keyword; empty if there is none.
    pub alias: &'static str,
    /// Type of its value.
    pub kind: Kind,
    /// Allowed values.
    pub range: Range,
    /// Unit of its numbers; empty if they have none.
    pub unit: &'static str,
    /// Value if it is left out.
    pub default: Default,
    /// One line for the reference.
    pub help: &'static str,
    /// True if MIT 6.837 has it too.
    pub course: bool,
}

/// One block: a keyword, perhaps a name, and `{ fields }`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Its keyword, which the writer prints.
    pub keyword: &'static str,
    /// Other accepted keywords.
    pub aliases: &'static [&'static str],
    /// Fields of this block alone.
    pub fields: &'static [Field],
    /// Fields that it has in common with other blocks.
    pub shared: &'static [&'static [Field]],
    /// One line for the reference.
    pub help: &'static str,
    /// True if MIT 6.837 has it too.
    pub course: bool,
}

/// A block of a table, with the function that reads its fields.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<R: 'static> {
    /// Keyword, fields and help.
    pub block: &'static Block,
    /// Reader of the block.
    pub read: R,
}

/// A field named `name` of type `kind`, optional until [`Field::required`] or [`Field::or`].
pub(super) const fn field(name: &'static str, kind: Kind, range: Range, help: &'static str) -> Field {
    Field { name, alias: "", kind, range, unit: "", default: Default::Absent(""), help, course: false }
}

impl Field {
    /// The field, which must be given.
    pub const fn required(mut self) -> Self {
        self.default = Default::Required;
        self
    }

    /// The field with the numbers that stand for it where it is left out.
    pub const fn or(mut self, default: &'static [f64]) -> Self {
        self.default = Default::Numbers(default);
        self
    }

    /// The field with the word that stands for it where it is left out.
    pub const fn or_word(mut self, default: &'static str) -> Self {
        self.default = Default::Word(default);
        self
    }

    /// The field with the meaning of its absence.
    pub const fn absent(mut self, meaning: &'static str) -> Self {
        self.default = Default::Absent(meaning);
        self
    }

    /// The field with the unit of its numbers.
    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// The field with a second keyword.
    pub const fn alias(mut self, alias: &'static str) -> Self {
        self.alias = alias;
        self
    }

    /// The field, marked as one of MIT 6.837.
    pub const fn course(mut self) -> Self {
        self.course = true;
        self
    }

    /// True if `word` is its keyword or alias.
    pub fn is(&self, word: &str) -> bool {
        self.name == word || (!self.alias.is_empty() && self.alias == word)
    }

    /// Returns what a value of these `numbers` violates, phrased to follow the field's name.
    pub fn violation(&self, numbers: &[f64]) -> Option<String> {
        if self.kind == Kind::Direction && !has_direction(DVec3::from_slice(numbers)) {
            return Some("must have a length above 0 (and below 1e154)".to_owned());
        }
        let all = |ok: &dyn Fn(f64) -> bool| numbers.iter().all(|&x| ok(x));
        let ok = match self.range {
            Range::Any | Range::Special(_) => true,
            Range::Single => all(&|x| x.abs() <= LARGEST),
            Range::NonNegative => all(&|x| (0.0..=LARGEST).contains(&x)),
            Range::Positive => all(&|x| x > 0.0 && x <= LARGEST),
            Range::NonZero => all(&|x| x != 0.0),
            Range::Within(least, most) => all(&|x| (least..=most).contains(&x)),
            Range::Between(least, most) => all(&|x| x > least && x < most),
            Range::UpTo(least, most) => all(&|x| x > least && x <= most),
        };
        (!ok).then(|| self.rule(numbers))
    }

    /// Returns the rule that `numbers` break.
    fn rule(&self, numbers: &[f64]) -> String {
        let each = if numbers.len() > 1 { " in each component" } else { "" };
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let too_large = numbers.iter().any(|x| x.abs() > LARGEST);
        match self.range {
            Range::Single | Range::NonNegative | Range::Positive if too_large => {
                "must be below 3.4e38, which single precision holds: choose other units".to_owned()
            }
            Range::Any | Range::Single | Range::Special(_) => "is out of range".to_owned(),
            Range::NonNegative => "must not be negative".to_owned(),
            Range::Positive => "must be above 0".to_owned(),
            Range::NonZero => format!("must not be 0{each}"),
            Range::Within(least, most) if self.kind == Kind::Whole => {
                format!("must be a whole number from {} to {}{unit}", Bound(least), Bound(most))
            }
            Range::Within(least, most) | Range::Between(least, most) => {
                format!("must lie between {} and {}{unit}{each}", Bound(least), Bound(most))
            }
            Range::UpTo(least, most) => {
                format!("must lie above {} and at most at {}{unit}{each}", Bound(least), Bound(most))
            }
        }
    }

    /// Returns the type and range of the value in words, for the reference.
    fn value_text(&self) -> String {
        let noun = match self.kind {
            Kind::Point => "point",
            Kind::Direction => "direction",
            Kind::Color => "color",
            Kind::ColorOrTexture => "color or texture",
            Kind::Number => "number",
            Kind::NumberOrTexture => "number or texture",
            Kind::Pair => "two numbers",
            Kind::Whole => "whole number",
            Kind::Name => "name or path",
            Kind::Word(words) => return words.map_join(),
            Kind::Curve => "curve",
            Kind::Points => "`[ x y z ]` …",
            Kind::WeightedPoints => "`[ x y z ]` or `[ x y z w ]` …",
            Kind::Numbers => "numbers",
            Kind::Maps => "`{ maps }`",
        };
        let range = match self.range {
            Range::Any | Range::Single => String::new(),
            Range::NonNegative => ", ≥ 0".to_owned(),
            Range::Positive => ", > 0".to_owned(),
            Range::NonZero => ", not 0".to_owned(),
            Range::Within(least, most) => format!(", {} … {}", Bound(least), Bound(most)),
            Range::Between(least, most) => format!(", {} < x < {}", Bound(least), Bound(most)),
            Range::UpTo(least, most) => format!(", {} < x ≤ {}", Bound(least), Bound(most)),
            Range::Special(text) => format!(", {text}"),
        };
        let unit = if self.unit.is_empty() { String::new() } else { format!(", {}", self.unit) };
        format!("{noun}{range}{unit}")
    }

    /// Returns the default in words, for the reference.
    fn default_text(&self) -> String {
        match self.default {
            Default::Required => "required".to_owned(),
            Default::Absent(meaning) => meaning.to_owned(),
            Default::Numbers(numbers) => numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
            Default::Word(word) => format!("`{word}`"),
        }
    }

    /// Appends the field's row of a reference table to `out`.
    fn row(&self, blocks: &str, out: &mut String) {
        let mut name = format!("`{}`", self.name);
        if !self.alias.is_empty() {
            let _ = write!(name, ", `{}`", self.alias);
        }
        let course = if self.course { " **Course**" } else { "" };
        let (value, default) = (self.value_text(), self.default_text());
        let _ = writeln!(out, "| {blocks} | {name} | {value} | {default} | {}{course} |", self.help);
    }
}

impl Block {
    /// True if `word` is its keyword or one of its aliases.
    pub fn is(&self, word: &str) -> bool {
        self.keyword == word || self.aliases.contains(&word)
    }

    /// Iterates over all fields, its own first.
    pub fn all_fields(&self) -> impl Iterator<Item = &'static Field> + use<> {
        self.fields.iter().chain(self.shared.iter().copied().flatten())
    }

    /// Returns the field of that keyword or alias.
    pub fn field(&self, word: &str) -> Option<&'static Field> {
        self.all_fields().find(|field| field.is(word))
    }

    /// Iterates over the keywords and aliases of its fields.
    pub fn words(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.all_fields().flat_map(|field| [field.name, field.alias]).filter(|word| !word.is_empty())
    }
}

/// Returns the entry of a keyword or alias.
pub(super) fn find<R>(table: &'static [Entry<R>], word: &str) -> Option<&'static Entry<R>> {
    table.iter().find(|entry| entry.block.is(word))
}

/// Returns the blocks of a table.
pub(super) fn blocks<R>(table: &'static [Entry<R>]) -> Vec<&'static Block> {
    table.iter().map(|entry| entry.block).collect()
}

/// Returns all keywords and aliases of `table`, after the words of `before`.
pub(super) fn keywords<R>(before: &[&'static str], table: &'static [Entry<R>]) -> Vec<&'static str> {
    let blocks = table.iter().map(|entry| entry.block);
    let words = blocks.flat_map(|block| std::iter::once(block.keyword).chain(block.aliases.iter().copied()));
    before.iter().copied().chain(words).collect()
}

/// Returns the reference of `blocks` as Markdown: a list of blocks, then a table of their fields.
///
/// Fields that blocks share stand once, at the end.
pub(super) fn reference(blocks: &[&'static Block]) -> String {
    let mut out = String::new();
    for block in blocks {
        let aliases: String = block.aliases.iter().map(|alias| format!(", `{alias}`")).collect();
        let course = if block.course { " **Course**" } else { "" };
        let _ = writeln!(out, "- `{}`{aliases}: {}.{course}", block.keyword, block.help);
    }
    out += "\n| block | field | value | default | meaning |\n| --- | --- | --- | --- | --- |\n";
    for block in blocks {
        for (i, field) in block.fields.iter().enumerate() {
            let name = if i == 0 { format!("`{}`", block.keyword) } else { String::new() };
            field.row(&name, &mut out);
        }
    }
    let mut seen: Vec<&str> = Vec::new();
    for group in blocks.iter().flat_map(|block| block.shared) {
        if seen.contains(&group[0].name) {
            continue;
        }
        seen.push(group[0].name);
        let has = |block: &&&Block| block.shared.iter().any(|other| other[0].name == group[0].name);
        let users: Vec<&str> = blocks.iter().filter(has).map(|block| block.keyword).collect();
        let users = if users.len() == blocks.len() { "all".to_owned() } else { users.map_join() };
        for (i, field) in group.iter().enumerate() {
            field.row(if i == 0 { &users } else { "" }, &mut out);
        }
    }
    out
}

/// A list of keywords for the reference.
trait MapJoin {
    /// Returns the words in backticks, separated by commas.
    fn map_join(&self) -> String;
}

impl MapJoin for [&str] {
    fn map_join(&self) -> String {
        self.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
    }
}

/// A bound of a range; by exponent where it is large.
struct Bound(f64);

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.abs() < 1e6 { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::language::all_blocks;

    #[test]
    fn every_table_is_consistent() {
        for block in all_blocks() {
            let mut words: Vec<&str> = block.words().collect();
            let count = words.len();
            words.sort_unstable();
            words.dedup();
            assert_eq!(words.len(), count, "`{}` lists a field twice", block.keyword);
            assert!(!block.help.is_empty() && !block.help.ends_with('.'), "{}", block.keyword);
            for field in block.all_fields() {
                assert!(!field.help.is_empty() && !field.help.ends_with('.'), "{} {}", block.keyword, field.name);
                match field.default {
                    Default::Numbers(numbers) => assert_eq!(field.violation(numbers), None, "{}", field.name),
                    Default::Word(word) => assert!(matches!(field.kind, Kind::Word(words) if words.contains(&word))),
                    Default::Required | Default::Absent(_) => {}
                }
            }
        }
    }
}
