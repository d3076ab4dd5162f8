//! Error of camera paths that all passes share (`ppm`).

use crate::image::RelativeScale;
use crate::integrate::Pass;
use glam::DVec3;

/// Edge of the blocks that count as one independent sample \[pixels]. Neighbouring pixels
/// correlate.
const BLOCK: u32 = 16;

/// Sums, at a few pixels, of shared-path radiance less radiance along fresh paths.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedPathError {
    /// Pixel indices, by rows from the top.
    pixels: Vec<u32>,
    /// Σ difference over passes, by channel.
    sums: Vec<DVec3>,
    /// Σ difference² over passes and channels.
    squares: Vec<f64>,
}

impl SharedPathError {
    pub(super) fn add(&mut self, pass: &Pass) {
        if self.pixels.is_empty() {
            self.pixels = pass.fresh.iter().map(|(i, _)| *i).collect();
            self.sums = vec![DVec3::ZERO; self.pixels.len()];
            self.squares = vec![0.0; self.pixels.len()];
        }
        for ((sum, square), (at, fresh)) in self.sums.iter_mut().zip(&mut self.squares).zip(&pass.fresh) {
            let difference = pass.image[*at as usize].as_dvec3() - fresh.as_dvec3();
            *sum += difference;
            *square += difference.length_squared();
        }
    }

    /// Mean relative squared error and its variance; 0 without shared paths.
    ///
    /// `columns` is the width of the picture in pixels, `n` the number of passes. The variance
    /// comes from the differences between blocks.
    pub(super) fn squared_error(&self, scale: &RelativeScale, columns: u32, n: f64) -> (f64, f64) {
        if self.pixels.is_empty() {
            return (0.0, 0.0);
        }
        let block = |at: u32| (at % columns / BLOCK, at / columns / BLOCK);
        let one = |((at, sum), square): ((&u32, &DVec3), &f64)| {
            (
                block(*at),
                scale.clamped_relative_product(*at as usize, (sum.length_squared() - square) / (n * (n - 1.0))),
            )
        };
        let values: Vec<_> = self.pixels.iter().zip(&self.sums).zip(&self.squares).map(one).collect();
        let mean = values.iter().map(|(_, value)| value).sum::<f64>() / values.len() as f64;
        // Blocks at the border are smaller, so sums of deviations are compared, not means.
        let blocks = values.chunk_by(|a, b| a.0 == b.0);
        let sums: Vec<f64> = blocks.map(|block| block.iter().map(|(_, value)| value - mean).sum()).collect();
        let count = sums.len() as f64;
        let variance = sums.iter().map(|sum| sum * sum).sum::<f64>() / (values.len() as f64 * values.len() as f64);
        let one_block = mean * mean;
        (mean.max(0.0), if sums.len() > 1 { variance * count / (count - 1.0) } else { one_block })
    }
}
