//! Variances of the light that one ray finds, from the pictures of the prefix-ray pilot (small
//! simulation before the first pass).

use super::WHOLE_PICTURES;
use super::blocks::PilotBlocks;
use crate::integrate::lamp_image_pilot::LampImageContribution;
use crate::math::{positive_median, square_mean};
use rayon::prelude::*;

/// Running mean of a series of values, and their variance within groups (Welford 1962). All values
/// of a group have the same expected value.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RunningVariance {
    count: u32,
    /// Mean of all values.
    pub mean: f32,
    group_count: u32,
    group_mean: f32,
    /// Sum of the squared deviations of all values from the means of their groups.
    squared_deviation_sum: f64,
    /// Number of values that were not the first of their group.
    degrees_of_freedom: u32,
}

impl RunningVariance {
    /// Adds a value to the current group.
    pub fn add(&mut self, value: f32) {
        self.count += 1;
        self.mean += (value - self.mean) / self.count as f32;
        self.degrees_of_freedom += u32::from(self.group_count > 0);
        self.group_count += 1;
        let before = value - self.group_mean;
        self.group_mean += before / self.group_count as f32;
        // Use f64: the square of a small f32 could underflow.
        self.squared_deviation_sum += f64::from(before) * f64::from(value - self.group_mean);
    }

    /// Begins a new group.
    pub fn start_group(&mut self) {
        (self.group_count, self.group_mean) = (0, 0.0);
    }

    /// Returns the unbiased variance within groups; some group must have at least two values.
    pub fn variance(&self) -> f64 {
        self.squared_deviation_sum / f64::from(self.degrees_of_freedom)
    }
}

/// Means and variances of the light of one [block](PilotBlocks) of pixels over the pictures of the
/// prefix-ray pilot (small simulation before the first pass). The light is averaged over RGB
/// \[W/(m² sr)].
///
/// *Receiver*: a surface or medium that stores photons.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BlockLightStatistics {
    /// Light that camera paths find at and after their first receiver (surface or medium that
    /// stores photons), without photon estimates.
    pub from_receiver: RunningVariance,
    /// Light that camera paths find before their first receiver (surface or medium that stores
    /// photons): emission, and direct light at casters such as rough glass.
    pub up_to_receiver: RunningVariance,
    /// Photon estimate at the first receiver (surface or medium that stores photons).
    pub photon_estimate: RunningVariance,
    /// Sum, over the camera paths that do not end at the first receiver, of (`from_receiver` − its
    /// mean)·(`up_to_receiver` − its mean). The covariance of `from_receiver` and `up_to_receiver`
    /// is this sum divided by (number of paths − 1).
    pub deviation_product_sum: f64,
}

/// Variances of the light that one ray of a pixel finds, divided by L̃·(L + L̃). L is the light of
/// the pixel, and L̃ the median of L over the picture.
///
/// *Receiver*: a surface or medium that stores photons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RelativePixelVariances {
    /// Relative variance of the light that a camera path finds at and after its first receiver
    /// (surface or medium that stores photons), without photon estimates.
    pub from_receiver: f64,
    /// Relative variance of the light that a path finds before its first receiver (surface or
    /// medium that stores photons): emission, and direct light at casters such as rough glass.
    ///
    /// If the covariance of this light and the light of `from_receiver` is negative, twice the
    /// covariance is added. The covariance is negative at edges, where a ray finds either one light
    /// or the other.
    pub up_to_receiver: f64,
    /// Relative variance of the photon estimate at the first receiver (surface or medium that
    /// stores photons).
    pub photon_estimate: f64,
    /// Relative variance of the light that one ray finds if the ray is aimed at the pixel's lamp
    /// images, the film regions where camera rays meet a small lamp. The value is approximated by
    /// the square of the light of these lamp images.
    pub lamp_images_aimed: f64,
    /// Relative variance of the light that one ordinary camera ray finds in the pixel's lamp
    /// images, the film regions where camera rays meet a small lamp.
    pub lamp_images_unaimed: f64,
}

/// Returns the relative variances of one ray of each pixel; `None` if the picture is black.
///
/// `light` holds the statistics of each of the `blocks`. All pixels of a block share them. They
/// contain little light of the lamp images `images` (film regions where camera rays meet a small
/// lamp), so the function adds that light.
///
/// Variances are divided by L̃·(L + L̃), where L is the light of the pixel and L̃ the median of L
/// over the picture. This measure lies between the absolute error, which neglects dark pixels, and
/// the relative error, which neglects bright ones.
pub(super) fn pixel_variances(
    light: &[BlockLightStatistics],
    images: &[LampImageContribution],
    blocks: &PilotBlocks,
) -> Option<Vec<RelativePixelVariances>> {
    let values = |value: fn(&BlockLightStatistics) -> f64| light.par_iter().map(value).collect::<Vec<f64>>();
    let mut mean = values(|l| f64::from(l.from_receiver.mean + l.up_to_receiver.mean + l.photon_estimate.mean));
    let pixels = blocks.film_size.0 * blocks.film_size.1;
    for image in images {
        let block = blocks.block_of_pixel(image.pixel as usize);
        mean[block] += image.pixel_radiance / blocks.pixel_count(block) as f64;
    }
    let median = positive_median(mean.iter().copied())?;
    let from_receiver = values(|l| l.from_receiver.variance());
    let up_to_receiver = values(|l| l.up_to_receiver.variance());
    let (products, photons) = (values(|l| l.deviation_product_sum), values(|l| l.photon_estimate.variance()));
    // Few pictures say little about one pixel. Means over neighbours reduce the noise: a small box
    // keeps detail, a larger one includes rare bright rays.
    let box_mean =
        |values: &[f64], i: usize, half_width: usize| square_mean(|i| values[i], i, half_width, blocks.size());
    let smoothed = |values: &[f64], i: usize| 0.5 * (box_mean(values, i, 1) + box_mean(values, i, 4));
    let scale = |i: usize| 1.0 / (median * (box_mean(&mean, i, 1) + median));
    let variance = |i: usize| {
        let scale = scale(i);
        let up_to_receiver = smoothed(&up_to_receiver, i);
        let covariance = smoothed(&products, i) / f64::from(WHOLE_PICTURES - 1);
        let photons = smoothed(&photons, i);
        RelativePixelVariances {
            from_receiver: box_mean(&from_receiver, i, 1) * scale,
            up_to_receiver: (up_to_receiver + 2.0 * covariance.min(0.0)).max(0.0) * scale,
            photon_estimate: photons * scale,
            ..RelativePixelVariances::default()
        }
    };
    let of_blocks: Vec<RelativePixelVariances> = (0..light.len()).into_par_iter().map(variance).collect();
    let of_pixel = |pixel: usize| of_blocks[blocks.block_of_pixel(pixel)];
    let mut variances: Vec<RelativePixelVariances> = (0..pixels).into_par_iter().map(of_pixel).collect();
    for in_pixel in images.chunk_by(|a, b| a.pixel == b.pixel) {
        let pixel = in_pixel[0].pixel as usize;
        let sum = |value: fn(&LampImageContribution) -> f64| in_pixel.iter().map(value).sum::<f64>();
        let light = sum(|image| image.pixel_radiance);
        let scale = scale(blocks.block_of_pixel(pixel));
        variances[pixel].lamp_images_aimed = light * light * scale;
        variances[pixel].lamp_images_unaimed = sum(|image| image.mean_square) * scale;
    }
    Some(variances)
}
