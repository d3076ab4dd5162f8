//! Sums and means over squares of pixels.

use std::ops::AddAssign;

/// Returns the sum of `value` over the square of pixels around the pixel `center` with the given
/// half width \[pixels], and the number of these pixels.
///
/// `value` and `center` take the index of a pixel in an image of the given width and height
/// \[pixels], by rows from the top. Pixels outside the image are left out, so squares at its edge
/// have fewer pixels.
pub fn square_sum<T: Default + AddAssign>(
    value: impl Fn(usize) -> T,
    center: usize,
    half_width: usize,
    (width, height): (usize, usize),
) -> (T, f64) {
    let (x, y) = (center % width, center / width);
    let columns = x.saturating_sub(half_width)..width.min(x + half_width + 1);
    let rows = y.saturating_sub(half_width)..height.min(y + half_width + 1);
    let count = (columns.len() * rows.len()) as f64;
    let mut sum = T::default();
    for y in rows {
        for pixel in y * width + columns.start..y * width + columns.end {
            sum += value(pixel);
        }
    }
    (sum, count)
}

/// Returns the mean of `value` over the square of pixels around the pixel `center` with the given
/// half width \[pixels]. The arguments are those of [`square_sum`].
#[must_use]
pub fn square_mean(value: impl Fn(usize) -> f64, center: usize, half_width: usize, size: (usize, usize)) -> f64 {
    let (sum, count) = square_sum(value, center, half_width, size);
    sum / count
}

/// Sums of values over all rectangles of pixels between the top left corner of an image and each
/// pixel. They give the sum over any square in constant time.
///
/// Differences of large sums lose digits, so values should have similar sizes.
pub struct SummedAreaTable {
    size: (usize, usize),
    /// Sum over the columns before column x and the rows before row y, at index y·(width + 1) + x.
    sums: Vec<f64>,
}

impl SummedAreaTable {
    /// Makes the table of `values`, one for each pixel of an image of the given width and height
    /// \[pixels], by rows from the top.
    #[must_use]
    pub fn new(values: &[f64], (width, height): (usize, usize)) -> Self {
        let stride = width + 1;
        let mut sums = vec![0.0; stride * (height + 1)];
        for (y, row) in values.chunks(width).enumerate() {
            let mut row_sum = 0.0;
            for (x, value) in row.iter().enumerate() {
                row_sum += value;
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row_sum;
            }
        }
        Self { size: (width, height), sums }
    }

    /// Returns the mean over the square of pixels around the pixel `center` with the given half
    /// width \[pixels]. Pixels outside the image are left out.
    #[must_use]
    pub fn square_mean(&self, center: usize, half_width: usize) -> f64 {
        let (width, height) = self.size;
        let (x, y) = (center % width, center / width);
        let (left, right) = (x.saturating_sub(half_width), width.min(x + half_width + 1));
        let (top, bottom) = (y.saturating_sub(half_width), height.min(y + half_width + 1));
        let sum = |x: usize, y: usize| self.sums[y * (width + 1) + x];
        let total = sum(right, bottom) - sum(left, bottom) - sum(right, top) + sum(left, top);
        total / ((right - left) * (bottom - top)) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::{SummedAreaTable, square_mean, square_sum};

    #[test]
    fn squares_end_at_the_edge_of_the_image() {
        let index_sum = |center, half_width| square_sum(|pixel| pixel, center, half_width, (4, 3));
        assert_eq!(index_sum(5, 0), (5, 1.0));
        assert_eq!(index_sum(5, 1), (1 + 2 + 4 + 5 + 6 + 8 + 9 + 10, 9.0));
        assert_eq!(index_sum(11, 1), (6 + 7 + 10 + 11, 4.0));
        assert_eq!(index_sum(0, 9), ((0..12).sum(), 12.0));
    }
    #[test]
    fn summed_area_tables_give_the_means_of_squares() {
        let values: Vec<f64> = (0..35).map(|i| f64::from(i * i % 11)).collect();
        let table = SummedAreaTable::new(&values, (7, 5));
        for (center, half_width) in (0..35).flat_map(|center| (0..8).map(move |half_width| (center, half_width))) {
            let expected = square_mean(|pixel| values[pixel], center, half_width, (7, 5));
            assert!((table.square_mean(center, half_width) - expected).abs() < 1e-12);
        }
    }
}
