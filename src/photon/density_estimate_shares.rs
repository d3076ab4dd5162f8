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
//! flux in the ratio n/k + N·n·b². Both terms grow from pass to pass: k shrinks with the gather
//! disc, about as N^-⅓, and b² shrinks more slowly than 1/N.

use super::deposits::Splat;
use super::surface_photon::SHARE_STEPS;
use crate::color;
use crate::math::{SummedAreaTable, square_sum};
use glam::Vec2;
use rayon::prelude::*;
use std::ops::{AddAssign, Mul};

/// Weight of squared blur in the ratio of flux in the first pass. It includes that the mean over
/// passes keeps part of the blur of its first passes. docs/decisions/048-light-tracing.md has the
/// measurements.
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

/// Number of standard errors by which blur must exceed its expected value to count as larger.
const LARGER_BLUR: f64 = 3.0;

/// Number of standard errors by which blur must fall below its expected value to count as smaller.
/// A lower bar than [`LARGER_BLUR`]: where blur is taken as too small, density estimates blur a
/// little more, but splats would show noise.
const SMALLER_BLUR: f64 = 1.0;

/// Fraction of a caustic photon's flux that density estimates use, for each pixel of the film. The
/// rest of the flux goes to a splat, which adds it directly to the film (light tracing).
///
/// The fraction falls from pass to pass, because the noise of splats falls faster with the number
/// of passes than the blur of density estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityEstimateShares {
    width: u32,
    height: u32,
    /// Ratio of flux in the first pass, for each pixel, by rows from the top.
    first_pass_ratios: Vec<FluxRatio>,
}

/// Ratio of the caustic flux that splats carry to the flux that density estimates use. The ratio is
/// the sum of two terms, which grow differently from pass to pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct FluxRatio {
    /// Term for the noise of density estimates: n/k for n photons per pixel and k photons in a
    /// density estimate.
    noise: f32,
    /// Term for the blur of density estimates. It is infinite where splats carry all flux.
    blur: f32,
}

/// Fraction of a caustic photon's flux that density estimates use, for each pixel of the film, in
/// one given pass. [`DensityEstimateShares`] holds the data for all passes.
#[derive(Clone, Copy, Debug)]
pub struct PassDensityEstimateShares<'a> {
    shares: &'a DensityEstimateShares,
    /// Noise term of the ratio of flux in this pass, divided by that in the first pass. In pass i,
    /// counted from 0, this growth is (i + 1)^⅓.
    noise_growth: f32,
    /// Blur term of the ratio of flux in this pass, divided by that in the first pass. In pass i,
    /// counted from 0, this growth is (i + 1)^⅔.
    blur_growth: f32,
}

impl DensityEstimateShares {
    /// Computes, for each pixel, the fraction of caustic flux that density estimates use. In pass
    /// i, counted from 0, this fraction is 1/(1 + (i + 1)^⅓·n/k + (i + 1)^⅔·(10·n·b² + (n/10)²)).
    /// Here n is the estimated number of caustic photons per pixel and pass, and b² the estimated
    /// squared relative error of a density estimate by blur.
    ///
    /// Both are estimated from the `splats` of a small simulation before the render. `ratio` is the
    /// number of photon paths in a pass, divided by their number in that simulation. `gather_count`
    /// is k, the number of photons in a density estimate of the first pass.
    #[must_use]
    pub fn from_splats(splats: &[Splat], (width, height): (u32, u32), ratio: f64, gather_count: f64) -> Self {
        let image = SplatImage::new(splats, (width, height));
        let pixels = 0..image.sums.len();
        if !image.has_splats() {
            return Self { width, height, first_pass_ratios: vec![FluxRatio::default(); pixels.len()] };
        }

        let counts: Vec<f64> =
            pixels.clone().into_par_iter().map(|pixel| ratio * image.splats_per_pixel(pixel)).collect();
        let disc_half_widths: Vec<u8> = counts.par_iter().map(|count| disc_half_width(gather_count / count)).collect();
        let blurs = BlurMap::new(&image, &disc_half_widths);
        let blur_term = |pixel: usize| {
            let n = counts[pixel];
            let relative = n / EQUAL_SHARE_PHOTONS;
            BLUR_WEIGHT * n * blurs.squared_blur(image.column_and_row(pixel)) + relative * relative
        };

        // An edge between different shares would show in the picture, because density estimates
        // blur it and splats do not. So shares change only over distances as large as the disc.
        let smoothed = |term: &(dyn Fn(usize) -> f64 + Sync)| -> Vec<f32> {
            let logarithms: Vec<f64> = pixels.clone().into_par_iter().map(|pixel| libm::log1p(term(pixel))).collect();
            let table = SummedAreaTable::new(&logarithms, (width as usize, height as usize));
            let mean = |pixel: usize| table.square_mean(pixel, disc_half_widths[pixel].into());
            pixels.clone().into_par_iter().map(|pixel| libm::expm1(mean(pixel)) as f32).collect()
        };
        let noise = smoothed(&|pixel| counts[pixel] / gather_count);
        let first_pass_ratios =
            noise.into_iter().zip(smoothed(&blur_term)).map(|(noise, blur)| FluxRatio { noise, blur });
        Self { width, height, first_pass_ratios: first_pass_ratios.collect() }
    }

    /// Returns the split in which splats carry all caustic flux and density estimates none, for all
    /// pixels of a film of the given width and height \[pixels].
    #[must_use]
    pub fn all_to_splats((width, height): (u32, u32)) -> Self {
        let ratio = FluxRatio { noise: 0.0, blur: f32::INFINITY };
        Self { width, height, first_pass_ratios: vec![ratio; width as usize * height as usize] }
    }

    /// Returns the fractions of caustic flux that density estimates use in pass `pass`, counted
    /// from 0.
    #[must_use]
    pub fn in_pass(&self, pass: u32) -> PassDensityEstimateShares<'_> {
        let root = libm::cbrt(f64::from(pass) + 1.0);
        PassDensityEstimateShares { shares: self, noise_growth: root as f32, blur_growth: (root * root) as f32 }
    }
}

impl PassDensityEstimateShares<'_> {
    /// Returns the fraction of caustic flux that density estimates use at `film_position` \[pixels
    /// from the top left], in units of 1/[`SHARE_STEPS`]. Outside the film, the fraction is 1.
    #[inline]
    pub(super) fn share_steps_at_film_position(&self, film_position: Vec2) -> u8 {
        let DensityEstimateShares { width, height, first_pass_ratios } = self.shares;
        pixel_at_film_position(film_position, *width, *height).map_or(SHARE_STEPS, |(x, y)| {
            let FluxRatio { noise, blur } = first_pass_ratios[y as usize * *width as usize + x as usize];
            let ratio = self.noise_growth * noise + self.blur_growth * blur;
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
    /// True for the blocks of [`BLOCK_SIZE`]² pixels within two blocks of a splat, by rows from the
    /// top. All other pixels are farther than [`MAX_COUNT_HALF_WIDTH`] from any splat.
    is_block_near_splats: Vec<bool>,
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
        let (columns, rows) = (width.div_ceil(BLOCK_SIZE), height.div_ceil(BLOCK_SIZE));
        let mut is_block_near_splats = vec![false; columns as usize * rows as usize];
        for (pixel, _) in sums.iter().enumerate().filter(|(_, sums)| sums.values > 0.0) {
            let (column, row) = (pixel as u32 % width / BLOCK_SIZE, pixel as u32 / width / BLOCK_SIZE);
            let range = |at: u32, size: u32| at.saturating_sub(2)..size.min(at + 3);
            for block_row in range(row, rows) {
                range(column, columns).for_each(|x| is_block_near_splats[(block_row * columns + x) as usize] = true);
            }
        }
        Self { width, height, sums, is_block_near_splats }
    }

    /// True if any splat lies on the film.
    fn has_splats(&self) -> bool {
        self.is_block_near_splats.contains(&true)
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
        let (x, y) = self.column_and_row(pixel);
        let block = y / BLOCK_SIZE * self.width.div_ceil(BLOCK_SIZE) + x / BLOCK_SIZE;
        if !self.is_block_near_splats[block as usize] {
            return 0.0;
        }
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
    /// Unbiased estimate of the sum of squared differences that blur makes, each times its pixel's
    /// weight. Noise can make it negative.
    squared_differences: f64,
    /// Variance of `squared_differences` by the noise of the splats.
    variance: f64,
    /// Sum of squared means, each times its pixel's weight.
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
    /// Returns the unbiased estimate of squared blur, and its standard error. Both are 0 without
    /// light.
    fn estimate(&self) -> (f64, f64) {
        if self.squared_means > 0.0 {
            (self.squared_differences / self.squared_means, self.variance.sqrt() / self.squared_means)
        } else {
            (0.0, 0.0)
        }
    }

    /// Returns the estimate of squared blur, drawn towards `expected` by as much as noise could
    /// explain the difference (James and Stein 1961). Without this, noise would count as blur,
    /// because squared blur cannot be negative.
    fn estimate_drawn_towards(&self, expected: f64) -> f64 {
        let (squared_blur, error) = self.estimate();
        let difference = squared_blur - expected;
        let noise = if difference > 0.0 { LARGER_BLUR } else { SMALLER_BLUR } * error / difference;
        if noise.abs() < 1.0 { (expected + difference * (1.0 - noise * noise)).max(0.0) } else { expected }
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
    /// Squared blur of the whole film.
    film: f64,
}

impl BlurMap {
    /// Estimates blur from the splats of a pilot. `disc_half_widths` holds, for each pixel, the
    /// half width \[pixels] of the square that stands for the disc of a density estimate.
    fn new(image: &SplatImage, disc_half_widths: &[u8]) -> Self {
        let (columns, rows) = (image.width.div_ceil(BLOCK_SIZE), image.height.div_ceil(BLOCK_SIZE));
        let mut lit: Vec<f64> = image.sums.iter().map(|sums| sums.values).filter(|value| *value > 0.0).collect();
        let middle = lit.len() / 2;
        let median = if lit.is_empty() { 0.0 } else { *lit.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let block_sums = |block: u32| {
            let (left, top) = (block % columns * BLOCK_SIZE, block / columns * BLOCK_SIZE);
            let mut sums = BlurSums::default();
            if !image.is_block_near_splats[block as usize] {
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

    /// Returns the squared blur at the pixel in the given column and row.
    ///
    /// It is that of the 24 × 24 pixels around the pixel, drawn towards that of the film. Sums are
    /// interpolated between the centers of blocks, so that the result has no edges.
    fn squared_blur(&self, (x, y): (u32, u32)) -> f64 {
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

/// Returns the half width \[pixels] of the square that stands for the disc of a density estimate,
/// which covers the area `area` \[pixels²]. The half width is at least 1 and at most
/// [`MAX_DISC_HALF_WIDTH`].
fn disc_half_width(area: f64) -> u8 {
    ((area.sqrt() - 1.0) / 2.0).round().clamp(1.0, f64::from(MAX_DISC_HALF_WIDTH)) as u8
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
    // 2q². Inner squares of half width h, h + 1 pixels apart, overlap
    // by h/(2h + 1) of their width, so these values are correlated. Along each axis, the squares of
    // the correlations sum to 1 + 2h²/(2h + 1)².
    let overlap = f64::from(inner_half_width) / (2.0 * f64::from(inner_half_width) + 1.0);
    let correlation_sum = 1.0 + 2.0 * overlap * overlap;
    let weighted_noise = weight * expected_noise * correlation_sum;
    BlurSums {
        squared_differences: weight * (difference * difference - noise),
        variance: 2.0 * weighted_noise * weighted_noise,
        squared_means: weight * disc_mean * disc_mean,
    }
}

#[cfg(test)]
mod tests;
