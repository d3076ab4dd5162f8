//! Textures of a [`SceneDescription`](super::SceneDescription), as the scene file states them.

pub use crate::texture::WrapMode;
use glam::{DVec2, DVec3};

use super::{Spanned, TransformStep};

/// A material parameter: a constant, or the name of a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum TexturedValue<T> {
    /// A value that is constant over the surface.
    Plain(T),
    /// Name of the texture that varies the value over the surface.
    Texture(Spanned<String>),
}

impl<T> From<T> for TexturedValue<T> {
    fn from(value: T) -> Self {
        Self::Plain(value)
    }
}

impl<T> TexturedValue<T> {
    /// Returns the name of the texture; `None` for a constant.
    pub fn texture_name(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Plain(_) => None,
            Self::Texture(name) => Some(name),
        }
    }
}

/// A texture as the scene file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDescription {
    /// Name that materials refer to: not empty, without line breaks.
    pub name: String,
    /// Picture, checkerboard or solid pattern.
    pub kind: TextureKindDescription,
}

/// Picture, checkerboard or solid texture, with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureKindDescription {
    /// A picture in a file of its own.
    Image {
        /// Path of the picture as the text writes it: not empty, without line breaks.
        path: Spanned<String>,
        /// Encoding of pictures with integer values, such as PNG. Floating-point pictures are
        /// linear.
        encoding: PictureEncoding,
        /// Rule for texture coordinates beyond the picture's edges.
        wrap: WrapMode,
        /// Transform from the surface's texture coordinates to those of the picture.
        coordinates: TexcoordTransformDescription,
    },
    /// Checkerboard with squares of side 1 in texture coordinates.
    Checker {
        /// Colors where ⌊u⌋ + ⌊v⌋ is even, and where it is odd.
        colors: [DVec3; 2],
        /// Transform from the surface's texture coordinates to those of the checkerboard.
        coordinates: TexcoordTransformDescription,
    },
    /// A solid texture: a function of the position in object space.
    Solid {
        /// Function of the position.
        pattern: SolidPatternDescription,
        /// Colors where the pattern has the values 0 and 1.
        colors: [DVec3; 2],
        /// Number of noise octaves, from 1 to 16.
        octaves: u32,
        /// Frequency in 1/length, above 0. It counts periods of the first noise octave, marble
        /// veins or wood rings.
        frequency: f64,
        /// Amplitude of the noise, at least 0.
        amplitude: f64,
        /// Steps from pattern space to object space; see [`TransformStep::composed_matrix`].
        steps: Vec<TransformStep>,
    },
}

/// Function of position that a solid texture evaluates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidPatternDescription {
    /// Perlin noise.
    Noise,
    /// Parallel veins, distorted by noise.
    Marble,
    /// Rings about an axis, distorted by noise.
    Wood,
}

/// Encoding of pictures with integer values, such as PNG files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureEncoding {
    /// Values are encoded by the sRGB transfer function, as in photographs.
    #[default]
    Srgb,
    /// Values are linear, such as heights or normals.
    Linear,
}

/// Transform of texture coordinates: a scale, then a rotation, then an offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexcoordTransformDescription {
    /// Factors of u and v, neither of them 0.
    pub scale: DVec2,
    /// Counterclockwise rotation in degrees.
    pub rotate: f64,
    /// Offset of u and v.
    pub offset: DVec2,
}

impl Default for TexcoordTransformDescription {
    fn default() -> Self {
        Self { scale: DVec2::ONE, rotate: 0.0, offset: DVec2::ZERO }
    }
}

/// Emitted radiance of a material: constant, or varied by a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum EmissionDescription {
    /// Constant radiance in W/(m² sr).
    Radiance(DVec3),
    /// Radiance given by the values of a texture.
    Texture {
        /// Name of the texture.
        name: Spanned<String>,
        /// Factor from texture values to radiance in W/(m² sr), at least 0.
        scale: f64,
    },
}

/// Perturbation of shading normals by the values of a texture: a bump map or a normal map.
///
/// The field that refers to the texture holds its name. If no texture has the name, the field is
/// the path of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum NormalPerturbationDescription {
    /// Bump map (Blinn 1978): heights by which the surface is displaced along its normal for
    /// shading.
    Bump {
        /// Name of the texture that holds the heights, or path of a picture.
        texture: Spanned<String>,
        /// Height of texture value 1 in world units; may be negative.
        height: f64,
    },
    /// Tangent-space normal map: name of a texture, or path of a picture.
    NormalMap(Spanned<String>),
}
