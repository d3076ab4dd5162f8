//! Effective sample count of the noise of a picture, measured between its leading passes.

use super::pixel_sums::{MIN_PIXELS_PER_TASK, sum_over_pixels};
use crate::color::Rgb;
use rayon::prelude::*;

/// Gray pictures of the leading passes, which are those with the lowest pass numbers. The effective
/// sample count of the noise is measured from these pictures.
///
/// The difference of two passes, divided by √2, contains only noise. Its mean square is the
/// variance of the noise. Let Σ be the covariance matrix of the pixels. The scalar product of two
/// differences without a common pass has mean zero and variance tr Σ². The effective sample count
/// is (tr Σ)² / tr Σ² (Satterthwaite 1946). It is the number of independent values whose mean
/// square varies as much as the mean square of the noise.
///
/// The leading passes depend only on the set of passes, not on the order in which they are added.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct LeadingPassPictures {
    /// Pass number and gray picture (channel means) of each leading pass, by ascending pass number.
    /// Non-finite values are replaced by 0.
    pictures: Vec<(u32, Vec<f32>)>,
}

/// Largest number of stored leading passes. These are the passes with the lowest pass numbers.
const MAX_LEADING_PASSES: usize = 8;

/// Scalar products of pass deviations: entry \[a]\[b] is for the leading passes with the indices a
/// and b. The deviation of a pass is its difference from the mean of all leading passes.
type DeviationProducts = [[f64; MAX_LEADING_PASSES]; MAX_LEADING_PASSES];

/// Effective sample count N that is assumed until passes have measured it. N means that the squared
/// noise varies like the mean square of N independent Gaussian values.
const PRIOR_EFFECTIVE_SAMPLE_COUNT: f64 = 100.0;

/// Weight of [`PRIOR_EFFECTIVE_SAMPLE_COUNT`] in the mean of assumed and measured values. The
/// weight of the measured value is its number of independent scalar products of pass differences.
const PRIOR_WEIGHT_IN_PRODUCTS: f64 = 2.0;

impl LeadingPassPictures {
    /// Adds the picture of pass `number`, and keeps only the `most` passes with the lowest numbers.
    pub fn add(&mut self, number: u32, most: usize, picture: impl IndexedParallelIterator<Item = Rgb>) {
        let at = self.pictures.partition_point(|(other, _)| *other < number);
        if at < most.min(MAX_LEADING_PASSES) {
            let grey = |value: Rgb| Some((value / 3.0).element_sum()).filter(|grey| grey.is_finite()).unwrap_or(0.0);
            self.pictures.insert(at, (number, picture.with_min_len(MIN_PIXELS_PER_TASK).map(grey).collect()));
            self.pictures.truncate(most);
        }
    }

    /// Adds the passes of `other`, and keeps the `most` passes with the lowest numbers.
    pub fn merge(&mut self, other: &Self, most: usize) {
        self.pictures.extend(other.pictures.iter().cloned());
        self.pictures.sort_by_key(|(number, _)| *number);
        self.pictures.truncate(most);
    }

    /// True if there are at most `most` pictures, each of `pixels` pixels, in ascending order of
    /// pass numbers. False for some pictures that were read from damaged film files.
    pub fn is_consistent(&self, pixels: usize, most: usize) -> bool {
        let ordered = self.pictures.windows(2).all(|pair| pair[0].0 < pair[1].0);
        ordered && self.pictures.len() <= most && self.pictures.iter().all(|(_, picture)| picture.len() == pixels)
    }

    /// Returns the relative variance 2/N of the squared error of a picture. N is the effective
    /// sample count: the squared noise varies like the mean square of N independent Gaussian
    /// values.
    ///
    /// Few passes measure 1/N badly, so the result is a weighted mean of the measured value and of
    /// the value for [`PRIOR_EFFECTIVE_SAMPLE_COUNT`]. The formula holds for Gaussian noise.
    /// `weights` holds a factor for each pixel, which multiplies the pixel's squared deviation from
    /// the mean of the leading passes. This product is clamped to `max`.
    pub fn squared_error_relative_variance(&self, weights: &[f64], max: f64) -> f64 {
        let n = self.pictures.len();
        if n < 2 {
            return 2.0 / PRIOR_EFFECTIVE_SAMPLE_COUNT;
        }
        let (variance, square, count) = self.variance_and_squared_product(weights, max);
        if variance <= 0.0 {
            return 0.0;
        }
        let relative = square / (variance * variance);
        2.0 * ((relative * count + PRIOR_WEIGHT_IN_PRODUCTS / PRIOR_EFFECTIVE_SAMPLE_COUNT)
            / (count + PRIOR_WEIGHT_IN_PRODUCTS))
            .min(1.0)
    }

    /// Returns three values for differences of two leading passes, divided by √2: the mean square
    /// of a difference, the mean squared scalar product of two differences, and the number of
    /// independent products.
    ///
    /// Only products of differences without a common pass count.
    fn variance_and_squared_product(&self, weights: &[f64], max: f64) -> (f64, f64, f64) {
        let n = self.pictures.len();
        let products = self.deviation_products(weights, max);
        let trace: f64 = (0..n).map(|a| products[a][a]).sum();
        let all: f64 = products.iter().flatten().sum();
        let variance = (trace - all / n as f64) / (n - 1) as f64;
        let product = |a: usize, b: usize, c: usize, d: usize| {
            0.5 * (products[a][c] - products[a][d] - products[b][c] + products[b][d])
        };
        let (mut sum, mut count) = (0.0, 0.0);
        for a in 0..n {
            for b in a + 1..n {
                for c in b + 1..n {
                    for d in c + 1..n {
                        for product in [product(a, b, c, d), product(a, c, b, d), product(a, d, b, c)] {
                            sum += product * product;
                            count += 1.0;
                        }
                    }
                }
            }
        }
        // For n passes, the products are linear functions of n(n − 3)/2 independent numbers.
        let independent = (n * n.saturating_sub(3) / 2) as f64;
        (variance, if count > 0.0 { sum / count } else { 0.0 }, independent)
    }

    /// Returns the weighted scalar products of the leading passes' deviations from their mean,
    /// divided by the number of pixels: one product for each pair of passes.
    ///
    /// `weights` holds a factor for each pixel, which multiplies the pixel's squared deviation.
    /// This product is clamped to `max`.
    fn deviation_products(&self, weights: &[f64], max: f64) -> DeviationProducts {
        let share = 1.0 / self.pictures.len() as f64;
        let add_pixel = |products: &mut DeviationProducts, pixel: usize| {
            let mut deviations = [0.0; MAX_LEADING_PASSES];
            let mut mean = 0.0;
            for (value, (_, picture)) in deviations.iter_mut().zip(&self.pictures) {
                *value = f64::from(picture[pixel]);
                mean += share * *value;
            }
            // `weights` are for squares summed over three channels, but the pictures are gray.
            let weight = 3.0 * weights[pixel];
            for deviation in &mut deviations[..self.pictures.len()] {
                *deviation -= mean;
                let weighted = weight * *deviation * *deviation;
                if weighted > max {
                    *deviation *= (max / weighted).sqrt();
                }
            }
            for (row, deviation) in products.iter_mut().zip(deviations) {
                let weighted = weight * deviation;
                row.iter_mut().zip(deviations).for_each(|(product, other)| *product += weighted * other);
            }
        };
        let join = |products: &mut DeviationProducts, others: DeviationProducts| {
            let pairs = products.iter_mut().flatten().zip(others.iter().flatten());
            pairs.for_each(|(product, other)| *product += other);
        };
        let products = sum_over_pixels(weights.len(), add_pixel, join);
        let pixels = weights.len() as f64;
        products.map(|row| row.map(|product| product / pixels))
    }
}

#[cfg(test)]
mod tests;
