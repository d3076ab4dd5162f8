//! Camera ray with the inputs of its path.

use super::prefix_rays::PrefixWeights;
use crate::math::Ray;
use crate::sampling::Sampler;
use glam::Vec2;

/// A camera ray, with everything that its path reads and other rays of the pass do not share.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraRay {
    pub ray: Ray,
    /// Sampler of the path's first vertex.
    pub sampler: Sampler,
    /// Film position \[pixels from the top left] for which weights are looked up: in a render, the
    /// center of the ray's pixel; in a pilot that traces film points, the point.
    pub weight_lookup_position: Vec2,
    /// Index of the slice of the shutter interval in which the ray is traced.
    pub shutter_slice: usize,
    /// Weights of the light that the path finds up to its first receiver.
    pub prefix_weights: PrefixWeights,
}
