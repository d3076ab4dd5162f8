//! Bias of a picture whose camera paths are clamped: the light that clamping removes.

use super::pixel_sums::sums_of_values;
use crate::color::Rgb;
use crate::image::RelativeErrorWeights;
use crate::math::BinnedSums;
use glam::DVec3;

/// Sums over passes of the radiance that clamping removed from each pixel.
///
/// The mean removed radiance is the bias of the picture, up to the sign.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct ClampingLossSums {
    /// Sum over passes of the removed radiance, for each pixel and channel.
    removed: BinnedSums<3>,
    /// Sum over passes and channels of the squared removed radiance, for each pixel.
    squares: BinnedSums<1>,
}

impl ClampingLossSums {
    pub fn new(pixels: usize) -> Self {
        Self { removed: BinnedSums::new(pixels), squares: BinnedSums::new(pixels) }
    }

    /// Adds a pass, in which clamping removed the radiance `removed` from each pixel.
    pub fn add(&mut self, removed: &[Rgb]) {
        self.removed.add_to_all_pixels(|i| removed[i].as_dvec3().to_array());
        self.squares.add_to_all_pixels(|i| [removed[i].as_dvec3().length_squared()]);
    }

    /// Adds the passes of `other`, which must have the same number of pixels.
    pub fn merge(&mut self, other: &Self) {
        self.removed.merge(&other.removed);
        self.squares.merge(&other.squares);
    }

    /// Returns the number of pixels; `None` if the two sums have different numbers of pixels, as in
    /// damaged files.
    pub fn pixel_count(&self) -> Option<usize> {
        (self.removed.pixel_count() == self.squares.pixel_count()).then(|| self.removed.pixel_count())
    }

    /// Returns two numbers: the squared relative bias of the picture that clamping causes, and the
    /// variance of this estimate.
    ///
    /// `n` must be the number of added passes.
    ///
    /// The squared bias of a pixel is estimated by products of two different passes, whose noise
    /// has mean zero. The square of each pixel is clamped to \[−1, 1], and the mean to 0 or more.
    pub fn squared_bias(&self, error_weights: &RelativeErrorWeights, n: f64) -> (f64, f64) {
        let weights = error_weights.pixel_weights();
        let [bias, variance] = sums_of_values(weights.len(), |i| {
            let sum = DVec3::from_array(self.removed.pixel_sums(i));
            let [squares] = self.squares.pixel_sums(i);
            let square = error_weights.clamped_relative_squared_error(i, (sum.dot(sum) - squares) / (n * (n - 1.0)));
            let pass_variance = (weights[i] * (squares - sum.dot(sum) / n) / (n - 1.0)).clamp(0.0, n);
            let variance = 2.0 * (pass_variance / n) * (pass_variance / n) + 4.0 * square.max(0.0) * pass_variance / n;
            [square, variance]
        });
        let pixels = weights.len() as f64;
        ((bias / pixels).max(0.0), variance / (pixels * pixels))
    }
}
