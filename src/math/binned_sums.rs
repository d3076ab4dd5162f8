//! Binned sums: sums of floating-point numbers that do not depend on the order of the terms.

use rayon::prelude::*;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Binary logarithm of [`QUANTUM_RATIO`].
const QUANTUM_RATIO_LOG2: i32 = 31;

/// Ratio between the upper and the lower quantum of a pixel: 2³¹.
///
/// A quantum is the unit of an integer sum. [`BinnedSums`] describes both quanta of a pixel.
const QUANTUM_RATIO: f64 = (1u64 << QUANTUM_RATIO_LOG2) as f64;

/// Number of levels. All values of a pixel are summed in two integers, and the pixel's level
/// selects the two units (quanta) of these integers. Higher levels have larger units.
///
/// With 18 levels, even the sum of the squares of three f32 values stays finite, because it is
/// below the limit of the last level. Values beyond this limit count as infinite.
const LEVELS: usize = 18;

/// Binary exponent of the unit of the upper integer sum at level 0: the unit is 2⁻²⁹⁴.
///
/// With this exponent, one level holds all absolute values from 2⁻¹⁶ to 2¹⁵, which are common in
/// pictures. The unit of its lower integer sum is 2⁻⁴⁶, so f32 values in this range are summed
/// exactly.
const FIRST_EXPONENT: i32 = -294;

/// Unit (upper quantum) of a pixel's upper integer sum, for each level.
const UPPER_QUANTA: [f64; LEVELS] = powers_of_two(FIRST_EXPONENT, QUANTUM_RATIO_LOG2);

/// Inverses of the [`UPPER_QUANTA`], one for each level.
const INVERSE_UPPER_QUANTA: [f64; LEVELS] = powers_of_two(-FIRST_EXPONENT, -QUANTUM_RATIO_LOG2);

/// Limit of the absolute values of a pixel, for each level. A value at or above the limit of the
/// pixel's level raises this level. The limit is half the unit of the next level's upper sum.
const LEVEL_LIMITS: [f64; LEVELS] = powers_of_two(FIRST_EXPONENT + QUANTUM_RATIO_LOG2 - 1, QUANTUM_RATIO_LOG2);

/// The number 1.5·2⁵². Adding it to a small f64 rounds this f64 to an integer, which the low bits
/// of the sum then hold.
const ROUNDER: f64 = (3u64 << 51) as f64;

/// Number of low bits in the tag of a pixel that store its level. The next higher bits, two for
/// each channel, tell whether the channel's sum is +∞, −∞ or NaN.
const LEVEL_BITS: u16 = 5;

/// Smallest number of pixels that one Rayon task handles.
const MIN_PIXELS_PER_TASK: usize = 2048;

/// Sums of values in N channels, for each pixel of a picture. The bits of a sum do not depend on
/// the order in which the values were added.
///
/// Each sum is two integers. The upper integer sums the values, rounded to multiples of an *upper
/// quantum*. The lower integer sums the remainders, rounded to multiples of a *lower quantum*,
/// which is 2⁻³¹ upper quanta. The quanta are chosen so that the largest absolute value of the
/// pixel is between 2⁻¹ and 2³⁰ upper quanta. So the error of a value is at most 2⁻³¹ of the
/// pixel's largest value. When a larger value arrives, the upper integers become the lower ones,
/// and the old lower ones are dropped. So the integers depend only on the set of values (Ahrens,
/// Demmel and Nguyen 2020, with integers as bins).
///
/// A pixel holds at most 2³² − 1 values. Absolute values of 2²⁶³ and more count as infinite.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BinnedSums<const N: usize> {
    /// Integer sums of each pixel: first the upper integers of all channels, then the lower ones.
    integer_sums: Vec<[[i64; N]; 2]>,
    /// Tag of each pixel. Its low [`LEVEL_BITS`] bits hold the level of the pixel, and its higher
    /// bits mark sums of +∞, −∞ or NaN.
    tags: Vec<u16>,
}

impl<const N: usize> BinnedSums<N> {
    /// Memory of the sums of one pixel \[bytes].
    pub const BYTES_PER_PIXEL: usize = size_of::<[[i64; N]; 2]>() + size_of::<u16>();

    /// Returns empty sums for `pixels` pixels.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        const { assert!(LEVEL_BITS as usize + 2 * N <= u16::BITS as usize, "too many channels for a tag") };
        Self { integer_sums: vec![[[0; N]; 2]; pixels], tags: vec![0; pixels] }
    }

    /// Returns the number of pixels.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.tags.len()
    }

    /// True if there are no pixels.
    #[must_use]
    pub fn has_no_pixels(&self) -> bool {
        self.tags.is_empty()
    }

    /// Adds the N values `value(i)`, one for each channel, to each pixel `i`.
    #[inline]
    pub fn add_to_all_pixels(&mut self, value: impl Fn(usize) -> [f64; N] + Sync) {
        let pixels = self.integer_sums.par_iter_mut().zip(&mut self.tags).enumerate();
        pixels.with_min_len(MIN_PIXELS_PER_TASK).for_each(|(i, (integer_sums, tag))| {
            let values = value(i);
            let level = level_of(*tag);
            let limit = LEVEL_LIMITS[level];
            if values.iter().fold(true, |fit, value| fit & (value.abs() < limit)) {
                add_to_integer_sums(integer_sums, level, values);
            } else {
                add_beyond_limit(integer_sums, tag, values);
            }
        });
    }

    /// Adds the sums of `other`, which has the same number of pixels.
    pub fn merge(&mut self, other: &Self) {
        let own = self.integer_sums.par_iter_mut().zip(&mut self.tags);
        let pixels = own.zip(other.integer_sums.par_iter().zip(&other.tags));
        pixels.with_min_len(MIN_PIXELS_PER_TASK).for_each(|((integer_sums, tag), (other_sums, other_tag))| {
            let mut other_sums = *other_sums;
            let level = level_of(*tag).max(level_of(*other_tag));
            raise_level(&mut other_sums, &mut other_tag.clone(), level);
            raise_level(integer_sums, tag, level);
            *tag |= *other_tag >> LEVEL_BITS << LEVEL_BITS;
            for (sums, others) in integer_sums.iter_mut().zip(other_sums) {
                (0..N).for_each(|channel| sums[channel] += others[channel]);
            }
        });
    }

    /// Returns the sums of pixel `i`, rounded to f64.
    #[inline]
    #[must_use]
    pub fn pixel_sums(&self, i: usize) -> [f64; N] {
        let ([upper, lower], tag) = (self.integer_sums[i], self.tags[i]);
        let quantum = self.lower_quantum(i);
        let mut sums = [0.0; N];
        for channel in 0..N {
            // Carry whole upper quanta from the lower to the upper bin, so that only the last
            // addition rounds.
            let carry = lower[channel] >> QUANTUM_RATIO_LOG2;
            let rest = lower[channel] - (carry << QUANTUM_RATIO_LOG2);
            sums[channel] = ((upper[channel] + carry) as f64 * QUANTUM_RATIO + rest as f64) * quantum;
        }
        if usize::from(tag) >= 1 << LEVEL_BITS {
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum = match tag >> (LEVEL_BITS + 2 * channel as u16) & 3 {
                    0 => *sum,
                    1 => f64::INFINITY,
                    2 => f64::NEG_INFINITY,
                    _ => f64::NAN,
                };
            }
        }
        sums
    }

    /// Returns the lower quantum of pixel `i`: the unit to whose multiples all values of the pixel
    /// are rounded.
    #[inline]
    #[must_use]
    pub fn lower_quantum(&self, i: usize) -> f64 {
        UPPER_QUANTA[level_of(self.tags[i])] / QUANTUM_RATIO
    }
}

/// Serialized form of [`BinnedSums`], as film files store it.
#[derive(Serialize, Deserialize)]
struct StoredSums {
    /// For each pixel: upper integers of all channels, then lower integers of all channels.
    integer_sums: Vec<i64>,
    tags: Vec<u16>,
}

impl<const N: usize> Serialize for BinnedSums<N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let integer_sums = self.integer_sums.iter().flatten().flatten().copied().collect();
        StoredSums { integer_sums, tags: self.tags.clone() }.serialize(serializer)
    }
}

impl<'de, const N: usize> Deserialize<'de> for BinnedSums<N> {
    /// Reads the sums. Fails if there are not 2N integers for each tag (one tag per pixel), or if a
    /// tag is invalid.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredSums { integer_sums, tags } = StoredSums::deserialize(deserializer)?;
        let is_valid = |tag: &u16| level_of(*tag) < LEVELS && usize::from(*tag) >> LEVEL_BITS < 1 << (2 * N);
        if integer_sums.len() != 2 * N * tags.len() || !tags.iter().all(is_valid) {
            return Err(D::Error::custom("sums of a picture are inconsistent"));
        }
        let pixel = |sums: &[i64]| [0, N].map(|first| std::array::from_fn(|channel| sums[first + channel]));
        Ok(Self { integer_sums: integer_sums.chunks_exact(2 * N).map(pixel).collect(), tags })
    }
}

/// Returns `LEVELS` powers of two, whose exponents are `first`, `first + step` and so on.
const fn powers_of_two(first: i32, step: i32) -> [f64; LEVELS] {
    let mut powers = [0.0; LEVELS];
    let mut i = 0;
    while i < LEVELS {
        powers[i] = f64::from_bits(((1023 + first + step * i as i32) as u64) << 52);
        i += 1;
    }
    powers
}

/// Returns the level of a pixel from its tag. The level is the index of the pixel's quanta in
/// [`UPPER_QUANTA`].
#[inline]
fn level_of(tag: u16) -> usize {
    usize::from(tag & ((1 << LEVEL_BITS) - 1))
}

/// Adds `values`, one for each channel, to the integer sums of a pixel of the given level.
///
/// All absolute values must be below the limit of this level.
#[inline]
fn add_to_integer_sums<const N: usize>(integer_sums: &mut [[i64; N]; 2], level: usize, values: [f64; N]) {
    let inverse = INVERSE_UPPER_QUANTA[level];
    let integer = |rounded: f64| rounded.to_bits().wrapping_sub(ROUNDER.to_bits()) as i64;
    let [upper, lower] = integer_sums;
    for channel in 0..N {
        // Products with powers of two are exact, and so is the difference between `scaled` and the
        // rounded number.
        let scaled = values[channel] * inverse;
        let rounded = scaled + ROUNDER;
        let rest = (scaled - (rounded - ROUNDER)) * QUANTUM_RATIO;
        upper[channel] += integer(rounded);
        lower[channel] += integer(rest + ROUNDER);
    }
}

/// Adds `values`, one for each channel, to a pixel whose level is too low for one of them. Raises
/// the level of the pixel first.
///
/// A value that is not finite, or beyond the limit of the last level, is not added. It sets a flag
/// of its channel in `tag` instead.
#[cold]
fn add_beyond_limit<const N: usize>(integer_sums: &mut [[i64; N]; 2], tag: &mut u16, mut values: [f64; N]) {
    for (channel, value) in values.iter_mut().enumerate() {
        let infinities = match *value {
            v if v.is_nan() => 3,
            v if v >= LEVEL_LIMITS[LEVELS - 1] => 1,
            v if v <= -LEVEL_LIMITS[LEVELS - 1] => 2,
            _ => continue,
        };
        *tag |= infinities << (LEVEL_BITS + 2 * channel as u16);
        *value = 0.0;
    }
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let level = LEVEL_LIMITS.partition_point(|limit| *limit <= largest).max(level_of(*tag));
    raise_level(integer_sums, tag, level);
    add_to_integer_sums(integer_sums, level, values);
}

/// Raises the level of a pixel to `level`, which is not below the pixel's present level.
fn raise_level<const N: usize>(integer_sums: &mut [[i64; N]; 2], tag: &mut u16, level: usize) {
    let steps = level - level_of(*tag);
    // Old values are below half a new upper quantum, so the new upper integers are 0. The old upper
    // integers become the new lower ones, or round to 0 if `level` is two or more levels higher.
    match steps {
        0 => {}
        1 => *integer_sums = [[0; N], integer_sums[0]],
        _ => *integer_sums = [[0; N]; 2],
    }
    *tag += steps as u16;
}

#[cfg(test)]
mod tests;
