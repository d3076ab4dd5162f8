//! Schemas of the scene language: its blocks and fields, with units, ranges, defaults and help.
//!
//! The parser checks values against the schemas, and the writer takes keywords from them. The
//! tables in `docs/guide/scene-language.md` are generated from them.

use std::fmt::Write;

use glam::DVec3;

use super::text::is_normalizable;

/// Largest finite single-precision number.
const MAX_SINGLE_PRECISION: f64 = f32::MAX as f64;

/// Largest accepted absorption or scattering coefficient \[1/length].
///
/// Coefficients up to this value can be multiplied by densities and lengths without overflow in
/// single precision.
pub(in crate::format) const MAX_MEDIUM_COEFFICIENT: f64 = 1e12;

/// Type of the value that follows a field's keyword.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::format) enum FieldKind {
    /// Three numbers: a position or an offset.
    Point,
    /// Three numbers: a vector of any length above 0.
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
    WholeNumber,
    /// A path or name, quoted or bare.
    Name,
    /// One of the listed words.
    Word(&'static [&'static str]),
    /// A `BezierCurve` or `BsplineCurve` block.
    Curve,
    /// Any number of points in brackets, each `[ x y z ]`.
    Points,
    /// Any number of points in brackets, each with an optional weight: `[ x y z w ]`.
    WeightedPoints,
    /// A list of numbers of any length.
    NumberList,
    /// Transform steps in braces.
    TransformSteps,
}

/// Range that each component of a numeric field must lie in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::format) enum FieldRange {
    /// Any finite number.
    Any,
    /// Any number of magnitude up to [`f32::MAX`].
    SinglePrecision,
    /// Any number from 0 to [`f32::MAX`].
    NonNegative,
    /// Any number above 0, up to [`f32::MAX`].
    Positive,
    /// Any finite number except 0.
    NonZero,
    /// Numbers from the first bound to the second, both included.
    ClosedInterval(f64, f64),
    /// Numbers between the bounds, both excluded.
    OpenInterval(f64, f64),
    /// Numbers above the first bound, up to and including the second.
    LeftOpenInterval(f64, f64),
    /// A range that this text describes for the language reference. The schema does not check the
    /// range; the function that converts the block does.
    DescribedOnly(&'static str),
}

/// Default value of a field, or the meaning of its absence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::format) enum FieldDefault {
    /// The field must be present.
    Required,
    /// The field may be absent, and has no default value. The language reference prints this text,
    /// which states what absence means.
    Optional(&'static str),
    /// The parser uses these numbers if the field is absent.
    Numbers(&'static [f64]),
    /// The parser uses this word if the field is absent.
    Word(&'static str),
}

/// Schema of one field of a block: keyword, type, range, unit, default and help.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct FieldSchema {
    /// The field's keyword.
    pub keyword: &'static str,
    /// Second accepted keyword; empty if there is none.
    pub alias: &'static str,
    /// Type of the field's value.
    pub kind: FieldKind,
    /// Range that the field's value must lie in.
    pub range: FieldRange,
    /// Unit of the numbers; empty if they have none.
    pub unit: &'static str,
    /// Default value, or meaning of an absent field.
    pub default: FieldDefault,
    /// Meaning of the value, in one line of the language reference.
    pub help: &'static str,
    /// True if the field is part of the scene format of MIT course 6.837.
    pub is_mit_6837_syntax: bool,
    /// True if the writer omits the field where its value is the default.
    pub is_default_omitted: bool,
}

/// List of fields of a block.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct FieldList {
    /// Fields of the list; at least one.
    pub fields: &'static [FieldSchema],
    /// True if several kinds of blocks have the list. The language reference then states it once.
    pub is_shared: bool,
}

/// Schema of one kind of block: `keyword { fields }` or `keyword name { fields }`.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct BlockSchema {
    /// Keyword of the block. The scene writer prints it; the parser also accepts `aliases`.
    pub keyword: &'static str,
    /// Further keywords that the parser accepts for the block.
    pub aliases: &'static [&'static str],
    /// Field lists that the macro `field_table!` declares. The macro also generates the code that
    /// reads and writes these fields.
    pub table_fields: &'static [FieldList],
    /// Fields that only this kind of block has, and that `table_fields` does not contain.
    pub own_fields: &'static [FieldSchema],
    /// Field lists that several kinds of blocks share, and that `table_fields` does not contain.
    pub shared_fields: &'static [&'static [FieldSchema]],
    /// Meaning of the block, in one line of the language reference.
    pub help: &'static str,
    /// True if the block is part of the scene format of MIT course 6.837.
    pub is_mit_6837_syntax: bool,
}

/// Entry of a table of blocks: the schema of one kind of block, and the function that converts its
/// parsed fields.
#[derive(Clone, Copy, Debug)]
pub(in crate::format) struct BlockParser<P: 'static> {
    /// Schema of the block: keywords, fields and help.
    pub block: &'static BlockSchema,
    /// Function that converts the parsed fields, for example to a light or a shape.
    pub parse: P,
}

/// Creates the schema of an optional field called `name`. It has no unit, alias or default yet.
///
/// Colors have the range [`FieldRange::NonNegative`], all other kinds [`FieldRange::Any`].
pub(in crate::format) const fn field_schema(name: &'static str, kind: FieldKind, help: &'static str) -> FieldSchema {
    let range = match kind {
        FieldKind::Color | FieldKind::ColorOrTexture => FieldRange::NonNegative,
        _ => FieldRange::Any,
    };
    let default = FieldDefault::Optional("");
    FieldSchema {
        keyword: name,
        alias: "",
        kind,
        range,
        unit: "",
        default,
        help,
        is_mit_6837_syntax: false,
        is_default_omitted: false,
    }
}

/// Creates the schema of a block, without fields and aliases.
pub(in crate::format) const fn block_schema(keyword: &'static str, help: &'static str) -> BlockSchema {
    BlockSchema {
        keyword,
        aliases: &[],
        table_fields: &[],
        own_fields: &[],
        shared_fields: &[],
        help,
        is_mit_6837_syntax: false,
    }
}

impl FieldSchema {
    /// Limits each component of the value to `range`.
    pub const fn with_range(mut self, range: FieldRange) -> Self {
        self.range = range;
        self
    }

    /// Makes the field mandatory.
    pub const fn make_required(mut self) -> Self {
        self.default = FieldDefault::Required;
        self
    }

    /// Sets the numbers that the parser uses if the field is absent.
    pub const fn with_default_numbers(mut self, default: &'static [f64]) -> Self {
        self.default = FieldDefault::Numbers(default);
        self
    }

    /// Sets the word that the parser uses if the field is absent.
    pub const fn with_default_word(mut self, default: &'static str) -> Self {
        self.default = FieldDefault::Word(default);
        self
    }

    /// Makes the field optional, without a default value. The language reference prints `meaning`,
    /// which states what the absence of the field means.
    pub const fn make_optional(mut self, meaning: &'static str) -> Self {
        self.default = FieldDefault::Optional(meaning);
        self
    }

    /// Sets the unit of the numbers.
    pub const fn with_unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Sets the second accepted keyword.
    pub const fn with_alias(mut self, alias: &'static str) -> Self {
        self.alias = alias;
        self
    }

    /// Marks the field as part of the scene format of MIT course 6.837.
    pub const fn mark_as_mit_6837_syntax(mut self) -> Self {
        self.is_mit_6837_syntax = true;
        self
    }

    /// Makes the writer omit the field where its value is the default.
    pub const fn omit_default(mut self) -> Self {
        self.is_default_omitted = true;
        self
    }

    /// Returns a list with this field only, for use in one kind of block.
    pub const fn field_list(&'static self) -> FieldList {
        FieldList::own(std::slice::from_ref(self))
    }

    /// True if `word` is the field's keyword or its alias.
    pub fn matches_keyword(&self, word: &str) -> bool {
        self.keyword == word || (!self.alias.is_empty() && self.alias == word)
    }

    /// Returns the rule that the field value `numbers` violates, such as "must be above 0"; `None`
    /// if the field allows the value.
    pub fn violated_rule(&self, numbers: &[f64]) -> Option<String> {
        if self.kind == FieldKind::Direction && !is_normalizable(DVec3::from_slice(numbers)) {
            return Some("must have a length above 0 (and below 1e154)".to_owned());
        }
        let all = |ok: &dyn Fn(f64) -> bool| numbers.iter().all(|&x| ok(x));
        let ok = match self.range {
            FieldRange::Any | FieldRange::DescribedOnly(_) => true,
            FieldRange::SinglePrecision => all(&|x| x.abs() <= MAX_SINGLE_PRECISION),
            FieldRange::NonNegative => all(&|x| (0.0..=MAX_SINGLE_PRECISION).contains(&x)),
            FieldRange::Positive => all(&|x| x > 0.0 && x <= MAX_SINGLE_PRECISION),
            FieldRange::NonZero => all(&|x| x != 0.0),
            FieldRange::ClosedInterval(least, most) => all(&|x| (least..=most).contains(&x)),
            FieldRange::OpenInterval(least, most) => all(&|x| x > least && x < most),
            FieldRange::LeftOpenInterval(least, most) => all(&|x| x > least && x <= most),
        };
        (!ok).then(|| self.describe_violated_range(numbers))
    }

    /// Returns the rule that the field's range imposes, such as "must not be negative" for
    /// `NonNegative`.
    ///
    /// The rule is part of the error message about the value `numbers`, which violates it.
    fn describe_violated_range(&self, numbers: &[f64]) -> String {
        let each = if numbers.len() > 1 { " in each component" } else { "" };
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let is_too_large = numbers.iter().any(|x| x.abs() > MAX_SINGLE_PRECISION);
        match self.range {
            FieldRange::SinglePrecision | FieldRange::NonNegative | FieldRange::Positive if is_too_large => {
                "must be below 3.4e38, which single precision holds: choose other units".to_owned()
            }
            FieldRange::Any | FieldRange::SinglePrecision | FieldRange::DescribedOnly(_) => {
                "is out of range".to_owned()
            }
            FieldRange::NonNegative => "must not be negative".to_owned(),
            FieldRange::Positive => "must be above 0".to_owned(),
            FieldRange::NonZero => format!("must not be 0{each}"),
            FieldRange::ClosedInterval(least, most) if self.kind == FieldKind::WholeNumber => {
                format!("must be a whole number from {} to {}{unit}", RangeBound(least), RangeBound(most))
            }
            FieldRange::ClosedInterval(least, most) | FieldRange::OpenInterval(least, most) => {
                format!("must lie between {} and {}{unit}{each}", RangeBound(least), RangeBound(most))
            }
            FieldRange::LeftOpenInterval(least, most) => {
                format!("must lie above {} and at most at {}{unit}{each}", RangeBound(least), RangeBound(most))
            }
        }
    }

    /// Returns type, range and unit of the field's value in words, for the language reference.
    fn describe_value(&self) -> String {
        let noun = match self.kind {
            FieldKind::Point => "point",
            FieldKind::Direction => "direction",
            FieldKind::Color => "color",
            FieldKind::ColorOrTexture => "color or texture",
            FieldKind::Number => "number",
            FieldKind::NumberOrTexture => "number or texture",
            FieldKind::Pair => "two numbers",
            FieldKind::WholeNumber => "whole number",
            FieldKind::Name => "name or path",
            FieldKind::Word(words) => return join_in_backticks(words),
            FieldKind::Curve => "curve",
            FieldKind::Points => "`[ x y z ]` …",
            FieldKind::WeightedPoints => "`[ x y z ]` or `[ x y z w ]` …",
            FieldKind::NumberList => "numbers",
            FieldKind::TransformSteps => "`{ maps }`",
        };
        let range = match self.range {
            FieldRange::Any | FieldRange::SinglePrecision => String::new(),
            FieldRange::NonNegative => ", ≥ 0".to_owned(),
            FieldRange::Positive => ", > 0".to_owned(),
            FieldRange::NonZero => ", not 0".to_owned(),
            FieldRange::ClosedInterval(least, most) => format!(", {} … {}", RangeBound(least), RangeBound(most)),
            FieldRange::OpenInterval(least, most) => format!(", {} < x < {}", RangeBound(least), RangeBound(most)),
            FieldRange::LeftOpenInterval(least, most) => format!(", {} < x ≤ {}", RangeBound(least), RangeBound(most)),
            FieldRange::DescribedOnly(text) => format!(", {text}"),
        };
        let unit = if self.unit.is_empty() { String::new() } else { format!(", {}", self.unit) };
        format!("{noun}{range}{unit}")
    }

    /// Returns the field's default in words, for the language reference.
    fn describe_default(&self) -> String {
        match self.default {
            FieldDefault::Required => "required".to_owned(),
            FieldDefault::Optional(meaning) => meaning.to_owned(),
            FieldDefault::Numbers(numbers) => numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
            FieldDefault::Word(word) => format!("`{word}`"),
        }
    }

    /// Appends the field's row of a Markdown table to `out`.
    ///
    /// The first cell of the row is `blocks`, the names of blocks that have the field.
    fn write_reference_row(&self, blocks: &str, out: &mut String) {
        let mut name = format!("`{}`", self.keyword);
        if !self.alias.is_empty() {
            let _ = write!(name, ", `{}`", self.alias);
        }
        let course = if self.is_mit_6837_syntax { " **Course**" } else { "" };
        let (value, default) = (self.describe_value(), self.describe_default());
        let _ = writeln!(out, "| {blocks} | {name} | {value} | {default} | {}{course} |", self.help);
    }
}

impl FieldList {
    /// Creates a list of fields that only one kind of block has.
    pub const fn own(fields: &'static [FieldSchema]) -> Self {
        Self { fields, is_shared: false }
    }

    /// Creates a list of fields that several kinds of blocks have.
    pub const fn shared(fields: &'static [FieldSchema]) -> Self {
        Self { fields, is_shared: true }
    }
}

impl BlockSchema {
    /// Sets the block's other accepted keywords.
    pub const fn with_aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    /// Sets the field lists that `field_table!` declares.
    pub const fn with_table(mut self, table: &'static [FieldList]) -> Self {
        self.table_fields = table;
        self
    }

    /// Sets the fields that only this kind of block has, and that no `field_table!` declares.
    pub const fn with_own_fields(mut self, fields: &'static [FieldSchema]) -> Self {
        self.own_fields = fields;
        self
    }

    /// Sets the field lists `groups`, which several kinds of blocks share.
    pub const fn with_shared_fields(mut self, groups: &'static [&'static [FieldSchema]]) -> Self {
        self.shared_fields = groups;
        self
    }

    /// Marks the block as part of the scene format of MIT course 6.837.
    pub const fn mark_as_mit_6837_syntax(mut self) -> Self {
        self.is_mit_6837_syntax = true;
        self
    }

    /// True if `word` is the block's keyword or an alias.
    pub fn matches_keyword(&self, word: &str) -> bool {
        self.keyword == word || self.aliases.contains(&word)
    }

    /// Iterates over the fields that only this kind of block has.
    fn all_own_fields(&self) -> impl Iterator<Item = &'static FieldSchema> + use<> {
        self.table_fields.iter().filter(|list| !list.is_shared).flat_map(|list| list.fields).chain(self.own_fields)
    }

    /// Iterates over the lists of fields that several kinds of blocks share.
    fn all_shared_lists(&self) -> impl Iterator<Item = &'static [FieldSchema]> + use<> {
        let lists = self.table_fields.iter().filter(|list| list.is_shared).map(|list| list.fields);
        lists.chain(self.shared_fields.iter().copied())
    }

    /// Iterates over the block's own fields, then over its shared fields.
    pub fn all_fields(&self) -> impl Iterator<Item = &'static FieldSchema> + use<> {
        self.all_own_fields().chain(self.all_shared_lists().flatten())
    }

    /// Returns the field with keyword or alias `word`; `None` if the block has none.
    pub fn find_field(&self, word: &str) -> Option<&'static FieldSchema> {
        self.all_fields().find(|field| field.matches_keyword(word))
    }

    /// Iterates over the keywords and aliases of all fields.
    pub fn field_keywords(&self) -> impl Iterator<Item = &'static str> + use<> {
        self.all_fields().flat_map(|field| [field.keyword, field.alias]).filter(|word| !word.is_empty())
    }
}

/// Returns the entry of `table` whose block has the keyword or alias `word`; `None` if no entry
/// has it.
pub(in crate::format) fn find_block<P>(
    table: &'static [BlockParser<P>],
    word: &str,
) -> Option<&'static BlockParser<P>> {
    table.iter().find(|entry| entry.block.matches_keyword(word))
}

/// Returns the schemas of all blocks of `table`.
pub(in crate::format) fn block_schemas<P>(table: &'static [BlockParser<P>]) -> Vec<&'static BlockSchema> {
    table.iter().map(|entry| entry.block).collect()
}

/// Returns the words of `before`, followed by the keywords and aliases of all blocks in `table`.
pub(in crate::format) fn block_keywords<P>(
    before: &[&'static str],
    table: &'static [BlockParser<P>],
) -> Vec<&'static str> {
    let blocks = table.iter().map(|entry| entry.block);
    let words = blocks.flat_map(|block| std::iter::once(block.keyword).chain(block.aliases.iter().copied()));
    before.iter().copied().chain(words).collect()
}

/// Returns the reference of `blocks` as Markdown: a list of blocks, then a table of their fields.
///
/// Each list of shared fields appears once, at the end of the table.
pub(in crate::format) fn reference_markdown(blocks: &[&'static BlockSchema]) -> String {
    let mut out = String::new();
    for block in blocks {
        let aliases: String = block.aliases.iter().map(|alias| format!(", `{alias}`")).collect();
        let course = if block.is_mit_6837_syntax { " **Course**" } else { "" };
        let _ = writeln!(out, "- `{}`{aliases}: {}.{course}", block.keyword, block.help);
    }
    out += "\n| block | field | value | default | meaning |\n| --- | --- | --- | --- | --- |\n";
    for block in blocks {
        for (i, field) in block.all_own_fields().enumerate() {
            let name = if i == 0 { format!("`{}`", block.keyword) } else { String::new() };
            field.write_reference_row(&name, &mut out);
        }
    }
    // A list of shared fields is identified by the name of its first field.
    let mut seen: Vec<&str> = Vec::new();
    for group in blocks.iter().flat_map(|block| block.all_shared_lists()) {
        if seen.contains(&group[0].keyword) {
            continue;
        }
        seen.push(group[0].keyword);
        let has = |block: &&&BlockSchema| block.all_shared_lists().any(|other| other[0].keyword == group[0].keyword);
        let users: Vec<&str> = blocks.iter().filter(has).map(|block| block.keyword).collect();
        let users = if users.len() == blocks.len() { "all".to_owned() } else { join_in_backticks(&users) };
        for (i, field) in group.iter().enumerate() {
            field.write_reference_row(if i == 0 { &users } else { "" }, &mut out);
        }
    }
    out
}

/// Puts each of `words` in backticks, and joins them with commas.
fn join_in_backticks(words: &[&str]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// Displays a bound of a field's range: as a plain decimal such as 0.5 if its magnitude is below
/// 10⁶, else in scientific notation such as 1e12.
struct RangeBound(f64);

impl std::fmt::Display for RangeBound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.abs() < 1e6 { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::language::all_block_schemas;

    #[test]
    fn schemas_have_help_and_valid_defaults() {
        for block in all_block_schemas() {
            let mut words: Vec<&str> = block.field_keywords().collect();
            let count = words.len();
            words.sort_unstable();
            words.dedup();
            assert_eq!(words.len(), count, "`{}` lists a field twice", block.keyword);
            assert!(!block.help.is_empty() && !block.help.ends_with('.'), "{}", block.keyword);
            for field in block.all_fields() {
                assert!(!field.help.is_empty() && !field.help.ends_with('.'), "{} {}", block.keyword, field.keyword);
                match field.default {
                    FieldDefault::Numbers(numbers) => {
                        assert_eq!(field.violated_rule(numbers), None, "{}", field.keyword)
                    }
                    FieldDefault::Word(word) => {
                        assert!(matches!(field.kind, FieldKind::Word(words) if words.contains(&word)))
                    }
                    FieldDefault::Required | FieldDefault::Optional(_) => {}
                }
            }
        }
    }
}
