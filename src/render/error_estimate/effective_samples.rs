//! Effective sample count: the number of independent values with as much scatter as the noise of a
//! picture.

use crate::color::Rgb;

/// Estimates the noise variance of independent pictures, and the effective sample count of the
/// noise.
///
/// The difference of two pictures, divided by √2, contains only noise. Its mean square is the
/// variance. Let Σ be the covariance matrix of the pixels. The scalar product of two differences
/// without a common picture has mean zero and variance tr Σ². The effective sample count is (tr Σ)²
/// / tr Σ² (Satterthwaite 1946).
#[derive(Clone, Debug, Default)]
pub(super) struct EffectiveSampleCount {
    /// Number of added pictures.
    pictures: u32,
    /// The picture that was added last.
    previous: Vec<Rgb>,
    /// The last two differences between successive pictures, divided by √2. A new one replaces the
    /// older.
    differences: [Vec<Rgb>; 2],
    variances: RunningMoments,
    products: RunningMoments,
}

/// Effective sample count that is assumed before anything is measured.
const PRIOR_SAMPLES: f64 = 100.0;

/// Weight of [`PRIOR_SAMPLES`], which counts as this many measured products of differences.
const PRIOR_PRODUCTS: f64 = 2.0;

/// Running mean and running sum of squared deviations (Welford 1962).
#[derive(Clone, Copy, Debug, Default)]
struct RunningMoments {
    count: f64,
    mean: f64,
    m2: f64,
}

impl RunningMoments {
    fn add(&mut self, x: f64) {
        self.count += 1.0;
        let delta = x - self.mean;
        self.mean += delta / self.count;
        self.m2 += delta * (x - self.mean);
    }
}

impl EffectiveSampleCount {
    /// Adds a picture, and measures its difference from the previous picture.
    ///
    /// `weights` holds a factor on the squared difference of each pixel. Half of the weighted
    /// squared difference is clamped to `max`.
    pub fn add(&mut self, picture: impl Iterator<Item = Rgb>, weights: &[f64], max: f64) {
        self.pictures += 1;
        if self.pictures == 1 {
            self.previous.extend(picture);
            return;
        }
        let n = weights.len() as f64;
        let (mut square, mut product) = (0.0, 0.0);
        let old = &mut self.differences[self.pictures as usize % 2];
        old.resize(weights.len(), Rgb::ZERO);
        for (((value, previous), old), weight) in picture.zip(&mut self.previous).zip(old).zip(weights) {
            let mut difference = (value - *previous) * std::f32::consts::FRAC_1_SQRT_2;
            *previous = value;
            let weighted = weight * difference.as_dvec3().length_squared();
            if weighted > max {
                difference *= (max / weighted).sqrt() as f32;
            }
            square += weighted.min(max);
            product += weight * difference.as_dvec3().dot(old.as_dvec3());
            *old = difference;
        }
        self.variances.add(square / n);
        // `old` held the difference before the last one. It shares no picture with the new one.
        if self.pictures > 3 {
            let product = product / n;
            self.products.add(product * product);
        }
    }

    /// Returns the relative variance of the squared error of a picture: 2 / effective sample count.
    ///
    /// The formula holds for Gaussian noise.
    pub fn squared_error_variance(&self) -> f64 {
        let v = self.variances.mean;
        if v <= 0.0 {
            return 0.0;
        }
        let RunningMoments { count, mean, .. } = self.products;
        2.0 * ((mean / (v * v) * count + PRIOR_PRODUCTS / PRIOR_SAMPLES) / (count + PRIOR_PRODUCTS)).min(1.0)
    }

    /// Returns the relative variance of the estimated noise variance. Fireflies make it large.
    pub fn relative_variance_of_variance(&self) -> f64 {
        let RunningMoments { count, mean, m2 } = self.variances;
        if count < 2.0 || mean <= 0.0 {
            return if mean > 0.0 { 2.0 } else { 0.0 };
        }
        // Consecutive differences share a picture, so n of them count as 2n/3 independent ones.
        1.5 * m2 / (count - 1.0) / count / (mean * mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Dimension, Key, Purpose};

    /// Returns the effective sample count of `pictures` pictures of uniform noise, in which each
    /// run of `block` pixels is equal.
    fn effective_samples_of_block_noise(block: usize, pixels: usize, pictures: u64) -> EffectiveSampleCount {
        let mut samples = EffectiveSampleCount::default();
        let weights = vec![1.0; pixels];
        for picture in 0..pictures {
            let key = Key::new(9).purpose_key(Purpose::Test).child_key(picture);
            let value = |i: usize| Rgb::X * key.child_key((i / block) as u64).uniform_1d(Dimension::Film);
            samples.add((0..pixels).map(value), &weights, f64::INFINITY);
        }
        samples
    }

    /// 240 pixels in runs of b equal ones make 240/b independent samples. The relative error of a
    /// sample count from K independent products is √(2/K), with K ≥ 397/2. The tolerance is five
    /// standard deviations.
    #[test]
    fn equal_pixels_count_as_one_sample() {
        for block in [1, 4, 24] {
            let samples = effective_samples_of_block_noise(block, 240, 400);
            assert!((samples.variances.mean * 12.0 - 1.0).abs() < 5.0 * (3.0 * block as f64 / 240.0 / 399.0).sqrt());
            let independent = 2.0 / samples.squared_error_variance();
            let expected = 240.0 / block as f64;
            assert!((independent / expected - 1.0).abs() < 5.0 * (2.0 / 198f64).sqrt(), "{independent} {expected}");
        }
    }

    #[test]
    fn few_pictures_give_the_prior_and_black_gives_zero() {
        assert_eq!(
            (
                effective_samples_of_block_noise(1, 10, 1).squared_error_variance(),
                effective_samples_of_block_noise(1, 10, 3).squared_error_variance()
            ),
            (0.0, 2.0 / PRIOR_SAMPLES)
        );
        assert_eq!(effective_samples_of_block_noise(1, 10, 2).relative_variance_of_variance(), 2.0);
        assert!(effective_samples_of_block_noise(10, 10, 12).squared_error_variance() > 10.0 * 2.0 / PRIOR_SAMPLES);
        let mut black = EffectiveSampleCount::default();
        (0..8).for_each(|_| black.add(std::iter::repeat_n(Rgb::ZERO, 4), &[1.0; 4], 1.0));
        assert_eq!((black.squared_error_variance(), black.relative_variance_of_variance()), (0.0, 0.0));
    }
}
