//! What a scene file says of its textures.

use glam::{DVec2, DVec3};

use super::{Map, Spanned};

/// A value that is the same everywhere, or follows a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum Value<T> {
    /// The same everywhere.
    Plain(T),
    /// That of the texture of this name.
    Texture(Spanned<String>),
}

impl<T> From<T> for Value<T> {
    fn from(value: T) -> Self {
        Self::Plain(value)
    }
}

impl<T> Value<T> {
    /// The texture's name, if it follows one.
    pub fn texture(&self) -> Option<&Spanned<String>> {
        match self {
            Self::Plain(_) => None,
            Self::Texture(name) => Some(name),
        }
    }
}

/// A texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// What materials call it: not empty, no line breaks.
    pub name: String,
    /// What it shows.
    pub kind: TextureKind,
}

/// What a texture shows.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureKind {
    /// A picture in a file of its own.
    Image {
        /// As written: not empty, no line breaks.
        path: Spanned<String>,
        /// What its numbers mean, if they are whole.
        encoding: Encoding,
        /// What lies beyond its edges.
        wrap: Wrap,
        /// How it lies on the surface.
        coordinates: Coordinates,
    },
    /// Squares of side 1.
    Checker {
        /// Where ⌊u⌋ + ⌊v⌋ is even, and where it is odd.
        colors: [DVec3; 2],
        /// How they lie on the surface.
        coordinates: Coordinates,
    },
    /// A pattern in the space of the object.
    Solid {
        /// Which one.
        pattern: Pattern,
        /// What it goes between.
        colors: [DVec3; 2],
        /// Octaves of its noise, from 1 to 16.
        octaves: u32,
        /// Of the first octave, and of veins and rings, above 0.
        frequency: f64,
        /// What the noise is multiplied by, at least 0.
        amplitude: f64,
        /// From the pattern's space to the object's, composed by [`Map::product`].
        maps: Vec<Map>,
    },
}

/// Patterns in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Clouds.
    Noise,
    /// Veins.
    Marble,
    /// Rings.
    Wood,
}

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// They are of the sRGB curve.
    #[default]
    Srgb,
    /// They are what they say.
    Linear,
}

/// What lies beyond the edges of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// Its edge.
    Clamp,
    /// The picture mirrored, and again.
    Mirror,
}

/// How texture coordinates are changed: scaled, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    /// What u and v are multiplied by, not 0.
    pub scale: DVec2,
    /// Anticlockwise, in degrees.
    pub rotate: f64,
    /// What is added.
    pub offset: DVec2,
}

impl Default for Coordinates {
    fn default() -> Self {
        Self { scale: DVec2::ONE, rotate: 0.0, offset: DVec2::ZERO }
    }
}

/// What a material sends out by itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Emission {
    /// The same radiance everywhere, in W/(m² sr).
    Radiance(DVec3),
    /// A texture's.
    Texture {
        /// Its name.
        name: Spanned<String>,
        /// What its values are multiplied by to be radiances, at least 0.
        scale: f64,
    },
}

/// What makes a surface look uneven. Each is the name of a texture, or else the path of a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Relief {
    /// Heights.
    Bump {
        /// The texture.
        texture: Spanned<String>,
        /// Height of the value 1.
        height: f64,
    },
    /// Normals.
    NormalMap(Spanned<String>),
}
