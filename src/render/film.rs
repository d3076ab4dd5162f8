//! Film: accumulates the passes of a render.

use crate::color::Rgb;
use crate::math::CompensatedSum;
use glam::DVec3;

/// Sums of the pass images by pixel.
///
/// Sums are compensated (Kahan), so rounding errors do not grow with the number of passes.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
    sums: Vec<CompensatedSum>,
    passes: u32,
}

impl Film {
    /// Creates an empty film of `width` × `height` pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, sums: vec![CompensatedSum::default(); width as usize * height as usize], passes: 0 }
    }

    /// Adds the image of one pass: radiance \[W/(m² sr)] of each pixel, in rows from the top.
    pub fn add(&mut self, image: &[Rgb]) {
        for (sum, value) in self.sums.iter_mut().zip(image) {
            sum.add(value.as_dvec3());
        }
        self.passes += 1;
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
        let n = f64::from(self.passes.max(1));
        self.sums.iter().map(move |sum| sum.value() / n)
    }

    /// Returns the mean radiance \[W/(m² sr)] of each pixel in single precision, in rows from the
    /// top.
    #[must_use]
    pub fn mean(&self) -> Vec<Rgb> {
        self.pixel_means().map(|mean| mean.as_vec3()).collect()
    }
}
