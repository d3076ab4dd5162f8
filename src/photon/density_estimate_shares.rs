//! Shares of density estimates: the fraction of the flux of caustic photons that density estimates
//! use, for each pixel of the film. Light tracing splats the rest.
//!
//! A density estimate blurs a caustic over its disc. Splats do not blur, but are noisy where few
//! photons fall in a pixel. Each caustic photon therefore divides its flux: a fraction, the
//! *share*, goes to density estimates, and the rest to its splat. The share depends only on film
//! position, so all light is counted exactly once.
//!
//! Let n be the number of photons that fall in a pixel per pass, k the number of photons in a
//! density estimate, and b² its squared relative error by blur. The mean of N passes has the
//! relative variance 1/(N·n) for splats, and the relative squared error 1/(N·k) + b² for density
//! estimates. Their weighted mean has the least squared error if splats and density estimates carry
//! flux in the ratio n·(1/k + N·b²). In this ratio, N·b² grows with the number of passes, because
//! the radii of density estimates shrink slowly.

use super::deposits::Splat;
use super::surface_photon::SHARE_STEPS;
use crate::color;
use crate::math::square_sum;
use glam::Vec2;
use rayon::prelude::*;
use std::ops::{AddAssign, Mul};

/// Number k of photons in a density estimate, from which its noise and its radius follow. It is the
/// default of the setting `gather_k` for caustics.
const DENSITY_ESTIMATE_PHOTONS: f64 = 50.0;

/// Weight of squared blur in the ratio of flux. It includes that the mean over passes keeps part of
/// the blur of its first passes. Measured: docs/decisions/048-light-tracing.md.
const BLUR_WEIGHT: f64 = 10.0;

/// Number of photons per pixel and pass at which splats carry half of the flux even without blur.
///
/// The ratio of flux has the additional term (n/10)², because where many photons fall in a pixel,
/// blur within the pixel may be invisible to the pilot. At a focus smaller than a pixel, few camera
/// rays meet the focus, and each density estimate there has a large error.
const EQUAL_SHARE_PHOTONS: f64 = 10.0;

/// Number of splats that is enough to estimate the number of photons per pixel. The splats of the
/// pilot, a small simulation before the render, are counted in a square around the pixel. The
/// square grows until it holds this number or has its largest size. Splats of unequal values v
/// count as (Σv)²/Σv².
///
/// With fewer splats, shares would vary randomly from pixel to pixel, and this noise would show in
/// the picture.
const ENOUGH_SPLATS: f64 = 16.0;

/// Largest half width \[pixels] of the square around a pixel in which splats are counted to
/// estimate the number of photons per pixel. The largest square has 2·8 + 1 columns and rows.
const MAX_COUNT_HALF_WIDTH: u32 = 8;

/// Largest half width \[pixels] of the square that stands for the disc of a density estimate.
const MAX_DISC_HALF_WIDTH: u32 = 12;

/// Width and height \[pixels] of the blocks in which blur is averaged. The blur of a pixel at the
/// center of a block is the mean over this block and the eight blocks around it.
const BLOCK_SIZE: u32 = 8;

/// Number of pixels as which the blur of the whole film counts in the mean of a block's blur. The
/// blur of few pixels is noisy, because the pilot stores few photons in them.
const FILM_BLUR_WEIGHT: f64 = 200.0;

/// Fraction of a caustic photon's flux that density estimates use, for each pixel of the film. The
/// rest of the flux goes to a splat, which adds it directly to the film (light tracing).
///
/// The fraction falls from pass to pass, because the mean of n passes divides the variance of
/// splats by n, but the bias of density estimates only by about ∛n.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityEstimateShares {
    width: u32,
    height: u32,
    /// Ratio of the caustic flux that splats carry to the flux that density estimates use, for each
    /// pixel in the first pass, by rows from the top. It is infinite where splats carry all flux.
    first_pass_ratios: Vec<f32>,
}

/// Fraction of a caustic photon's flux that density estimates use, for each pixel of the film, in
/// one given pass. [`DensityEstimateShares`] holds the data for all passes.
#[derive(Clone, Copy, Debug)]
pub struct PassDensityEstimateShares<'a> {
    shares: &'a DensityEstimateShares,
    /// Ratio of splat flux to density estimate flux in this pass, divided by the same ratio in the
    /// first pass. In pass i, counted from 0, this growth is (i + 1)^⅔.
    ratio_growth: f32,
}

impl DensityEstimateShares {
    /// Computes, for each pixel, the fraction of caustic flux that density estimates use. In pass
    /// i, counted from 0, this fraction is 1/(1 + g·(i + 1)^⅔), with g = n·(1/50 + 10·b²) +
    /// (n/10)². Here n is the estimated number of caustic photons per pixel and pass, and b² the
    /// estimated squared relative error of a density estimate by blur.
    ///
    /// Both are estimated from the `splats` of a small simulation before the render. `ratio` is the
    /// number of photon paths in a pass, divided by their number in that simulation.
    #[must_use]
    pub fn from_splats(splats: &[Splat], (width, height): (u32, u32), ratio: f64) -> Self {
        let image = SplatImage::new(splats, (width, height));
        let pixels = 0..image.sums.len();
        let counts: Vec<f64> =
            pixels.clone().into_par_iter().map(|pixel| ratio * image.splats_per_pixel(pixel)).collect();
        let blurs = BlurMap::new(&image, &counts);
        // Logarithm of the fraction 1/(1 + g) of density estimates.
        let log_share = |pixel: usize| {
            let n = counts[pixel];
            let squared_blur = blurs.squared_blur(image.column_and_row(pixel));
            let relative = n / EQUAL_SHARE_PHOTONS;
            -libm::log1p(n * (1.0 / DENSITY_ESTIMATE_PHOTONS + BLUR_WEIGHT * squared_blur) + relative * relative)
        };
        let log_shares: Vec<f64> = pixels.clone().into_par_iter().map(log_share).collect();
        // An edge between different shares would show in the picture, because density estimates
        // blur it and splats do not. So shares change only over distances as large as the disc.
        let first_pass_ratio = |pixel: usize| {
            let half_width = disc_half_width(counts[pixel]) as usize;
            let size = (width as usize, height as usize);
            let (sum, count) = square_sum(|pixel| log_shares[pixel], pixel, half_width, size);
            libm::expm1(-sum / count) as f32
        };
        Self { width, height, first_pass_ratios: pixels.into_par_iter().map(first_pass_ratio).collect() }
    }

    /// Returns the split in which splats carry all caustic flux and density estimates none, for all
    /// pixels of a film of the given width and height \[pixels].
    #[must_use]
    pub fn all_to_splats((width, height): (u32, u32)) -> Self {
        Self { width, height, first_pass_ratios: vec![f32::INFINITY; width as usize * height as usize] }
    }

    /// Returns the fractions of caustic flux that density estimates use in pass `pass`, counted
    /// from 0.
    #[must_use]
    pub fn in_pass(&self, pass: u32) -> PassDensityEstimateShares<'_> {
        let root = libm::cbrt(f64::from(pass) + 1.0);
        PassDensityEstimateShares { shares: self, ratio_growth: (root * root) as f32 }
    }
}

impl PassDensityEstimateShares<'_> {
    /// Returns the fraction of caustic flux that density estimates use at `film_position` \[pixels
    /// from the top left], in units of 1/[`SHARE_STEPS`]. Outside the film, the fraction is 1.
    #[inline]
    pub(super) fn share_steps_at_film_position(&self, film_position: Vec2) -> u8 {
        let DensityEstimateShares { width, height, first_pass_ratios } = self.shares;
        pixel_at_film_position(film_position, *width, *height).map_or(SHARE_STEPS, |(x, y)| {
            let ratio = self.ratio_growth * first_pass_ratios[y as usize * *width as usize + x as usize];
            (f32::from(SHARE_STEPS) / (1.0 + ratio)).round() as u8
        })
    }
}

/// Returns column and row of the pixel that contains `film_position` \[pixels from the top left];
/// `None` outside the film.
#[inline]
fn pixel_at_film_position(film_position: Vec2, width: u32, height: u32) -> Option<(u32, u32)> {
    let inside =
        film_position.cmpge(Vec2::ZERO).all() && film_position.x < width as f32 && film_position.y < height as f32;
    inside.then_some((film_position.x as u32, film_position.y as u32))
}

/// Sums over splats. The value of a splat is the mean of its color channels.
#[derive(Clone, Copy, Debug, Default)]
struct SplatSums {
    /// Sum of the values.
    values: f64,
    /// Sum of the squares of the values.
    squares: f64,
}

impl AddAssign for SplatSums {
    fn add_assign(&mut self, other: Self) {
        self.values += other.values;
        self.squares += other.squares;
    }
}

impl SplatSums {
    /// Number of splats of equal values whose sum has the same relative variance.
    fn effective_count(&self) -> f64 {
        if self.squares > 0.0 { self.values * self.values / self.squares } else { 0.0 }
    }
}

/// Sums over the splats of each pixel of the film.
struct SplatImage {
    width: u32,
    height: u32,
    /// Sums of each pixel, by rows from the top.
    sums: Vec<SplatSums>,
}

impl SplatImage {
    fn new(splats: &[Splat], (width, height): (u32, u32)) -> Self {
        let mut sums = vec![SplatSums::default(); width as usize * height as usize];
        for splat in splats {
            if let Some((x, y)) = pixel_at_film_position(splat.film_position, width, height) {
                let value = f64::from(color::channel_mean(splat.integrated_radiance));
                sums[y as usize * width as usize + x as usize] += SplatSums { values: value, squares: value * value };
            }
        }
        Self { width, height, sums }
    }

    /// Returns column and row of the pixel with index `pixel`.
    fn column_and_row(&self, pixel: usize) -> (u32, u32) {
        (pixel as u32 % self.width, pixel as u32 / self.width)
    }

    /// Returns sums over the square of pixels around `pixel` with the given half width \[pixels],
    /// and the number of its pixels. Pixels outside the film are left out.
    fn square_sums(&self, pixel: usize, half_width: u32) -> (SplatSums, f64) {
        let size = (self.width as usize, self.height as usize);
        square_sum(|pixel| self.sums[pixel], pixel, half_width as usize, size)
    }

    /// Estimates the effective number of splats per pixel around `pixel`.
    fn splats_per_pixel(&self, pixel: usize) -> f64 {
        let mut half_width = 1;
        let (mut sums, mut pixels) = self.square_sums(pixel, half_width);
        while sums.effective_count() < ENOUGH_SPLATS && half_width < MAX_COUNT_HALF_WIDTH {
            half_width *= 2;
            (sums, pixels) = self.square_sums(pixel, half_width);
        }
        sums.effective_count() / pixels
    }
}

/// Weighted sums over pixels, from which squared blur follows as a ratio.
#[derive(Clone, Copy, Debug, Default)]
struct BlurSums {
    /// Sum of squared differences that blur makes, each times its pixel's weight.
    squared_differences: f64,
    /// Sum of squared means, each times its pixel's weight.
    squared_means: f64,
}

impl AddAssign for BlurSums {
    fn add_assign(&mut self, other: Self) {
        self.squared_differences += other.squared_differences;
        self.squared_means += other.squared_means;
    }
}

impl Mul<f64> for BlurSums {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        let Self { squared_differences, squared_means } = self;
        Self { squared_differences: factor * squared_differences, squared_means: factor * squared_means }
    }
}

impl BlurSums {
    fn ratio(&self) -> f64 {
        if self.squared_means > 0.0 { (self.squared_differences / self.squared_means).max(0.0) } else { 0.0 }
    }
}

/// Squared relative error of density estimates by blur, for blocks of pixels.
struct BlurMap {
    /// Number of blocks per row.
    columns: u32,
    /// Number of rows of blocks.
    rows: u32,
    /// Sums over the pixels of each block, by rows from the top.
    blocks: Vec<BlurSums>,
    /// Sums over all pixels of the film, multiplied by [`FILM_BLUR_WEIGHT`] and divided by the
    /// number of pixels.
    film: BlurSums,
}

impl BlurMap {
    /// Estimates blur from the splats of a pilot. `counts` holds the number of photons per pixel
    /// and pass, for each pixel.
    fn new(image: &SplatImage, counts: &[f64]) -> Self {
        let (columns, rows) = (image.width.div_ceil(BLOCK_SIZE), image.height.div_ceil(BLOCK_SIZE));
        let lit = image.sums.iter().filter(|sums| sums.values > 0.0).count().max(1);
        let mean = image.sums.iter().map(|sums| sums.values).sum::<f64>() / lit as f64;
        let block_sums = |block: u32| {
            let (left, top) = (block % columns * BLOCK_SIZE, block / columns * BLOCK_SIZE);
            let mut sums = BlurSums::default();
            for y in top..image.height.min(top + BLOCK_SIZE) {
                for x in left..image.width.min(left + BLOCK_SIZE) {
                    let pixel = y as usize * image.width as usize + x as usize;
                    sums += pixel_blur(image, pixel, counts[pixel], mean);
                }
            }
            sums
        };
        let blocks: Vec<BlurSums> = (0..columns * rows).into_par_iter().map(block_sums).collect();
        let mut film = BlurSums::default();
        blocks.iter().for_each(|block| film += *block);
        // The estimate is unbiased, so it is sometimes negative where there is no blur.
        film.squared_differences = film.squared_differences.max(0.0);
        Self { columns, rows, blocks, film: film * (FILM_BLUR_WEIGHT / image.sums.len() as f64) }
    }

    /// Returns the squared blur at the pixel in the given column and row. Sums are interpolated
    /// between the centers of blocks, so that the result has no edges.
    fn squared_blur(&self, (x, y): (u32, u32)) -> f64 {
        let position = |at: u32| (f64::from(at) + 0.5) / f64::from(BLOCK_SIZE) - 0.5;
        let (column, row) = (position(x), position(y));
        let mut sums = self.film;
        let weight = |distance: f64| (2.0 - distance.abs()).clamp(0.0, 1.0);
        let range = |at: f64, size: u32| (at - 1.0).floor().max(0.0) as u32..size.min((at + 3.0) as u32);
        for block_row in range(row, self.rows) {
            for block_column in range(column, self.columns) {
                let factor = weight(f64::from(block_row) - row) * weight(f64::from(block_column) - column);
                sums += self.blocks[(block_row * self.columns + block_column) as usize] * factor;
            }
        }
        sums.ratio()
    }
}

/// Half width \[pixels] of the square that stands for the disc of a density estimate. The square
/// holds [`DENSITY_ESTIMATE_PHOTONS`] photons of a pass with `count` photons per pixel, unless its
/// half width would be below 1 or above [`MAX_DISC_HALF_WIDTH`].
fn disc_half_width(count: f64) -> u32 {
    let half_width = (((DENSITY_ESTIMATE_PHOTONS / count).sqrt() - 1.0) / 2.0).round();
    half_width.clamp(1.0, f64::from(MAX_DISC_HALF_WIDTH)) as u32
}

/// Estimates the squared error that blur causes in a density estimate at `pixel`, and the squared
/// mean of the light in the disc of the estimate. Both are multiplied by the weight 1/(m² +
/// `mean`²), where m is the mean of the light in the disc. The weight keeps bright pixels from
/// hiding the blur of all others.
///
/// A square of pixels stands for the disc. It holds [`DENSITY_ESTIMATE_PHOTONS`] photons of a pass
/// with `count` photons per pixel. The mean over a square of a third of its width stands for the
/// light without blur. The squared difference of both means includes the noise of the splats, whose
/// expected value is subtracted.
fn pixel_blur(image: &SplatImage, pixel: usize, count: f64, mean: f64) -> BlurSums {
    if count <= 0.0 {
        return BlurSums::default();
    }
    let half_width = disc_half_width(count);
    let (disc, disc_pixels) = image.square_sums(pixel, half_width);
    if disc.values <= 0.0 {
        return BlurSums::default();
    }
    let (inner, inner_pixels) = image.square_sums(pixel, half_width / 3);
    let disc_mean = disc.values / disc_pixels;
    let difference = inner.values / inner_pixels - disc_mean;
    let inner_factor = 1.0 / inner_pixels - 1.0 / disc_pixels;
    let noise =
        inner.squares * inner_factor * inner_factor + (disc.squares - inner.squares) / (disc_pixels * disc_pixels);
    let weight = 1.0 / (disc_mean * disc_mean + mean * mean);
    BlurSums {
        squared_differences: weight * (difference * difference - noise),
        squared_means: weight * disc_mean * disc_mean,
    }
}

#[cfg(test)]
mod tests;
