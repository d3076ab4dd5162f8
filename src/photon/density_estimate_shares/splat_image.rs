//! Splats of the pilot, added up in the pixels of the film.

use super::pixel_at_film_position;
use crate::color;
use crate::math::square_sum;
use crate::photon::deposits::Splat;
use std::ops::AddAssign;

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

/// Width and height \[pixels] of a block of pixels. Blocks at the right and lower edge of the film
/// are cut off.
pub(super) const BLOCK_SIZE: u32 = 8;

/// Sums over splats. The value of a splat is the mean of its color channels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SplatSums {
    /// Sum of the splats' values; the value of a splat is the mean of its color channels.
    pub values: f64,
    /// Sum of the squares of the splats' values; the value of a splat is the mean of its color
    /// channels.
    pub squares: f64,
}

impl AddAssign for SplatSums {
    fn add_assign(&mut self, other: Self) {
        self.values += other.values;
        self.squares += other.squares;
    }
}

impl SplatSums {
    /// Effective number of splats: the number of splats of equal values whose sum has the relative
    /// variance of this sum.
    fn effective_count(&self) -> f64 {
        if self.squares > 0.0 { self.values * self.values / self.squares } else { 0.0 }
    }
}

/// Sums over the splats of each pixel of the film.
pub(super) struct SplatImage {
    pub width: u32,
    pub height: u32,
    /// Sums over the splats in each pixel, by rows from the top.
    pub sums: Vec<SplatSums>,
    /// True for the [blocks](BLOCK_SIZE) within two blocks of a splat, by rows from the top. All
    /// other pixels are farther than [`MAX_COUNT_HALF_WIDTH`] from any splat.
    is_block_near_splats: Vec<bool>,
}

impl SplatImage {
    /// Adds up `splats` in the pixels of a film of the given width and height \[pixels].
    pub fn new(splats: &[Splat], (width, height): (u32, u32)) -> Self {
        let mut sums = vec![SplatSums::default(); width as usize * height as usize];
        let (columns, rows) = (width.div_ceil(BLOCK_SIZE), height.div_ceil(BLOCK_SIZE));
        let mut has_splats = vec![false; columns as usize * rows as usize];
        for splat in splats {
            let Some((x, y)) = pixel_at_film_position(splat.film_position, width, height) else { continue };
            let value = f64::from(color::channel_mean(splat.integrated_radiance));
            sums[y as usize * width as usize + x as usize] += SplatSums { values: value, squares: value * value };
            has_splats[(y / BLOCK_SIZE * columns + x / BLOCK_SIZE) as usize] |= value > 0.0;
        }
        let is_near = |block: u32| {
            let range = |at: u32, size: u32| at.saturating_sub(2)..size.min(at + 3);
            let mut near_rows = range(block / columns, rows);
            near_rows.any(|row| range(block % columns, columns).any(|x| has_splats[(row * columns + x) as usize]))
        };
        let is_block_near_splats = (0..columns * rows).map(is_near).collect();
        Self { width, height, sums, is_block_near_splats }
    }

    /// Returns the numbers of columns and rows of [blocks](BLOCK_SIZE).
    pub fn block_grid(&self) -> (u32, u32) {
        (self.width.div_ceil(BLOCK_SIZE), self.height.div_ceil(BLOCK_SIZE))
    }

    /// True if `block` is within two blocks of a splat. Blocks are indices by rows from the top.
    pub fn is_block_near_splats(&self, block: u32) -> bool {
        self.is_block_near_splats[block as usize]
    }

    /// True if any splat lies on the film.
    pub fn has_splats(&self) -> bool {
        self.is_block_near_splats.contains(&true)
    }

    /// Returns column and row of the pixel with index `pixel`.
    pub fn column_and_row(&self, pixel: usize) -> (u32, u32) {
        (pixel as u32 % self.width, pixel as u32 / self.width)
    }

    /// Returns sums over the square of pixels around `pixel` with the given half width \[pixels],
    /// and the number of its pixels. Pixels outside the film are left out.
    pub fn square_sums(&self, pixel: usize, half_width: u32) -> (SplatSums, f64) {
        let size = (self.width as usize, self.height as usize);
        square_sum(|pixel| self.sums[pixel], pixel, half_width as usize, size)
    }

    /// Estimates the effective number of splats per pixel around `pixel`: the number of splats of
    /// equal values with as much relative noise.
    pub fn splats_per_pixel(&self, pixel: usize) -> f64 {
        let (x, y) = self.column_and_row(pixel);
        if !self.is_block_near_splats(y / BLOCK_SIZE * self.block_grid().0 + x / BLOCK_SIZE) {
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
