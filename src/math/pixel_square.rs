//! Sums over squares of pixels.

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

#[cfg(test)]
mod tests {
    use super::square_sum;

    #[test]
    fn squares_end_at_the_edge_of_the_image() {
        let index_sum = |center, half_width| square_sum(|pixel| pixel, center, half_width, (4, 3));
        assert_eq!(index_sum(5, 0), (5, 1.0));
        assert_eq!(index_sum(5, 1), (1 + 2 + 4 + 5 + 6 + 8 + 9 + 10, 9.0));
        assert_eq!(index_sum(11, 1), (6 + 7 + 10 + 11, 4.0));
        assert_eq!(index_sum(0, 9), ((0..12).sum(), 12.0));
    }
}
