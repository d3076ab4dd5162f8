//! Error of a picture due to camera paths that all passes share, as in the algorithm `ppm`.

use crate::image::RelativeErrorWeights;
use crate::integrate::PassResult;
use crate::math::BinnedSums;
use glam::DVec3;

/// Edge length of square blocks of pixels \[pixels]. Errors of neighboring pixels correlate, so
/// each block counts as one independent sample.
const BLOCK_SIDE: u32 = 16;

/// Sums over passes, for a few pixels, from which the error of shared camera paths is estimated.
///
/// Shared paths are the same in all passes; unshared paths differ from pass to pass. The error is
/// the mean difference between radiance by shared paths and radiance by unshared paths.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct SharedPathErrorSums {
    /// Indices of the pixels that each pass renders a second time, with unshared camera paths.
    /// Pixels are counted in rows from the top.
    pixel_indices: Vec<u32>,
    /// Sum over passes of radiance by shared paths minus radiance by unshared paths, for each pixel
    /// and channel.
    difference_sums: BinnedSums<3>,
    /// Sum over passes and channels of the squared difference between radiance by shared and by
    /// unshared paths, for each pixel.
    squares: BinnedSums<1>,
}

impl SharedPathErrorSums {
    pub(super) fn add(&mut self, pass: &PassResult) {
        if self.pixel_indices.is_empty() {
            self.pixel_indices = pass.unshared_path_pixels.iter().map(|(i, _)| *i).collect();
            self.difference_sums = BinnedSums::new(self.pixel_indices.len());
            self.squares = BinnedSums::new(self.pixel_indices.len());
        }
        let difference = |i: usize| {
            let (at, unshared) = pass.unshared_path_pixels[i];
            pass.image[at as usize].as_dvec3() - unshared.as_dvec3()
        };
        self.difference_sums.add_to_all_pixels(|i| difference(i).to_array());
        self.squares.add_to_all_pixels(|i| [difference(i).length_squared()]);
    }

    /// Adds the passes of `other`, which must be of the same pixels.
    pub(super) fn merge(&mut self, other: &Self) {
        self.difference_sums.merge(&other.difference_sums);
        self.squares.merge(&other.squares);
    }

    /// True if there is a sum for each index in `pixel_indices`, and each index is below the number
    /// `pixels` of pixels of the picture.
    pub(super) fn is_consistent(&self, pixels: usize) -> bool {
        let count = self.pixel_indices.len();
        let are_pixels = self.pixel_indices.iter().all(|pixel| (*pixel as usize) < pixels);
        are_pixels && self.difference_sums.pixel_count() == count && self.squares.pixel_count() == count
    }

    /// Returns the indices of the pixels that each pass also renders with unshared camera paths, by
    /// rows from the top.
    pub(super) fn pixel_indices(&self) -> &[u32] {
        &self.pixel_indices
    }

    /// Returns two numbers: the squared relative error of shared camera paths, and the variance of
    /// this estimate. Both are 0 without shared paths.
    ///
    /// The error is a mean over the pixels that are also rendered with unshared paths. The square
    /// of each pixel is clamped to \[−1, 1], and the mean to 0 or more. `columns` is the width of
    /// the picture \[pixels], and `n` the number of passes. The variance is measured between blocks
    /// of [`BLOCK_SIDE`] × [`BLOCK_SIDE`] pixels.
    pub(super) fn shared_path_squared_error(
        &self,
        error_weights: &RelativeErrorWeights,
        columns: u32,
        n: f64,
    ) -> (f64, f64) {
        if self.pixel_indices.is_empty() {
            return (0.0, 0.0);
        }
        let one = |(i, at): (usize, &u32)| {
            let (sum, [square]) = (DVec3::from_array(self.difference_sums.pixel_sums(i)), self.squares.pixel_sums(i));
            let product = (sum.length_squared() - square) / (n * (n - 1.0));
            error_weights.clamped_relative_squared_error(*at as usize, product)
        };
        let values: Vec<f64> = self.pixel_indices.iter().enumerate().map(one).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        // Blocks at the border have fewer pixels, so the variance is measured between sums instead
        // of means.
        let mut sums = Vec::new();
        let mut first_pixel = None;
        for (at, value) in self.pixel_indices.iter().zip(&values) {
            let (x, y) = (at % columns, at / columns);
            let in_block = |(left, top): (u32, u32)| {
                (left..left + BLOCK_SIDE).contains(&x) && (top..top + BLOCK_SIDE).contains(&y)
            };
            if !first_pixel.is_some_and(in_block) {
                // Blocks have gaps of at least a block between them. So this pixel is the first one
                // of the next block, even if a crop window cuts the block.
                first_pixel = Some((x, y));
                sums.push(0.0);
            }
            if let Some(sum) = sums.last_mut() {
                *sum += value - mean;
            }
        }
        let count = sums.len() as f64;
        let variance = sums.iter().map(|sum| sum * sum).sum::<f64>() / (values.len() as f64 * values.len() as f64);
        let one_block = mean * mean;
        (mean.max(0.0), if sums.len() > 1 { variance * count / (count - 1.0) } else { one_block })
    }
}
