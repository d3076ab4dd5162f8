//! Errors relative to the light around.

use super::Image;
use glam::{DVec3, Vec3};

/// Half the edge of the square over which light is averaged, in pixels.
const AROUND: usize = 2;

/// What the error of each pixel is held against: the light around it, and that of a typical pixel.
///
/// The squared error of a picture is the mean over pixels of the mean over channels of e², over L² + m². L is the mean over channels of
/// the 5 × 5 pixels around, m the median of L over pixels that are not black. So a lamp counts relative to itself, the dark relative to
/// what is typical, and no grain decides what it is measured by. A picture that is black throughout is measured as it is: L² + m² is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct RelativeScale {
    weights: Vec<f64>,
}

impl RelativeScale {
    /// The scale of what `picture` shows, the truth or what comes near it. Pixels that are not finite are left out of its means.
    #[must_use]
    pub fn of(picture: &Image) -> Self {
        Self::of_pixels((picture.width(), picture.height()), picture.pixels())
    }

    /// The same of the pixels of a picture of width and height `size`, by rows from the top.
    ///
    /// # Panics
    /// Where there are not as many.
    #[must_use]
    pub fn of_pixels(size: (u32, u32), pixels: &[Vec3]) -> Self {
        let (width, height) = (size.0 as usize, size.1 as usize);
        assert_eq!(pixels.len(), width * height);
        let light: Vec<f64> = pixels.iter().map(|p| p.as_dvec3().element_sum().abs() / 3.0).collect();
        let around: Vec<f64> = (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                let rows = y.saturating_sub(AROUND)..(y + AROUND + 1).min(height);
                let columns = x.saturating_sub(AROUND)..(x + AROUND + 1).min(width);
                let (mut sum, mut count) = (0.0, 0u32);
                for row in rows {
                    for value in light[row * width + columns.start..row * width + columns.end].iter() {
                        if value.is_finite() {
                            sum += value;
                            count += 1;
                        }
                    }
                }
                sum / f64::from(count.max(1))
            })
            .collect();
        let mut lit: Vec<f64> = around.iter().copied().filter(|l| *l > 0.0).collect();
        let middle = lit.len() / 2;
        let median = if lit.is_empty() { 1.0 } else { *lit.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let weights = around.iter().map(|l| 1.0 / (3.0 * (l * l + median * median))).collect();
        Self { weights }
    }

    /// What the squared error of a pixel, summed over channels, is multiplied by; by rows from the top.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// What an e², or a product of two errors, of pixel `i` counts, summed over channels: from −1 to 1.
    #[must_use]
    pub fn counts(&self, i: usize, product: f64) -> f64 {
        (self.weights[i] * product).clamp(-1.0, 1.0)
    }

    /// The mean over pixels of what `product` gives for each, an e² or a product of two errors by channel, on this scale.
    #[must_use]
    pub fn mean(&self, product: impl Fn(usize) -> DVec3) -> f64 {
        let sum: f64 = (0..self.weights.len()).map(|i| self.counts(i, product(i).element_sum())).sum();
        sum / self.weights.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, values: &[f32]) -> Image {
        let pixels: Vec<Vec3> = values.iter().map(|v| Vec3::splat(*v)).collect();
        Image::from_pixels(width, values.len() as u32 / width, pixels).unwrap()
    }

    /// Of an even picture of light 2, an error of .1 everywhere is .1/√(4 + 4).
    #[test]
    fn an_even_picture_counts_by_its_light() {
        let scale = RelativeScale::of(&image(8, &[2.0; 64]));
        let square = scale.mean(|_| DVec3::splat(0.01));
        assert!((square - 0.01 / 8.0).abs() < 1e-15, "{square}");
    }

    /// Far from a lamp of 1000, what surrounds is all there is; next to it, the lamp's own light is.
    #[test]
    fn lamps_count_relative_to_themselves_and_the_dark_to_what_is_typical() {
        let mut values = vec![1.0; 16 * 16];
        values[0] = 1000.0;
        values[255] = 0.0;
        let scale = RelativeScale::of(&image(16, &values));
        assert!((scale.weights()[8 * 16 + 8] * 3.0 - 0.5).abs() < 1e-12);
        // Nine pixels are around the corner.
        let corner = 1008.0 / 9.0;
        assert!((scale.weights()[0] * 3.0 * (corner * corner + 1.0) - 1.0).abs() < 1e-12);
        assert!(scale.weights()[255] * 3.0 <= 1.0);
    }

    #[test]
    fn a_speck_is_one_wrong_pixel() {
        let scale = RelativeScale::of(&image(8, &[1.0; 64]));
        let speck = |i| if i == 5 { DVec3::splat(1e9) } else { DVec3::ZERO };
        assert_eq!((scale.mean(speck), scale.mean(|i| -speck(i))), (1.0 / 64.0, -1.0 / 64.0));
    }

    #[test]
    fn what_is_black_is_measured_as_it_is_and_what_is_not_finite_is_left_out() {
        assert_eq!(RelativeScale::of(&image(2, &[0.0; 4])).mean(|_| DVec3::ONE), 1.0);
        let broken = RelativeScale::of(&image(2, &[1.0, f32::NAN, 1.0, f32::INFINITY]));
        assert!(broken.weights().iter().all(|w| (w * 6.0 - 1.0).abs() < 1e-12));
    }
}
