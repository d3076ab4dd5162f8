//! Statistics that several pilots (small simulations before a render) compute.

/// Returns the median of the positive `values`; the upper of the two middle ones if their number is
/// even. `None` if no value is positive.
pub(super) fn positive_median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut positive: Vec<f64> = values.filter(|value| *value > 0.0).collect();
    let middle = positive.len() / 2;
    (!positive.is_empty()).then(|| *positive.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Returns the mean of `value` over a box of pixels: those at most `reach` columns and rows from
/// pixel `center`.
///
/// Pixels are indexed by rows from the top, in a picture of (`width`, `height`) pixels.
pub(super) fn box_mean(
    value: impl Fn(usize) -> f64,
    center: usize,
    reach: usize,
    (width, height): (usize, usize),
) -> f64 {
    let (x, y) = (center % width, center / width);
    let columns = x.saturating_sub(reach)..width.min(x + reach + 1);
    let rows = y.saturating_sub(reach)..height.min(y + reach + 1);
    let count = (columns.len() * rows.len()) as f64;
    let mut sum = 0.0;
    for y in rows {
        for pixel in y * width + columns.start..y * width + columns.end {
            sum += value(pixel);
        }
    }
    sum / count
}
