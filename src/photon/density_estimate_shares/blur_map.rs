//! Blur of density estimates, as the pilot of light tracing estimates it.

use super::splat_image::{BLOCK_SIZE, SplatImage};
use crate::math::positive_median;
use rayon::prelude::*;
use std::ops::{AddAssign, Mul};

/// Number of standard errors by which the measured blur of density estimates must exceed its
/// expected value to count as larger.
const LARGER_BLUR: f64 = 3.0;

/// Number of standard errors by which the measured blur of density estimates must fall below its
/// expected value to count as smaller.
///
/// The number is smaller than [`LARGER_BLUR`], because the two mistakes differ. If blur is taken as
/// too small, density estimates blur the caustic a little more. If blur is taken as too large,
/// splats add noise.
const SMALLER_BLUR: f64 = 1.0;

/// Weighted sums over pixels whose ratio is the *squared blur*: the squared relative error that
/// blur causes in density estimates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BlurSums {
    /// Unbiased estimate of the sum over pixels of (blurred light − unblurred light)², each times
    /// its pixel's weight. Noise can make it negative.
    squared_differences: f64,
    /// Variance of `squared_differences` by the noise of the splats.
    variance: f64,
    /// Sum over pixels of the squared mean of the light in a density estimate's disc, each times
    /// its pixel's weight.
    squared_means: f64,
}

impl AddAssign for BlurSums {
    fn add_assign(&mut self, other: Self) {
        self.squared_differences += other.squared_differences;
        self.variance += other.variance;
        self.squared_means += other.squared_means;
    }
}

impl Mul<f64> for BlurSums {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            squared_differences: factor * self.squared_differences,
            variance: factor * factor * self.variance,
            squared_means: factor * self.squared_means,
        }
    }
}

impl BlurSums {
    /// Returns an unbiased estimate of the squared relative error that blur causes in density
    /// estimates, and its standard error. Both are 0 without light.
    pub fn estimate(&self) -> (f64, f64) {
        if self.squared_means > 0.0 {
            (self.squared_differences / self.squared_means, self.variance.sqrt() / self.squared_means)
        } else {
            (0.0, 0.0)
        }
    }

    /// Returns the estimate of squared blur, drawn towards `expected` by as much as noise could
    /// explain the difference (nonnegative garrote, Breiman 1995). Otherwise noise would count as
    /// blur, because squared blur cannot be negative.
    fn estimate_drawn_towards(&self, expected: f64) -> f64 {
        let (squared_blur, error) = self.estimate();
        let difference = squared_blur - expected;
        let noise = if difference > 0.0 { LARGER_BLUR } else { SMALLER_BLUR } * error / difference;
        if noise.abs() < 1.0 { (expected + difference * (1.0 - noise * noise)).max(0.0) } else { expected }
    }
}

/// Squared relative error that blur causes in density estimates, for blocks of pixels and for the
/// whole film.
pub(super) struct BlurMap {
    /// Number of blocks per row.
    columns: u32,
    /// Number of rows of blocks.
    rows: u32,
    /// Sums over the pixels of each block, by rows from the top.
    pub blocks: Vec<BlurSums>,
    /// Squared relative error that blur causes in density estimates, over the whole film.
    pub film: f64,
}

impl BlurMap {
    /// Estimates blur from the splats of a pilot. `disc_half_widths` holds, for each pixel, the
    /// half width \[pixels] of the square that stands for the disc of a density estimate.
    pub fn new(image: &SplatImage, disc_half_widths: &[u8]) -> Self {
        let (columns, rows) = image.block_grid();
        let median = positive_median(image.sums.iter().map(|sums| sums.values)).unwrap_or(0.0);
        let block_sums = |block: u32| {
            let (left, top) = (block % columns * BLOCK_SIZE, block / columns * BLOCK_SIZE);
            let mut sums = BlurSums::default();
            if !image.is_block_near_splats(block) {
                return sums;
            }
            // Inner squares of neighbouring pixels overlap, so some of the pixels stand for all.
            for y in top..image.height.min(top + BLOCK_SIZE) {
                for x in left..image.width.min(left + BLOCK_SIZE) {
                    let pixel = y as usize * image.width as usize + x as usize;
                    let inner_half_width = disc_half_widths[pixel] / 3;
                    let stride = u32::from(inner_half_width) + 1;
                    if x.is_multiple_of(stride) && y.is_multiple_of(stride) {
                        let area = f64::from(stride * stride);
                        sums += pixel_blur(image, pixel, disc_half_widths[pixel], median) * area;
                    }
                }
            }
            sums
        };
        let blocks: Vec<BlurSums> = (0..columns * rows).into_par_iter().map(block_sums).collect();
        let mut film = BlurSums::default();
        blocks.iter().for_each(|block| film += *block);
        Self { columns, rows, blocks, film: film.estimate_drawn_towards(0.0) }
    }

    /// Returns the squared relative error that blur causes in density estimates at the pixel in the
    /// given column and row.
    ///
    /// At the center of a block, the value is the mean over this block and the eight blocks around
    /// it, drawn towards the value of the film. Sums are interpolated between the centers of
    /// blocks, so that the result has no edges.
    pub fn squared_blur(&self, (x, y): (u32, u32)) -> f64 {
        let position = |at: u32| (f64::from(at) + 0.5) / f64::from(BLOCK_SIZE) - 0.5;
        let (column, row) = (position(x), position(y));
        let mut sums = BlurSums::default();
        let weight = |distance: f64| (2.0 - distance.abs()).clamp(0.0, 1.0);
        let range = |at: f64, size: u32| (at - 1.0).floor().max(0.0) as u32..size.min((at + 3.0) as u32);
        for block_row in range(row, self.rows) {
            for block_column in range(column, self.columns) {
                let factor = weight(f64::from(block_row) - row) * weight(f64::from(block_column) - column);
                sums += self.blocks[(block_row * self.columns + block_column) as usize] * factor;
            }
        }
        sums.estimate_drawn_towards(self.film)
    }
}

/// Estimates the squared error that blur causes in a density estimate at `pixel`, and the squared
/// mean of the light in the disc of the estimate. Both are multiplied by the weight 1/(m² +
/// `median`² + q), where m is the mean of the light in the disc, and q the variance of the
/// difference by noise. The weight keeps bright pixels from hiding the blur of all others.
///
/// A square of pixels with half width `half_width` stands for the disc. The mean over a square of
/// about a third of its width stands for the light without blur. The squared difference of both
/// means includes the noise of the splats, whose expected value is subtracted.
fn pixel_blur(image: &SplatImage, pixel: usize, half_width: u8, median: f64) -> BlurSums {
    let (disc, disc_pixels) = image.square_sums(pixel, half_width.into());
    if disc.values <= 0.0 {
        return BlurSums::default();
    }
    let inner_half_width = half_width / 3;
    let (inner, inner_pixels) = image.square_sums(pixel, inner_half_width.into());
    let disc_mean = disc.values / disc_pixels;
    let difference = inner.values / inner_pixels - disc_mean;
    let inner_factor = 1.0 / inner_pixels - 1.0 / disc_pixels;
    let noise =
        inner.squares * inner_factor * inner_factor + (disc.squares - inner.squares) / (disc_pixels * disc_pixels);
    // All splats of the disc give the noise that is expected at its center.
    let expected_noise = disc.squares / disc_pixels * inner_factor;
    let weight = 1.0 / (disc_mean * disc_mean + median * median + expected_noise);

    // Splats fall like a Poisson process, so the squared difference less `noise` has the variance
    // 2q². Inner squares of half width h, h + 1 pixels apart, overlap by h/(2h + 1) of their width,
    // so these values are correlated. Along each axis, the squares of the correlations sum to
    // 1 + 2h²/(2h + 1)².
    let overlap = f64::from(inner_half_width) / (2.0 * f64::from(inner_half_width) + 1.0);
    let correlation_sum = 1.0 + 2.0 * overlap * overlap;
    let weighted_noise = weight * expected_noise * correlation_sum;
    BlurSums {
        squared_differences: weight * (difference * difference - noise),
        variance: 2.0 * weighted_noise * weighted_noise,
        squared_means: weight * disc_mean * disc_mean,
    }
}
