//! Sums of very many values.

use glam::DVec3;

/// A sum by channel that carries what each addition rounded off (Knuth's exact sum of two, in cascade: Ogita, Rump and Oishi 2005, Sum2).
///
/// Of n values it is off by at most 2⁻⁵³ of itself and n²·2⁻¹⁰⁶ of the sum of their magnitudes, in whatever order they come: 10⁹ of them
/// cost nothing that double precision could show. A sum that overflows is infinite, as a plain one is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    high: DVec3,
    /// What `high` lacks.
    low: DVec3,
}

impl Sum {
    /// Adds a value.
    #[inline]
    pub fn add(&mut self, value: DVec3) {
        let before = self.high;
        self.high = before + value;
        let added = self.high - before;
        self.low += (before - (self.high - added)) + (value - added);
    }

    /// The sum.
    #[inline]
    #[must_use]
    pub fn value(&self) -> DVec3 {
        // Infinities lack NaN of themselves.
        DVec3::select(self.high.is_finite_mask(), self.high + self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_large_value_swallows_comes_back() {
        let mut sum = Sum::default();
        for x in [1e16, 1.0, 1.0, -1e16, 0.5] {
            sum.add(DVec3::new(x, -x, 0.0));
        }
        assert_eq!(sum.value(), DVec3::new(2.5, -2.5, 0.0));
    }

    #[test]
    fn what_is_not_finite_stays() {
        let mut sum = Sum::default();
        sum.add(DVec3::new(f64::INFINITY, f64::NAN, f64::MAX));
        sum.add(DVec3::new(1.0, 1.0, f64::MAX));
        let value = sum.value();
        assert!(value.x == f64::INFINITY && value.y.is_nan() && value.z == f64::INFINITY, "{value}");
    }
}
