//! Textured material parameters, bump maps and normal maps.

mod footprint;
mod normals;

pub(super) use footprint::TextureFootprint;
pub use normals::NormalPerturbation;
pub(super) use normals::perturbed_normal;

use crate::bsdf::MIN_PHOTON_STORAGE_ALPHA;
use crate::color::Rgb;
use crate::texture::{Texture, TextureEvalContext};
use std::sync::Arc;

/// A material parameter: a constant, or a texture times a factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialParameter<T> {
    /// The parameter has one value everywhere.
    Constant(T),
    /// The parameter is a texture times a factor.
    Texture {
        /// Index of the texture in the scene.
        texture: u32,
        /// Factor by which the texture's values are multiplied.
        factor: T,
        /// Mean of texture times factor. It replaces the texture if
        /// [`Effect::Textures`](crate::scene::Effect::Textures) is off.
        mean: T,
    },
}

impl<T> From<T> for MaterialParameter<T> {
    fn from(value: T) -> Self {
        Self::Constant(value)
    }
}

impl<T: Copy> MaterialParameter<T> {
    /// The constant value, or the mean of the texture times its factor.
    #[inline]
    #[must_use]
    pub fn mean(&self) -> T {
        match *self {
            Self::Constant(value) | Self::Texture { mean: value, .. } => value,
        }
    }

    /// True if a texture determines the parameter's value.
    #[inline]
    #[must_use]
    pub fn is_textured(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Texture { .. } => true,
        }
    }
}

/// Evaluates material parameters at one point (compare pbrt-v4's `TextureEvaluator`).
pub trait ParameterEvaluator {
    /// Evaluates a colour parameter.
    fn evaluate_color(&self, parameter: &MaterialParameter<Rgb>) -> Rgb;

    /// Evaluates a scalar parameter.
    fn evaluate_scalar(&self, parameter: &MaterialParameter<f32>) -> f32;

    /// Evaluates the roughness α of a BSDF that stores photons only where α exceeds
    /// [`MIN_PHOTON_STORAGE_ALPHA`].
    ///
    /// Camera paths and photon paths have different filter footprints, but must agree on whether a
    /// point stores photons. So the filtered α is clamped to the side of
    /// [`MIN_PHOTON_STORAGE_ALPHA`] on which the unfiltered α lies.
    fn evaluate_photon_storage_roughness(&self, parameter: &MaterialParameter<f32>) -> f32;
}

/// A [`ParameterEvaluator`] that returns the mean of each parameter, without texture lookups.
#[derive(Clone, Copy, Debug)]
pub struct MeanParameterEvaluator;

impl ParameterEvaluator for MeanParameterEvaluator {
    fn evaluate_color(&self, parameter: &MaterialParameter<Rgb>) -> Rgb {
        parameter.mean()
    }

    fn evaluate_scalar(&self, parameter: &MaterialParameter<f32>) -> f32 {
        parameter.mean()
    }

    fn evaluate_photon_storage_roughness(&self, parameter: &MaterialParameter<f32>) -> f32 {
        parameter.mean()
    }
}

/// A [`ParameterEvaluator`] that looks textures up at one point.
#[derive(Clone, Copy, Debug)]
pub struct TextureEvaluator<'a> {
    /// The textures of the scene.
    pub textures: &'a [Arc<Texture>],
    /// The point at which textures are evaluated, with the footprint to filter over.
    pub context: TextureEvalContext,
}

impl ParameterEvaluator for TextureEvaluator<'_> {
    fn evaluate_color(&self, parameter: &MaterialParameter<Rgb>) -> Rgb {
        match *parameter {
            MaterialParameter::Constant(value) => value,
            MaterialParameter::Texture { texture, factor, .. } => {
                factor * self.textures[texture as usize].evaluate_color(&self.context)
            }
        }
    }

    fn evaluate_scalar(&self, parameter: &MaterialParameter<f32>) -> f32 {
        match *parameter {
            MaterialParameter::Constant(value) => value,
            MaterialParameter::Texture { texture, factor, .. } => {
                factor * self.textures[texture as usize].evaluate_scalar(&self.context)
            }
        }
    }

    fn evaluate_photon_storage_roughness(&self, parameter: &MaterialParameter<f32>) -> f32 {
        if !parameter.is_textured() {
            return parameter.mean();
        }
        let unfiltered =
            Self { context: TextureEvalContext::unfiltered(self.context.uv, self.context.object_p), ..*self };
        let alpha = self.evaluate_scalar(parameter);
        if unfiltered.evaluate_scalar(parameter) > MIN_PHOTON_STORAGE_ALPHA {
            alpha.max(MIN_PHOTON_STORAGE_ALPHA.next_up())
        } else {
            alpha.min(MIN_PHOTON_STORAGE_ALPHA)
        }
    }
}
