//! Statistics that several pilots (small simulations before the first pass) compute.

use crate::math::square_sum;

/// Returns the median of the positive `values`: the upper of the two middle ones if their number is
/// even. `None` if no value is positive.
pub(super) fn positive_median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut positive: Vec<f64> = values.filter(|value| *value > 0.0).collect();
    let middle = positive.len() / 2;
    (!positive.is_empty()).then(|| *positive.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Returns the mean of `value` over the box of pixels that are at most `half_width` columns and
/// rows away from pixel `center`.
///
/// Pixels are indexed by rows from the top, in a picture of `size` pixels (width, height).
pub(super) fn box_mean(value: impl Fn(usize) -> f64, center: usize, half_width: usize, size: (usize, usize)) -> f64 {
    let (sum, count) = square_sum(value, center, half_width, size);
    sum / count
}
