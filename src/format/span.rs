//! Positions in the text of a scene, for error messages.

use std::ops::Deref;

/// A range of bytes in the text of a scene, for error messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Offset of the first byte of the range from the start of the text.
    pub start: usize,
    /// Length of the range in bytes.
    pub len: usize,
}

/// A value with the span of the scene text that it was read from. Equality ignores the span.
///
/// A camera, light, material or object has the span of its keyword.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spanned<T> {
    /// The value that was read.
    pub value: T,
    /// Position in the scene's text.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// Creates a value with `span`, its position in the text.
    pub const fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

impl<T: PartialEq> PartialEq for Spanned<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<T> Deref for Spanned<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}
