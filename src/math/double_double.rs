//! Double-double arithmetic: 106 significant bits, for cofactors and determinants whose terms
//! nearly cancel.

use glam::DVec3;

/// Number with 106 significant bits: the sum of an f64 and its rounding error (Dekker 1971).
#[derive(Clone, Copy)]
struct DoubleDouble(f64, f64);

impl DoubleDouble {
    /// Returns the exact product a · b, as the f64 product and its rounding error (Dekker 1971).
    fn exact_product(a: f64, b: f64) -> Self {
        // Splits `x` into two numbers of 26 bits. Products of such numbers are exact.
        let halves = |x: f64| {
            let c = 134_217_729.0 * x;
            let high = c - (c - x);
            (high, x - high)
        };
        let ((ah, al), (bh, bl)) = (halves(a), halves(b));
        let p = a * b;
        Self(p, al * bl - (((p - ah * bh) - al * bh) - ah * bl))
    }

    fn plus(self, b: Self) -> Self {
        let s = self.0 + b.0;
        let v = s - self.0;
        let lost = (self.0 - (s - v)) + (b.0 - v);
        let low = lost + self.1 + b.1;
        let high = s + low;
        Self(high, low - (high - s))
    }

    fn times_f64(self, b: f64) -> Self {
        let p = Self::exact_product(self.0, b);
        p.plus(Self(self.1 * b, 0.0))
    }

    fn minus(self, b: Self) -> Self {
        self.plus(Self(-b.0, -b.1))
    }
}

/// Vector with double-double components.
#[derive(Clone, Copy)]
pub(super) struct DoubleDoubleVec3([DoubleDouble; 3]);

impl DoubleDoubleVec3 {
    /// Cross product a × b in double-double arithmetic.
    pub fn cross(a: DVec3, b: DVec3) -> Self {
        let minor =
            |x: f64, y: f64, u: f64, v: f64| DoubleDouble::exact_product(x, y).minus(DoubleDouble::exact_product(u, v));
        Self([minor(a.y, b.z, a.z, b.y), minor(a.z, b.x, a.x, b.z), minor(a.x, b.y, a.y, b.x)])
    }

    /// Dot product of this vector with `b` in double-double arithmetic, rounded to f64.
    pub fn dot(self, b: DVec3) -> f64 {
        let [x, y, z] = self.0;
        x.times_f64(b.x).plus(y.times_f64(b.y)).plus(z.times_f64(b.z)).0
    }

    /// Rounds each component to f64.
    pub fn round_to_dvec3(self) -> DVec3 {
        DVec3::from_array(self.0.map(|x| x.0))
    }
}

/// Cross product a × b in double-double arithmetic, rounded to f64.
///
/// Before this rounding, the error of a component is below 10⁻³⁰ times the larger of its two
/// products.
#[must_use]
pub fn exact_cross(a: DVec3, b: DVec3) -> DVec3 {
    DoubleDoubleVec3::cross(a, b).round_to_dvec3()
}

/// Dot product a · b in double-double arithmetic, rounded to f64.
///
/// Before this rounding, the error is below 10⁻³⁰ times the largest of the three products.
#[must_use]
pub fn exact_dot(a: DVec3, b: DVec3) -> f64 {
    let [x, y, z] = [
        DoubleDouble::exact_product(a.x, b.x),
        DoubleDouble::exact_product(a.y, b.y),
        DoubleDouble::exact_product(a.z, b.z),
    ];
    x.plus(y).plus(z).0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancelling_products_keep_their_digits() {
        // (2²⁷ + 1)² − 2²⁷(2²⁷ + 2) = 1. No f64 holds the squares.
        let n = 134_217_728.0;
        let c = exact_cross(DVec3::new(n + 1.0, n, 0.0), DVec3::new(n + 2.0, n + 1.0, 0.0));
        assert_eq!(c, DVec3::Z);
        assert_eq!(exact_dot(DVec3::new(n + 1.0, -n, 0.0), DVec3::new(n + 1.0, n + 2.0, 7.0)), 1.0);
        // Nearly parallel vectors that differ in their last digits only.
        let (a, b) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.1, 0.2, 0.3f64.next_up()));
        let step = 0.3f64.next_up() - 0.3;
        let truth = DVec3::new(0.2 * step, -(0.1 * step), 0.0);
        assert!((exact_cross(a, b) - truth).length() <= f64::EPSILON * truth.length());
        assert_eq!(DoubleDoubleVec3::cross(a, b).dot(DVec3::Z), 0.0);
    }
}
