//! Material parameters that are constant or follow a texture.

use super::span::Spanned;

/// A material parameter: a constant, or the name of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum TexturedValue<T> {
    /// A value that is constant over the surface.
    Constant(T),
    /// Name of the texture that varies the value over the surface.
    Texture(Spanned<String>),
}

impl<T> From<T> for TexturedValue<T> {
    fn from(value: T) -> Self {
        Self::Constant(value)
    }
}

impl<T> TexturedValue<T> {
    /// Returns the name of the texture; `None` for a constant.
    pub fn texture_name(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Constant(_) => None,
            Self::Texture(name) => Some(name),
        }
    }
}
