//! Weights for relative errors between pictures.

use super::Image;
use crate::math::positive_median;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Half width of the window of 5 × 5 pixels over which [`RelativeErrorWeights`] averages radiance:
/// the number of pixels on each side of the center pixel.
const NEIGHBORHOOD_HALF_WIDTH: usize = 2;

/// Smallest number of pixels that a parallel loop gives to one task.
const MIN_PIXELS_PER_TASK: usize = 2048;

/// Per-pixel weights that turn squared errors into relative squared errors.
///
/// For the error e, the relative squared error is the mean of e² / (L² + m²) over pixels and
/// channels. L is the mean radiance of the pixel's 5 × 5 neighborhood in the reference, over all
/// channels. m is the median of L over pixels with L > 0. So errors in bright regions are relative
/// to the local radiance, and errors in dark regions are relative to m. In a black reference, no
/// pixel has L > 0; m is then 1.
///
/// The relative squared error of each pixel is clamped to \[−1, 1], so that fireflies do not
/// dominate. The value can be negative if e² is estimated by the product of two independent errors.
#[derive(Clone, Debug, PartialEq)]
pub struct RelativeErrorWeights {
    /// Weight 1 / (3 (L² + m²)) of each pixel, in rows from the top. [`RelativeErrorWeights`]
    /// defines L and m.
    weights: Vec<f64>,
}

impl RelativeErrorWeights {
    /// Makes the weights for errors against the reference `picture`.
    ///
    /// Pixels that are not finite are left out of the neighborhood means L.
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
                let rows = y.saturating_sub(NEIGHBORHOOD_HALF_WIDTH)..(y + NEIGHBORHOOD_HALF_WIDTH + 1).min(height);
                let columns = x.saturating_sub(NEIGHBORHOOD_HALF_WIDTH)..(x + NEIGHBORHOOD_HALF_WIDTH + 1).min(width);
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
        let median = positive_median(local.iter().copied()).unwrap_or(1.0);
        let local = local.par_iter().with_min_len(MIN_PIXELS_PER_TASK);
        let weights = local.map(|l| 1.0 / (3.0 * (l * l + median * median))).collect();
        Self { weights }
    }

    /// Returns the weight 1 / (3 (L² + m²)) of each pixel, in rows from the top.
    /// [`RelativeErrorWeights`] defines L and m.
    ///
    /// A weight times the squared error, summed over channels, is the relative squared error of the
    /// pixel before clamping.
    #[must_use]
    pub fn pixel_weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns the relative squared error of pixel number `i`, clamped to \[−1, 1].
    ///
    /// `product` is the squared error of the pixel, summed over channels. Alternatively, it is the
    /// product of the errors against two independent references, summed over channels.
    #[must_use]
    pub fn clamped_relative_squared_error(&self, i: usize, product: f64) -> f64 {
        (self.weights[i] * product).clamp(-1.0, 1.0)
    }

    /// Returns the relative squared error of a picture: the mean over pixels, with each pixel
    /// clamped to \[−1, 1].
    ///
    /// `product(i)` is the squared error of pixel i in each channel. Alternatively, it is the
    /// product of the errors against two independent references: the noise of the references then
    /// cancels in the mean.
    #[must_use]
    pub fn mean_relative_squared_error(&self, product: impl Fn(usize) -> DVec3) -> f64 {
        let sum: f64 =
            (0..self.weights.len()).map(|i| self.clamped_relative_squared_error(i, product(i).element_sum())).sum();
        sum / self.weights.len() as f64
    }
}

#[cfg(test)]
mod tests;
