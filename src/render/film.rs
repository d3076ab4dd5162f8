//! Film: accumulates the passes of a render.

use super::merge_error::MergeError;
use crate::color::Rgb;
use crate::math::BinnedSums;
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Smallest number of pixels of one task in parallel loops.
const MIN_PIXELS_PER_TASK: usize = 2048;

/// Accumulation buffer of a render: sums over passes of the radiance of each pixel.
/// [`Film::mean_picture`] returns the picture.
///
/// The sums depend only on the set of passes, bit for bit; see [`BinnedSums`]. Neither the order of
/// passes nor the merging of films changes them. A sum with infinite values is infinite, or NaN if
/// their signs differ.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Film {
    width: u32,
    height: u32,
    sums: BinnedSums<3>,
    passes: u32,
}

impl Film {
    /// Creates an empty film of `width` × `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, sums: BinnedSums::new(width as usize * height as usize), passes: 0 }
    }

    /// Adds the image of one pass: radiance \[W/(m² sr)] of each pixel, in rows from the top.
    pub fn add(&mut self, image: &[Rgb]) {
        self.sums.add_to_all_pixels(|i| image[i].as_dvec3().to_array());
        self.passes += 1;
    }

    /// Adds the passes of `other`. The caller ensures that no pass is in both films.
    ///
    /// # Errors
    /// [`MergeError`] if the sizes differ, or if the number of passes exceeds `u32::MAX`. The film
    /// then stays as it is.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        if self.size() != other.size() {
            return Err(MergeError::SizeMismatch { own: self.size(), other: other.size() });
        }
        self.passes = total_pass_count(self.passes, other.passes)?;
        self.sums.merge(&other.sums);
        Ok(())
    }

    /// Returns the number of added passes.
    #[must_use]
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Returns the width and height \[pixels].
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Returns the mean radiance \[W/(m² sr)] of each pixel over the passes, in rows from the top;
    /// 0 without passes.
    pub fn pixel_means(&self) -> impl Iterator<Item = DVec3> {
        (0..self.sums.pixel_count()).map(|i| self.pixel_mean(i))
    }

    /// Returns the mean radiance \[W/(m² sr)] of pixel `i` over the passes; 0 without passes.
    fn pixel_mean(&self, i: usize) -> DVec3 {
        DVec3::from_array(self.sums.pixel_sums(i)) / f64::from(self.passes.max(1))
    }

    /// Returns the mean radiance \[W/(m² sr)] of each pixel in single precision, in rows from the
    /// top.
    #[must_use]
    pub fn mean_picture(&self) -> Vec<Rgb> {
        let pixels = (0..self.sums.pixel_count()).into_par_iter().with_min_len(MIN_PIXELS_PER_TASK);
        pixels.map(|i| self.pixel_mean(i).as_vec3()).collect()
    }

    /// True if the film has sums for each pixel of its size.
    ///
    /// False for some films that were read from damaged files.
    pub(super) fn is_consistent(&self) -> bool {
        u64::from(self.width) * u64::from(self.height) == self.sums.pixel_count() as u64
    }

    /// Returns the sums over the passes of the radiance of each pixel.
    pub(super) fn radiance_sums(&self) -> &BinnedSums<3> {
        &self.sums
    }
}

/// Adds the numbers of passes of two renders.
///
/// # Errors
/// [`MergeError::TooManyPasses`] if the sum exceeds `u32::MAX`.
pub(super) fn total_pass_count(own: u32, other: u32) -> Result<u32, MergeError> {
    own.checked_add(other).ok_or(MergeError::TooManyPasses { own, other })
}
