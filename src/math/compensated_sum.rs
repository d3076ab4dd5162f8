//! Compensated summation, which also sums the rounding error of each addition.

use glam::DVec3;

/// Compensated sum of vectors: it also sums the rounding error of each addition.
///
/// Method: Sum2 of Ogita, Rump and Oishi 2005. For n values x in any order, the error in each
/// component is at most 2⁻⁵³·|Σx| + n²·2⁻¹⁰⁶·Σ|x|. A sum that overflows is infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedSum {
    /// Sum of the values, rounded after each addition.
    high: DVec3,
    /// Sum of the rounding errors that occurred when values were added to `high`.
    low: DVec3,
}

impl CompensatedSum {
    /// Adds `value` to the sum, and keeps the rounding error of the addition.
    #[inline]
    pub fn add(&mut self, value: DVec3) {
        let before = self.high;
        self.high = before + value;
        let added = self.high - before;
        self.low += (before - (self.high - added)) + (value - added);
    }

    /// Returns the sum of all added values, rounded to f64.
    #[inline]
    #[must_use]
    pub fn value(&self) -> DVec3 {
        // For an infinite sum, `low` is NaN.
        DVec3::select(self.high.is_finite_mask(), self.high + self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_keep_small_terms_beside_large_ones() {
        let mut sum = CompensatedSum::default();
        for x in [1e16, 1.0, 1.0, -1e16, 0.5] {
            sum.add(DVec3::new(x, -x, 0.0));
        }
        assert_eq!(sum.value(), DVec3::new(2.5, -2.5, 0.0));
    }

    #[test]
    fn non_finite_sums_stay_non_finite() {
        let mut sum = CompensatedSum::default();
        sum.add(DVec3::new(f64::INFINITY, f64::NAN, f64::MAX));
        sum.add(DVec3::new(1.0, 1.0, f64::MAX));
        let value = sum.value();
        assert!(value.x == f64::INFINITY && value.y.is_nan() && value.z == f64::INFINITY, "{value}");
    }
}
