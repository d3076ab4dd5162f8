//! Textures: colours and numbers that vary over a surface, or through space. All are filtered by the patch that one look covers.

mod checker;
mod eval_context;
pub(crate) mod noise;
mod picture;
mod solid;

pub use checker::Checker;
pub use eval_context::{Coordinates, TextureEvalContext};
pub use picture::{Picture, PictureError, Wrap};
pub use solid::{Solid, SolidKind};

use crate::color::{self, Rgb};

/// A texture.
#[derive(Clone, Debug)]
pub enum Texture {
    /// A picture over the texture coordinates of a surface.
    Picture(Picture, Coordinates),
    /// Squares of side 1 over the texture coordinates of a surface.
    Checker(Checker, Coordinates),
    /// A pattern in space.
    Solid(Solid),
}

impl Texture {
    /// Its mean over the patch of `place`, to the texture's filter.
    #[must_use]
    pub fn color(&self, place: &TextureEvalContext) -> Rgb {
        match self {
            Self::Picture(picture, coordinates) => coordinates.spread(place, |uv, size| picture.at(uv, size)),
            Self::Checker(checker, coordinates) => coordinates.spread(place, |uv, size| checker.at(uv, size)),
            Self::Solid(solid) => solid.at(place.p, place.width),
        }
    }

    /// The same as a number: the mean of the channels.
    #[must_use]
    pub fn number(&self, place: &TextureEvalContext) -> f32 {
        color::mean(self.color(place))
    }

    /// Its mean: over one period, or of a solid over all space.
    #[must_use]
    pub fn mean(&self) -> Rgb {
        match self {
            Self::Picture(picture, _) => picture.mean(),
            Self::Checker(checker, _) => checker.mean(),
            Self::Solid(solid) => solid.mean(),
        }
    }

    /// Least and greatest value of any channel: no look at it lies outside.
    #[must_use]
    pub fn range(&self) -> (f32, f32) {
        match self {
            Self::Picture(picture, _) => picture.range(),
            Self::Checker(checker, _) => bounds(checker.colors),
            Self::Solid(solid) => bounds(solid.colors),
        }
    }

    /// Whether it is a pattern in space, which needs no texture coordinates.
    #[must_use]
    pub fn is_solid(&self) -> bool {
        matches!(self, Self::Solid(_))
    }

    /// A step that tells its slope: half of its finest detail, in texture coordinates of the surface or, of a solid, in lengths of
    /// the object.
    #[must_use]
    pub fn grain(&self) -> f64 {
        match self {
            Self::Picture(picture, coordinates) => 0.5 * picture.texel() / coordinates.stretch(),
            Self::Checker(_, coordinates) => checker::GRAIN / coordinates.stretch(),
            Self::Solid(solid) => solid.grain(),
        }
    }
}

/// Least and greatest channel of two colours.
fn bounds([a, b]: [Rgb; 2]) -> (f32, f32) {
    (a.min(b).min_element(), a.max(b).max_element())
}
