//! Random numbers for several samples, stratified over these samples.

use super::{Dimension, Key, sobol_2d};
use glam::Vec2;

/// Source of random numbers for one sample: number `index` of `count` samples that share a random
/// key.
///
/// Each number is uniform. In each dimension, the numbers of the `count` samples are stratified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    key: Key,
    index: u32,
    count: u32,
}

impl Sampler {
    /// Creates the sampler of sample number `index` among `count` samples that share the random key
    /// `key`.
    #[must_use]
    pub fn new(key: Key, index: u32, count: u32) -> Self {
        Self { key, index, count }
    }

    /// Sampler for the same sample with a child of its random key: the hash of this key and the
    /// number `n`.
    ///
    /// Other code should call a function with a specific name instead, such as
    /// [`Sampler::shadow_ray_sampler`].
    #[inline]
    #[must_use]
    pub fn child_sampler(self, n: u64) -> Self {
        Self { key: self.key.child_key(n), ..self }
    }

    /// Sampler for the path vertex after `bounce` bounces.
    ///
    /// At some vertices, a path splits into a reflected and a transmitted branch. `transmitted` is
    /// true for the transmitted one, so that the two branches get different random numbers.
    #[inline]
    #[must_use]
    pub fn next_vertex_sampler(self, bounce: u32, transmitted: bool) -> Self {
        self.child_sampler(u64::from(bounce) << 1 | u64::from(transmitted))
    }

    /// Sampler for the vertex after `bounce` bounces of a path of a pilot simulation. Such paths
    /// never split.
    #[inline]
    #[must_use]
    pub fn pilot_bounce_sampler(self, bounce: u32) -> Self {
        self.child_sampler(u64::from(bounce))
    }

    /// Sampler for the shadow rays of a path vertex in pass `pass`. `self` is the sampler of the
    /// vertex.
    ///
    /// Passes that share camera paths still get different shadow rays.
    #[inline]
    #[must_use]
    pub fn shadow_ray_sampler(self, pass: u32) -> Self {
        self.child_sampler(u64::from(pass) << 32)
    }

    /// Sampler for one of several shadow rays of a path vertex. `self` is the sampler of all shadow
    /// rays of the vertex. If each light gets a shadow ray, `index` is the index of the light. If
    /// lights are chosen at random, `index` is the number of the ray.
    #[inline]
    #[must_use]
    pub fn nth_shadow_ray_sampler(self, index: usize) -> Self {
        self.child_sampler(index as u64)
    }

    /// Sampler for one of `count` subsamples into which this sample is split, the one with number
    /// `index`. The subsamples of all samples together are stratified.
    #[inline]
    #[must_use]
    pub fn subsample_sampler(self, index: u32, count: u32) -> Self {
        Self {
            index: self.index.wrapping_mul(count).wrapping_add(index),
            count: self.count.wrapping_mul(count),
            ..self
        }
    }

    /// Random key for numbers of this sample that need not be stratified over the samples. No other
    /// sample has this key.
    #[inline]
    #[must_use]
    pub fn sample_key(self) -> Key {
        self.key.child_key(u64::from(self.index))
    }

    /// Index of this sample, and the number of samples that share its random key. The random
    /// numbers of these samples are stratified together.
    #[inline]
    #[must_use]
    pub fn sample_index_and_count(self) -> (u32, u32) {
        (self.index, self.count)
    }

    /// Returns a uniform number in \[0, 1) for the decision `dimension`, stratified over the
    /// samples.
    #[inline]
    #[must_use]
    pub fn get_1d(self, dimension: Dimension) -> f32 {
        if self.count > 1 { self.get_2d(dimension).x } else { self.key.uniform_1d(dimension) }
    }

    /// Returns a uniform point in \[0, 1)² for the decision `dimension`, stratified over the
    /// samples.
    #[inline]
    #[must_use]
    pub fn get_2d(self, dimension: Dimension) -> Vec2 {
        if self.count > 1 { sobol_2d(self.index, self.key, dimension) } else { self.key.uniform_2d(dimension) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Purpose;

    #[test]
    fn subsamples_are_jointly_stratified() {
        let key = Key::new(4).purpose_key(Purpose::Test);
        let mut occupied = [false; 64];
        for sample in 0..16 {
            for ray in 0..4 {
                let x = Sampler::new(key, sample, 16).subsample_sampler(ray, 4).get_1d(Dimension::Light);
                let cell = &mut occupied[(x * 64.0) as usize];
                assert!(!std::mem::replace(cell, true), "two of 64 numbers share a stratum");
            }
        }
        let alone = Sampler::new(key, 0, 1);
        assert_eq!(alone.get_2d(Dimension::Film), key.uniform_2d(Dimension::Film));
        assert_ne!(Sampler::new(key, 0, 2).sample_key(), Sampler::new(key, 1, 2).sample_key());
    }
}
