//! Results of converting textures of imported scenes.

use super::description::{Spanned, TexturedValue};
use glam::DVec3;

/// Result of converting a color parameter or texture: a constant, or a texture of the imported
/// scene.
#[derive(Clone, Debug)]
pub(super) enum ConvertedTexture {
    /// Equal values everywhere.
    Constant(DVec3),
    /// Name of a texture in the imported scene, and the mean of its values.
    Texture(Spanned<String>, DVec3),
}

impl ConvertedTexture {
    /// Returns the constant, or the mean of the values over the texture.
    pub fn mean(&self) -> DVec3 {
        match self {
            Self::Constant(mean) | Self::Texture(_, mean) => *mean,
        }
    }

    /// Returns the constant or texture as a color parameter.
    pub fn into_color(self) -> TexturedValue<DVec3> {
        match self {
            Self::Constant(color) => TexturedValue::Constant(color),
            Self::Texture(name, _) => TexturedValue::Texture(name),
        }
    }

    /// Returns the constant or texture as a number parameter. All channels of a constant are equal.
    pub fn into_number(self) -> TexturedValue<f64> {
        match self {
            Self::Constant(color) => TexturedValue::Constant(color.x),
            Self::Texture(name, _) => TexturedValue::Texture(name),
        }
    }
}
