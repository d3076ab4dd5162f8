//! Textures: colours and numbers that vary over a surface or in space, filtered over a footprint.

mod checker;
mod eval_context;
pub(crate) mod noise;
mod picture;
mod solid;

pub use checker::Checkerboard;
pub use eval_context::{TextureEvalContext, UvTransform};
pub use picture::{Picture, PictureError, WrapMode};
pub use solid::{SolidPattern, SolidTexture};

use crate::color::{self, Rgb};

/// A colour that varies over a surface or in space.
#[derive(Clone, Debug)]
pub enum Texture {
    /// A picture over texture coordinates.
    Picture(Picture, UvTransform),
    /// A checkerboard of unit squares over texture coordinates.
    Checkerboard(Checkerboard, UvTransform),
    /// A solid texture: a pattern in space.
    Solid(SolidTexture),
}

impl Texture {
    /// Mean colour over the footprint of `context`, within the accuracy of the texture's filter.
    #[must_use]
    pub fn evaluate_color(&self, context: &TextureEvalContext) -> Rgb {
        match self {
            Self::Picture(picture, coordinates) => {
                coordinates.filter_anisotropic(context, |uv, size| picture.box_mean(uv, size))
            }
            Self::Checkerboard(checker, coordinates) => {
                coordinates.filter_anisotropic(context, |uv, size| checker.box_mean(uv, size))
            }
            Self::Solid(solid) => solid.color_at(context.p, context.width),
        }
    }

    /// Mean over the footprint of `context` and over the three colour channels.
    #[must_use]
    pub fn evaluate_scalar(&self, context: &TextureEvalContext) -> f32 {
        color::channel_mean(self.evaluate_color(context))
    }

    /// Mean colour over one period of the texture or, for a solid texture, over all space.
    #[must_use]
    pub fn mean(&self) -> Rgb {
        match self {
            Self::Picture(picture, _) => picture.mean(),
            Self::Checkerboard(checker, _) => checker.mean(),
            Self::Solid(solid) => solid.mean(),
        }
    }

    /// Least and greatest channel value. No lookup exceeds this range.
    #[must_use]
    pub fn value_range(&self) -> (f32, f32) {
        match self {
            Self::Picture(picture, _) => picture.value_range(),
            Self::Checkerboard(checker, _) => color_channel_range(checker.colors),
            Self::Solid(solid) => color_channel_range(solid.colors),
        }
    }

    /// True for a pattern in space, which needs no texture coordinates.
    #[must_use]
    pub fn is_solid_texture(&self) -> bool {
        matches!(self, Self::Solid(_))
    }

    /// Step for the finite differences of bump maps: a fraction of the texture's finest detail.
    ///
    /// The unit is that of texture coordinates or, for a solid texture, of object space \[length].
    #[must_use]
    pub fn finest_bump_step(&self) -> f64 {
        match self {
            Self::Picture(picture, coordinates) => 0.5 * picture.texel_size() / coordinates.max_scale(),
            Self::Checkerboard(_, coordinates) => checker::BUMP_STEP / coordinates.max_scale(),
            Self::Solid(solid) => solid.finest_bump_step(),
        }
    }
}

/// Least and greatest channel value of two colours.
fn color_channel_range([a, b]: [Rgb; 2]) -> (f32, f32) {
    (a.min(b).min_element(), a.max(b).max_element())
}
