//! Camera ray, and the other inputs of its path.

use super::prefix_rays::PrefixWeights;
use crate::math::Ray;
use crate::sampling::Sampler;
use glam::Vec2;

/// Start of one camera path: the camera ray, and the sampler, shutter slice and weights of its
/// path.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraRay {
    pub ray: Ray,
    /// Sampler of the random decisions at the path's first vertex.
    pub sampler: Sampler,
    /// Film position \[pixels from the top left] at which the weights of indirect light are looked
    /// up: the center of the ray's pixel in a render, the film point itself in a pilot.
    pub weight_lookup_position: Vec2,
    /// Index of the slice of the shutter interval in which the ray is traced.
    pub shutter_slice: usize,
    /// Weights of the light that the path finds up to its first receiver (surface or medium that
    /// stores photons).
    pub prefix_weights: PrefixWeights,
}
