//! The sum of passes.

use crate::color::Rgb;
use crate::math::Sum;
use glam::DVec3;

/// Sums of passes that carry what they round, so that many passes lose nothing.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    sums: Vec<Sum>,
    passes: u32,
}

impl Film {
    /// An empty film.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, sums: vec![Sum::default(); width as usize * height as usize], passes: 0 }
    }

    /// Adds one pass; `image` holds a radiance for each pixel, by rows from the top.
    pub fn add(&mut self, image: &[Rgb]) {
        for (sum, value) in self.sums.iter_mut().zip(image) {
            sum.add(value.as_dvec3());
        }
        self.passes += 1;
    }

    /// Passes added.
    #[must_use]
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The means of the passes, by rows from the top; black where there is none.
    pub fn means(&self) -> impl Iterator<Item = DVec3> {
        let n = f64::from(self.passes.max(1));
        self.sums.iter().map(move |sum| sum.value() / n)
    }

    /// [`Film::means`] in single precision.
    #[must_use]
    pub fn mean(&self) -> Vec<Rgb> {
        self.means().map(|mean| mean.as_vec3()).collect()
    }
}
