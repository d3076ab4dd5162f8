//! Textures: colors and numbers that vary over a surface or in space.
//!
//! A lookup returns the mean of the texture over a ray's footprint, so that textures do not alias.

mod checker;
mod eval_context;
mod mip_map;
pub(crate) mod noise;
mod solid;

pub use checker::Checkerboard;
pub use eval_context::{TextureEvalContext, UvTransform};
pub use mip_map::{MipMap, MipMapError, WrapMode};
pub use solid::{SolidPattern, SolidTexture};

use crate::color::{self, Rgb};

/// A color that varies over a surface or in space.
///
/// A [`UvTransform`] maps the surface's texture coordinates to those of the picture or
/// checkerboard.
#[derive(Clone, Debug)]
pub enum Texture {
    /// A picture, which covers the unit square of its texture coordinates.
    Image(MipMap, UvTransform),
    /// A checkerboard of unit squares in its texture coordinates.
    Checkerboard(Checkerboard, UvTransform),
    /// A solid texture: a pattern in object space.
    Solid(SolidTexture),
}

impl Texture {
    /// Mean color of the texture over the footprint of `context`; the value at the point if the
    /// footprint has zero size.
    ///
    /// The mean is approximate: it is taken over boxes, or over a ball for solid textures, that
    /// cover the footprint.
    #[must_use]
    pub fn evaluate_color(&self, context: &TextureEvalContext) -> Rgb {
        match self {
            Self::Image(mip_map, coordinates) => {
                coordinates.filter_anisotropic(context, |uv, size| mip_map.box_mean(uv, size))
            }
            Self::Checkerboard(checker, coordinates) => {
                coordinates.filter_anisotropic(context, |uv, size| checker.box_mean(uv, size))
            }
            Self::Solid(solid) => solid.color_at(context.object_p, context.footprint_width),
        }
    }

    /// Mean of the texture over the footprint of `context` and over red, green and blue.
    ///
    /// Use this for textures of a scalar, such as roughness or the height of a bump map.
    #[must_use]
    pub fn evaluate_scalar(&self, context: &TextureEvalContext) -> f32 {
        color::channel_mean(self.evaluate_color(context))
    }

    /// Mean color of the whole texture.
    ///
    /// This is the mean of all pixels of a picture, or of the two colors of a pattern.
    #[must_use]
    pub fn mean(&self) -> Rgb {
        match self {
            Self::Image(mip_map, _) => mip_map.mean(),
            Self::Checkerboard(checker, _) => checker.mean(),
            Self::Solid(solid) => solid.mean(),
        }
    }

    /// Least and greatest value of any color channel. All lookups are within this range.
    #[must_use]
    pub fn value_range(&self) -> (f32, f32) {
        match self {
            Self::Image(mip_map, _) => mip_map.value_range(),
            Self::Checkerboard(checker, _) => color_channel_range(checker.colors),
            Self::Solid(solid) => color_channel_range(solid.colors),
        }
    }

    /// True for a pattern in object space, which needs no texture coordinates.
    #[must_use]
    pub fn is_solid_texture(&self) -> bool {
        matches!(self, Self::Solid(_))
    }

    /// Step of the finite differences of bump maps: a small fraction of the size of the texture's
    /// finest detail.
    ///
    /// The step is in units of the surface's texture coordinates. For a solid texture, it is an
    /// object-space length.
    #[must_use]
    pub fn finest_bump_step(&self) -> f64 {
        match self {
            Self::Image(mip_map, coordinates) => 0.5 * mip_map.texel_size() / coordinates.max_scale(),
            Self::Checkerboard(_, coordinates) => checker::BUMP_STEP / coordinates.max_scale(),
            Self::Solid(solid) => solid.finest_bump_step(),
        }
    }
}

/// Least and greatest channel value of two colors.
fn color_channel_range([a, b]: [Rgb; 2]) -> (f32, f32) {
    (a.min(b).min_element(), a.max(b).max_element())
}
