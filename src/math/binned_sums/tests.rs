use super::*;
use crate::math::CompensatedSum;
use glam::DVec3;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

/// Returns a pseudorandom number in \[0, 1) for each pair of arguments.
fn uniform(i: u64, which: u64) -> f64 {
    SmallRng::seed_from_u64(1000 * i + which).random()
}

/// Returns values of random sign, and their squares. The absolute values are from 10⁻³⁰ to 2·10³⁰.
fn wide_values(count: u64) -> Vec<[f64; 2]> {
    let value = |i| {
        let size = libm::pow(10.0, 60.0 * uniform(i, 0) - 30.0) * (1.0 + uniform(i, 1));
        let value = if uniform(i, 2) < 0.5 { -size } else { size };
        [value, value * value]
    };
    (0..count).map(value).collect()
}

fn sum_of<'a, const N: usize>(values: impl IntoIterator<Item = &'a [f64; N]>) -> BinnedSums<N> {
    let mut sums = BinnedSums::new(1);
    values.into_iter().for_each(|value| sums.add_to_all_pixels(|_| *value));
    sums
}

/// Returns the sum of `values`: deals them at random to `parts` partial sums, and merges the
/// partial sums in random order.
fn merged_sum<const N: usize>(values: &[[f64; N]], parts: u64, seed: u64) -> BinnedSums<N> {
    let mut dealt = vec![BinnedSums::new(1); parts as usize];
    let mut order: Vec<_> = (0..values.len()).collect();
    let rank = |i: &usize| uniform(*i as u64, 100 + seed);
    order.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    for i in order {
        let part = (parts as f64 * uniform(i as u64, seed)) as usize;
        dealt[part].add_to_all_pixels(|_| values[i]);
    }
    // Merge the last partial sum into a random other one. So sums of different numbers of values
    // are merged.
    while dealt.len() > 1 {
        let last = dealt.pop().unwrap();
        let at = (dealt.len() as f64 * uniform(dealt.len() as u64, seed)) as usize;
        dealt[at].merge(&last);
    }
    dealt.pop().unwrap()
}

#[test]
fn sums_are_independent_of_order_and_grouping() {
    let values = wide_values(300);
    for length in [1, 2, 7, 300] {
        let expected = sum_of(&values[..length]);
        for seed in 0..40 {
            let merged = merged_sum(&values[..length], 1 + seed % 9, seed);
            assert_eq!(merged, expected, "{length} values, seed {seed}");
        }
    }
}

#[test]
fn sum_errors_stay_below_their_bound() {
    for (scale, count) in [(1.0, 1000u32), (1e-30, 10), (1e30, 10), (3e4, 1000), (1e60, 100)] {
        let values: Vec<_> = (0..count).map(|i| [scale * (uniform(i.into(), 7) - 0.3)]).collect();
        let sums = sum_of(&values);
        let largest = values.iter().fold(0.0, |most: f64, v| most.max(v[0].abs()));
        assert!(sums.lower_quantum(0) <= largest / libm::exp2(30.0), "{scale:e}");
        let mut exact = CompensatedSum::default();
        values.iter().for_each(|value| exact.add(DVec3::splat(value[0])));
        let exact = exact.value().x;
        let bound = f64::from(count) * 0.5 * sums.lower_quantum(0) + 2.0 * f64::EPSILON * exact.abs();
        assert!((sums.pixel_sums(0)[0] - exact).abs() <= bound, "{scale:e}");
    }
}

/// Sums of f32 values between 2⁻¹⁶ and 2¹⁵ are exact, since such values are multiples of the lower
/// quantum.
#[test]
fn common_values_are_summed_exactly() {
    let values: Vec<_> = (0..1000).map(|i| [f64::from((0.5 * uniform(i, 3) + 1e-4) as f32)]).collect();
    let exact: i128 = values.iter().map(|v| (v[0] * libm::exp2(60.0)) as i128).sum();
    assert_eq!(sum_of(&values).pixel_sums(0)[0], exact as f64 / libm::exp2(60.0));
}

/// The smallest f32 is summed exactly. The sum of 2³¹ terms, each three times the
/// square of the largest f32, is finite.
#[test]
fn sums_hold_the_whole_f32_range() {
    let tiny = f64::from(f32::from_bits(1));
    assert_eq!(sum_of(&[[tiny], [tiny]]).pixel_sums(0), [2.0 * tiny]);
    assert_eq!(sum_of(&[[tiny * tiny]]).pixel_sums(0), [tiny * tiny]);
    let large = 3.0 * f64::from(f32::MAX) * f64::from(f32::MAX);
    let mut sums = sum_of(&[[large, -large]]);
    for _ in 0..31 {
        let same = sums.clone();
        sums.merge(&same);
    }
    let [sum, negative] = sums.pixel_sums(0).map(|sum| sum / (large * libm::exp2(31.0)));
    assert!((sum - 1.0).abs() < 1e-9 && sum == -negative, "{sum}");
}

#[test]
fn sums_keep_infinities_and_nans() {
    let (infinity, nan) = (f64::INFINITY, f64::NAN);
    let values = [[1.0, infinity, nan], [infinity, -infinity, 2.0], [3.0, 0.0, libm::exp2(263.0)]];
    for seed in 0..40 {
        let merged = merged_sum(&values, 1 + seed % 3, seed);
        assert_eq!(merged, sum_of(&values));
        let [a, b, c] = merged.pixel_sums(0);
        assert!(a == infinity && b.is_nan() && c.is_nan(), "{a} {b} {c}");
    }
    assert_eq!(sum_of(&[[-infinity, 5.0, libm::exp2(263.0)]]).pixel_sums(0), [-infinity, 5.0, infinity]);
    assert_eq!(sum_of(&[[-libm::exp2(263.0), 5.0, 1e79]]).pixel_sums(0), [-infinity, 0.0, 1e79]);
}
