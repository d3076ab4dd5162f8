//! Accumulates passes.

use crate::color::Rgb;
use crate::math::CompensatedSum;
use glam::DVec3;

/// Sum of passes by pixel, with compensated f64 sums: rounding does not grow with the number of
/// passes.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    sums: Vec<CompensatedSum>,
    passes: u32,
}

impl Film {
    /// An empty film of `width` × `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, sums: vec![CompensatedSum::default(); width as usize * height as usize], passes: 0 }
    }

    /// Adds one pass; `image` holds the radiance of each pixel, by rows from the top \[W/(m² sr)].
    pub fn add(&mut self, image: &[Rgb]) {
        for (sum, value) in self.sums.iter_mut().zip(image) {
            sum.add(value.as_dvec3());
        }
        self.passes += 1;
    }

    /// Number of passes added.
    #[must_use]
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Width and height \[pixels].
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Mean of the passes by pixel, by rows from the top; black without passes.
    pub fn pixel_means(&self) -> impl Iterator<Item = DVec3> {
        let n = f64::from(self.passes.max(1));
        self.sums.iter().map(move |sum| sum.value() / n)
    }

    /// [`Film::means`] in single precision.
    #[must_use]
    pub fn mean(&self) -> Vec<Rgb> {
        self.pixel_means().map(|mean| mean.as_vec3()).collect()
    }
}
