//! Weights for relative errors between pictures.

use super::Image;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Half width of the 5 × 5 neighbourhood over which [`RelativeErrorWeights`] averages the radiance
/// L \[pixels].
const HALF_WIDTH: usize = 2;

/// Smallest number of pixels of a task of a parallel loop.
const MIN_PIXELS_PER_TASK: usize = 2048;

/// Per-pixel weights that turn squared errors into relative squared errors.
///
/// The relative squared error is the mean of e² / (L² + m²) over pixels and channels, for the error
/// e. L is the mean radiance of the pixel's 5 × 5 neighbourhood in the reference, over channels. m
/// is the median of L over pixels with L > 0. So errors in bright regions are relative to the local
/// radiance, and in dark regions to the median. For a black reference, the divisor is 1.
///
/// The relative squared error of each pixel is clamped to \[−1, 1], so that fireflies do not
/// dominate. It can be negative if it is estimated as a product of two errors.
#[derive(Clone, Debug, PartialEq)]
pub struct RelativeErrorWeights {
    /// 1 / (3 (L² + m²)) of each pixel, in rows from the top.
    weights: Vec<f64>,
}

impl RelativeErrorWeights {
    /// Makes the weights for errors against the reference `picture`.
    ///
    /// Pixels that are not finite do not count in neighbourhoods.
    #[must_use]
    pub fn from_image(picture: &Image) -> Self {
        Self::from_pixels((picture.width(), picture.height()), picture.pixels())
    }

    /// Makes the weights for errors against a reference of `size` (width, height), with `pixels` in
    /// rows from the top.
    ///
    /// # Panics
    /// If the number of pixels is not width · height.
    #[must_use]
    pub fn from_pixels(size: (u32, u32), pixels: &[Vec3]) -> Self {
        let (width, height) = (size.0 as usize, size.1 as usize);
        assert_eq!(pixels.len(), width * height);
        let radiance =
            pixels.par_iter().with_min_len(MIN_PIXELS_PER_TASK).map(|p| p.as_dvec3().element_sum().abs() / 3.0);
        let radiance: Vec<f64> = radiance.collect();
        let local: Vec<f64> = (0..width * height)
            .into_par_iter()
            .with_min_len(MIN_PIXELS_PER_TASK)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                let rows = y.saturating_sub(HALF_WIDTH)..(y + HALF_WIDTH + 1).min(height);
                let columns = x.saturating_sub(HALF_WIDTH)..(x + HALF_WIDTH + 1).min(width);
                let (mut sum, mut count) = (0.0, 0u32);
                for row in rows {
                    for value in radiance[row * width + columns.start..row * width + columns.end].iter() {
                        if value.is_finite() {
                            sum += value;
                            count += 1;
                        }
                    }
                }
                sum / f64::from(count.max(1))
            })
            .collect();
        let mut lit: Vec<f64> = local.iter().copied().filter(|l| *l > 0.0).collect();
        let middle = lit.len() / 2;
        let median = if lit.is_empty() { 1.0 } else { *lit.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let local = local.par_iter().with_min_len(MIN_PIXELS_PER_TASK);
        let weights = local.map(|l| 1.0 / (3.0 * (l * l + median * median))).collect();
        Self { weights }
    }

    /// Returns the weight 1 / (3 (L² + m²)) of each pixel, in rows from the top.
    ///
    /// A weight times the squared error, summed over channels, is the relative squared error of the
    /// pixel before clamping.
    #[must_use]
    pub fn pixel_weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns the relative squared error of pixel `i`, clamped to \[−1, 1].
    ///
    /// `product` is the sum over channels of the squared error, or of the product of two errors.
    #[must_use]
    pub fn clamped_relative_squared_error(&self, i: usize, product: f64) -> f64 {
        (self.weights[i] * product).clamp(-1.0, 1.0)
    }

    /// Returns the mean over pixels of the relative squared error, which is clamped to \[−1, 1] per
    /// pixel.
    ///
    /// `product(i)` gives the squared error of pixel i in each channel. It may also give the
    /// product of the errors against two independent references, whose noise then cancels in the
    /// mean.
    #[must_use]
    pub fn mean_relative_squared_error(&self, product: impl Fn(usize) -> DVec3) -> f64 {
        let sum: f64 =
            (0..self.weights.len()).map(|i| self.clamped_relative_squared_error(i, product(i).element_sum())).sum();
        sum / self.weights.len() as f64
    }
}

#[cfg(test)]
mod tests;
