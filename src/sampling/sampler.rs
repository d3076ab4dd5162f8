//! Random numbers of one sample among several.

use super::{Dimension, Key, sobol_2d};
use glam::Vec2;

/// The numbers of sample `index` of several that share a key: together they are spread evenly in each dimension, each alone is
/// uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    key: Key,
    index: u32,
    count: u32,
}

impl Sampler {
    /// Sample `index` of `count`.
    #[must_use]
    pub fn new(key: Key, index: u32, count: u32) -> Self {
        Self { key, index, count }
    }

    /// The same sample at part `n` of the key: a bounce, a light.
    #[inline]
    #[must_use]
    pub fn with(self, n: u64) -> Self {
        Self { key: self.key.with(n), ..self }
    }

    /// Sample `index` of `count` into which this one divides.
    #[inline]
    #[must_use]
    pub fn of(self, index: u32, count: u32) -> Self {
        Self {
            index: self.index.wrapping_mul(count).wrapping_add(index),
            count: self.count.wrapping_mul(count),
            ..self
        }
    }

    /// A key of this sample alone.
    #[inline]
    #[must_use]
    pub fn key(self) -> Key {
        self.key.with(u64::from(self.index))
    }

    /// Which of how many.
    #[inline]
    #[must_use]
    pub fn place(self) -> (u32, u32) {
        (self.index, self.count)
    }

    /// A number in \[0, 1).
    #[inline]
    #[must_use]
    pub fn get_1d(self, dimension: Dimension) -> f32 {
        if self.count > 1 { self.get_2d(dimension).x } else { self.key.uniform(dimension) }
    }

    /// A point in \[0, 1)².
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
    fn samples_of_one_key_are_spread_and_parts_divide_them() {
        let key = Key::new(4).purpose(Purpose::Test);
        let mut seen = [false; 64];
        for sample in 0..16 {
            for ray in 0..4 {
                let x = Sampler::new(key, sample, 16).of(ray, 4).get_1d(Dimension::Light);
                let cell = &mut seen[(x * 64.0) as usize];
                assert!(!std::mem::replace(cell, true), "two of 64 numbers in one 64th");
            }
        }
        let alone = Sampler::new(key, 0, 1);
        assert_eq!(alone.get_2d(Dimension::Film), key.uniform_2d(Dimension::Film));
        assert_ne!(Sampler::new(key, 0, 2).key(), Sampler::new(key, 1, 2).key());
    }
}
