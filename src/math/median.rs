//! Median of the positive values of a list.

/// Returns the median of the positive `values`: the upper of the two middle ones if their number is
/// even. `None` if no value is positive.
#[must_use]
pub fn positive_median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut positive: Vec<f64> = values.filter(|value| *value > 0.0).collect();
    let middle = positive.len() / 2;
    (!positive.is_empty()).then(|| *positive.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::positive_median;

    #[test]
    fn median_leaves_out_values_that_are_not_positive() {
        assert_eq!(positive_median([4.0, -1.0, 1.0, 0.0, 3.0, f64::NAN, 2.0].into_iter()), Some(3.0));
        assert_eq!(positive_median([5.0].into_iter()), Some(5.0));
        assert_eq!(positive_median([0.0, -2.0].into_iter()), None);
    }
}
