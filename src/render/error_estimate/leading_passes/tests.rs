use super::*;
use crate::sampling::{Dimension, Key, Purpose};

/// Returns `passes` passes of uniform noise, in which runs of `block` pixels have equal values.
fn passes_of_block_noise(block: usize, pixels: usize, passes: u32, seed: u64) -> LeadingPassPictures {
    let mut leading = LeadingPassPictures::default();
    for pass in 0..passes {
        let key = Key::new(seed).purpose_key(Purpose::Test).child_key(pass.into());
        let value = |i: usize| Rgb::splat(key.child_key((i / block) as u64).uniform_1d(Dimension::Film));
        leading.add(pass, MAX_LEADING_PASSES, (0..pixels).into_par_iter().map(value));
    }
    leading
}

/// Pixels that are always equal count as one independent sample.
///
/// 240 pixels in runs of b equal pixels make 240/b independent samples. Squared products have a
/// relative variance of 2. So the mean of 20 independent ones, over 100 seeds, has a relative error
/// of √(2/2000).
#[test]
fn equal_pixels_count_as_one_sample() {
    let weights = vec![1.0; 240];
    for block in [1, 4, 24] {
        let (mut mean_variance, mut mean_square) = (0.0, 0.0);
        for seed in 0..100 {
            let noise = passes_of_block_noise(block, 240, 8, seed);
            let (variance, square, count) = noise.variance_and_squared_product(&weights, f64::INFINITY);
            assert_eq!(count, 20.0);
            mean_variance += variance / 100.0;
            mean_square += square / 100.0;
        }
        // Each of the three equal channels has variance 1/12.
        assert!((4.0 * mean_variance - 1.0).abs() < 5.0 * (2.0 * block as f64 / 240.0 / 700.0).sqrt());
        let independent = mean_variance * mean_variance / mean_square;
        let expected = 240.0 / block as f64;
        assert!((independent / expected - 1.0).abs() < 5.0 * (2.0 / 2000f64).sqrt(), "{independent} {expected}");
    }
}

/// A single bright pixel in one pass does not correlate the noise of different passes.
#[test]
fn fireflies_do_not_correlate_passes() {
    let mut leading = LeadingPassPictures::default();
    for pass in 0..8 {
        let value = |i| Rgb::splat(if pass == 3 && i == 5 { 100.0 } else { 0.0 });
        leading.add(pass, 8, (0..50).into_par_iter().map(value));
    }
    let (variance, square, _) = leading.variance_and_squared_product(&[1.0; 50], f64::INFINITY);
    assert!((variance / (3e4 / 50.0 / 8.0) - 1.0).abs() < 1e-6 && square < 1e-12 * variance * variance);
}

#[test]
fn few_passes_give_the_prior_variance() {
    let variance = |passes, block| {
        passes_of_block_noise(block, 10, passes, 9).squared_error_relative_variance(&[1.0; 10], f64::INFINITY)
    };
    assert_eq!([variance(0, 1), variance(1, 1), variance(2, 1)], [2.0 / PRIOR_EFFECTIVE_SAMPLE_COUNT; 3]);
    assert!(variance(8, 10) > 10.0 * 2.0 / PRIOR_EFFECTIVE_SAMPLE_COUNT);
    let mut black = LeadingPassPictures::default();
    (0..8).for_each(|pass| black.add(pass, 8, rayon::iter::repeat_n(Rgb::ZERO, 4)));
    assert_eq!(black.squared_error_relative_variance(&[1.0; 4], 1.0), 0.0);
}
