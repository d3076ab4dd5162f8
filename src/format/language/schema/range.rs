//! Ranges of numeric fields: which numbers they contain, and their text in the language reference.

use std::fmt;

/// Largest finite single-precision number.
pub(super) const MAX_SINGLE_PRECISION: f64 = f32::MAX as f64;

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

impl FieldRange {
    /// True if the range contains `x`. A range that is only described contains every number.
    pub(super) fn contains(self, x: f64) -> bool {
        match self {
            Self::Any | Self::DescribedOnly(_) => true,
            Self::SinglePrecision => x.abs() <= MAX_SINGLE_PRECISION,
            Self::NonNegative => (0.0..=MAX_SINGLE_PRECISION).contains(&x),
            Self::Positive => x > 0.0 && x <= MAX_SINGLE_PRECISION,
            Self::NonZero => x != 0.0,
            Self::ClosedInterval(least, most) => (least..=most).contains(&x),
            Self::OpenInterval(least, most) => x > least && x < most,
            Self::LeftOpenInterval(least, most) => x > least && x <= most,
        }
    }

    /// Returns the range for the language reference, such as ", ≥ 0"; empty if any number is
    /// allowed.
    pub(super) fn reference_text(self) -> String {
        match self {
            Self::Any | Self::SinglePrecision => String::new(),
            Self::NonNegative => ", ≥ 0".to_owned(),
            Self::Positive => ", > 0".to_owned(),
            Self::NonZero => ", not 0".to_owned(),
            Self::ClosedInterval(least, most) => format!(", {} … {}", RangeBound(least), RangeBound(most)),
            Self::OpenInterval(least, most) => format!(", {} < x < {}", RangeBound(least), RangeBound(most)),
            Self::LeftOpenInterval(least, most) => format!(", {} < x ≤ {}", RangeBound(least), RangeBound(most)),
            Self::DescribedOnly(text) => format!(", {text}"),
        }
    }
}

/// Displays a bound of a field's range: as a plain decimal such as 0.5 if its magnitude is below
/// 10⁶, else in scientific notation such as 1e12.
pub(super) struct RangeBound(pub f64);

impl fmt::Display for RangeBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.abs() < 1e6 { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}
