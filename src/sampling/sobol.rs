//! Owen-scrambled Sobol' points in two dimensions.

use super::{Dimension, Key, key::uniform_from_24_bits};
use glam::Vec2;

/// Point `index` of a two-dimensional Sobol' sequence with Owen scrambling, in \[0, 1)².
///
/// The random key `key` and `dimension` seed the scrambling; different seeds give independent
/// sequences. Over random seeds, each point is uniformly distributed. If 2ᵏ consecutive indices
/// start at a multiple of 2ᵏ, then each elementary interval of area 2⁻ᵏ contains one of their
/// points. Source: Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4).
#[inline]
#[must_use]
pub fn sobol_2d(index: u32, key: Key, dimension: Dimension) -> Vec2 {
    let seed = key.random_bits(dimension);
    let (order, x, y) = (seed as u32, (seed >> 32) as u32, (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32);
    let i = owen_scramble(index, order);
    Vec2::new(
        uniform_from_24_bits(owen_scramble(i.reverse_bits(), x) >> 8),
        uniform_from_24_bits(owen_scramble(sobol_second_dimension(i), y) >> 8),
    )
}

/// Second coordinate of the unscrambled Sobol' point `index`, as a 32-bit binary fraction. Its
/// generator matrix is Pascal's triangle modulo 2.
#[inline]
fn sobol_second_dimension(index: u32) -> u32 {
    let mut v = index.reverse_bits();
    v ^= (v & 0x5555_5555) << 1;
    v ^= (v & 0x3333_3333) << 2;
    v ^= (v & 0x0f0f_0f0f) << 4;
    v ^= (v & 0x00ff_00ff) << 8;
    v ^= (v & 0x0000_ffff) << 16;
    v
}

/// Owen scrambling of the binary fraction `x`: each bit is flipped or not, by a hash of `seed` and
/// all higher bits.
#[inline]
fn owen_scramble(x: u32, seed: u32) -> u32 {
    laine_karras_hash(x.reverse_bits(), seed).reverse_bits()
}

/// Hash in which each bit depends only on itself and lower bits (Laine and Karras 2011, with
/// constants of Vegdahl).
#[inline]
fn laine_karras_hash(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Purpose;

    #[test]
    fn every_elementary_interval_holds_one_sobol_point() {
        for seed in 0..8 {
            let key = Key::new(seed).purpose_key(Purpose::Test);
            let points: Vec<_> = (0..256).map(|i| sobol_2d(i, key, Dimension::LightDirection)).collect();
            for log_columns in 0..=8u32 {
                let (columns, rows) = (1usize << log_columns, 1usize << (8 - log_columns));
                let mut seen = vec![false; 256];
                for p in &points {
                    let cell = (p.y * rows as f32) as usize * columns + (p.x * columns as f32) as usize;
                    assert!(!std::mem::replace(&mut seen[cell], true), "seed {seed}, {columns} columns");
                }
            }
        }
    }

    /// Checks that one Sobol' point, averaged over many random keys, has the mean ½ in both
    /// coordinates, within five standard deviations. The variance of a uniform number is 1/12.
    #[test]
    fn each_sobol_point_alone_is_uniform() {
        let n = 20_000;
        let mean = (0..n).map(|s| sobol_2d(5, Key::new(s), Dimension::Film)).sum::<Vec2>() / n as f32;
        let bound = 5.0 * (1.0 / 12.0f32 / n as f32).sqrt();
        assert!((mean - 0.5).abs().max_element() < bound, "{mean}");
    }
}
