//! Textures of a description.

pub use crate::texture::Wrap;
use glam::{DVec2, DVec3};

use super::{Spanned, TransformStep};

/// A constant, or the name of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum TexturedValue<T> {
    /// A constant.
    Plain(T),
    /// Name of a texture.
    Texture(Spanned<String>),
}

impl<T> From<T> for TexturedValue<T> {
    fn from(value: T) -> Self {
        Self::Plain(value)
    }
}

impl<T> TexturedValue<T> {
    /// Returns the name of the texture; `None` for a constant.
    pub fn texture(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Plain(_) => None,
            Self::Texture(name) => Some(name),
        }
    }
}

/// A texture.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDescription {
    /// Name that materials refer to: not empty, no line breaks.
    pub name: String,
    /// Pattern or picture.
    pub kind: TextureKindDescription,
}

/// Pattern or picture of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureKindDescription {
    /// A picture in a file of its own.
    Image {
        /// Path as written: not empty, no line breaks.
        path: Spanned<String>,
        /// Encoding of its values, if they are whole numbers.
        encoding: PictureEncoding,
        /// Continuation beyond its edges.
        wrap: Wrap,
        /// Transform of the texture coordinates.
        coordinates: TexcoordTransformDescription,
    },
    /// Squares of side 1.
    Checker {
        /// Colors where ⌊u⌋ + ⌊v⌋ is even, and where it is odd.
        colors: [DVec3; 2],
        /// Transform of the texture coordinates.
        coordinates: TexcoordTransformDescription,
    },
    /// A solid pattern in the space of the object.
    Solid {
        /// Kind of pattern.
        pattern: SolidPatternDescription,
        /// Colors that it interpolates.
        colors: [DVec3; 2],
        /// Octaves of its noise, from 1 to 16.
        octaves: u32,
        /// Frequency of the first octave, of veins and of rings, in 1/length, above 0.
        frequency: f64,
        /// Factor of the noise, at least 0.
        amplitude: f64,
        /// Maps from the pattern's space to the object's, composed by
        /// [`TransformStep::composed_matrix`].
        maps: Vec<TransformStep>,
    },
}

/// Kind of a solid pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidPatternDescription {
    /// Noise.
    Noise,
    /// Veins.
    Marble,
    /// Rings.
    Wood,
}

/// Encoding of the values of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureEncoding {
    /// The sRGB transfer curve.
    #[default]
    Srgb,
    /// Linear.
    Linear,
}

/// Transform of texture coordinates: scale, then rotation, then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexcoordTransformDescription {
    /// Factors of u and v, not 0.
    pub scale: DVec2,
    /// Rotation, anticlockwise, in degrees.
    pub rotate: f64,
    /// Offset.
    pub offset: DVec2,
}

impl Default for TexcoordTransformDescription {
    fn default() -> Self {
        Self { scale: DVec2::ONE, rotate: 0.0, offset: DVec2::ZERO }
    }
}

/// Emitted radiance of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum EmissionDescription {
    /// Constant radiance in W/(m² sr).
    Radiance(DVec3),
    /// Values of a texture.
    Texture {
        /// Name of the texture.
        name: Spanned<String>,
        /// Factor from values to radiance in W/(m² sr), at least 0.
        scale: f64,
    },
}

/// Perturbation of shading normals, by the name of a texture or else the path of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum NormalPerturbationDescription {
    /// Bump map.
    Bump {
        /// Texture of heights.
        texture: Spanned<String>,
        /// Height of the value 1, in world units.
        height: f64,
    },
    /// Normal map.
    NormalMap(Spanned<String>),
}
