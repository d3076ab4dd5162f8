//! Variance of each pixel between passes, and a bound of its kurtosis.

use super::pixel_sums::MIN_PIXELS_PER_TASK;
use crate::color::Rgb;
use crate::math::BinnedSums;
use crate::render::film::Film;
use glam::DVec3;
use rayon::prelude::*;

/// Kurtosis of Gaussian noise: its fourth central moment divided by the squared variance.
const GAUSSIAN_KURTOSIS: f64 = 3.0;

/// Sums over passes from which the variance of each pixel is computed.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct PixelVarianceSums {
    /// Sums over passes of squared radiance, for each pixel and channel.
    squares: BinnedSums<3>,
    /// Largest absolute radiance of each pixel, over all passes and channels.
    peaks: Vec<f32>,
}

/// Spread of a pixel's values in the passes: their squared deviations from their mean, and a bound
/// of their kurtosis.
pub(super) struct PixelSpread {
    /// Σ (x − mean)² over the values x of the passes, by channel; 0 if it is below rounding errors.
    pub squared_deviations: DVec3,
    /// Upper bound of the kurtosis: the largest squared deviation divided by the variance, at least
    /// [`GAUSSIAN_KURTOSIS`]. For a pixel with one outlier in n passes, the bound is about n.
    pub kurtosis: f64,
}

impl PixelVarianceSums {
    /// Adds the image of a pass.
    pub fn add(&mut self, image: &[Rgb]) {
        if self.squares.has_no_pixels() {
            *self = Self { squares: BinnedSums::new(image.len()), peaks: vec![0.0; image.len()] };
        }
        let square = |value: Rgb| value.as_dvec3() * value.as_dvec3();
        self.squares.add_to_all_pixels(|i| square(image[i]).to_array());
        let peaks = self.peaks.par_iter_mut().zip(image).with_min_len(MIN_PIXELS_PER_TASK);
        peaks.for_each(|(peak, value)| *peak = peak.max(value.abs().max_element()));
    }

    /// Adds the passes of `other`, which must have the same number of pixels.
    pub fn merge(&mut self, other: &Self) {
        self.squares.merge(&other.squares);
        for (peak, other) in self.peaks.iter_mut().zip(&other.peaks) {
            *peak = peak.max(*other);
        }
    }

    /// True if the sums are for `pixels` pixels.
    pub fn is_consistent(&self, pixels: usize) -> bool {
        self.squares.pixel_count() == pixels && self.peaks.len() == pixels
    }

    /// Returns the number of pixels; 0 without passes.
    pub fn pixel_count(&self) -> usize {
        self.peaks.len()
    }

    /// Returns the spread of the passes of pixel `i` about their mean.
    ///
    /// `film` must hold the same passes as these sums.
    pub fn spread(&self, film: &Film, i: usize) -> PixelSpread {
        let n = f64::from(film.passes());
        let sum = DVec3::from_array(film.radiance_sums().pixel_sums(i));
        let squares = DVec3::from_array(self.squares.pixel_sums(i));
        let mean = sum / n;
        // Bound on the rounding errors of the sum of squares, of the mean, and of f64 arithmetic.
        let rounding = 0.5 * n * self.squares.lower_quantum(i)
            + sum.abs() * film.radiance_sums().lower_quantum(i)
            + squares * (4.0 * f64::EPSILON);
        let squared_deviations = squares - sum * mean;
        let squared_deviations = DVec3::select(squared_deviations.cmple(rounding), DVec3::ZERO, squared_deviations);
        let variance = squared_deviations.max_element() / n;
        let largest = f64::from(self.peaks[i]) - mean.abs().max_element();
        let kurtosis = if variance > 0.0 { largest * largest / variance } else { 0.0 };
        PixelSpread { squared_deviations, kurtosis: kurtosis.max(GAUSSIAN_KURTOSIS) }
    }
}
