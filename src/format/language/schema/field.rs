//! Schema of one field of a block: its keyword, the type, range and default of its value, and help.

use glam::DVec3;

use super::super::text::is_normalizable;
use super::range::{FieldRange, MAX_SINGLE_PRECISION, RangeBound};

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
        let ok = numbers.iter().all(|&x| self.range.contains(x));
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
