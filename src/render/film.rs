//! The sum of passes.

use crate::color::Rgb;
use glam::DVec3;

/// Sums of passes in double precision, so that many passes lose nothing.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    sum: Vec<DVec3>,
    passes: u32,
}

impl Film {
    /// An empty film.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, sum: vec![DVec3::ZERO; width as usize * height as usize], passes: 0 }
    }

    /// Adds one pass; `image` holds a radiance for each pixel, by rows from the top.
    pub fn add(&mut self, image: &[Rgb]) {
        for (sum, value) in self.sum.iter_mut().zip(image) {
            *sum += value.as_dvec3();
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

    /// The sums, by rows from the top.
    #[must_use]
    pub fn sums(&self) -> &[DVec3] {
        &self.sum
    }

    /// The mean of the passes; black where there is none.
    #[must_use]
    pub fn mean(&self) -> Vec<Rgb> {
        let n = f64::from(self.passes.max(1));
        self.sum.iter().map(|sum| (*sum / n).as_vec3()).collect()
    }
}
