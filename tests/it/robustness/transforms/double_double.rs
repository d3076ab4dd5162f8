//! Double-double arithmetic as a reference, with 104 bits (a relative precision of 10⁻³¹; Dekker
//! 1971; Hida, Li and Bailey 2001).

use glam::{DAffine3, DMat3, DVec3};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number as the unevaluated sum of two `f64`: its rounded value and the rounding error.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct DoubleDouble(pub f64, pub f64);

/// A vector of three double-doubles.
#[derive(Clone, Copy, Debug)]
pub struct DoubleDoubleVec(pub [DoubleDouble; 3]);

fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let s = a + b;
    let v = s - a;
    DoubleDouble(s, (a - (s - v)) + (b - v))
}

fn two_product(a: f64, b: f64) -> DoubleDouble {
    // Splits a number into two of 26 bits. Products of such numbers are exact.
    let split = |x: f64| {
        let c = 134_217_729.0 * x;
        let high = c - (c - x);
        (high, x - high)
    };
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    let p = a * b;
    DoubleDouble(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl DoubleDouble {
    pub const ZERO: Self = Self(0.0, 0.0);
    pub const ONE: Self = Self(1.0, 0.0);

    pub fn value(self) -> f64 {
        self.0
    }

    pub fn sqrt(self) -> Self {
        let root = self.0.sqrt();
        if root == 0.0 {
            return Self::ZERO;
        }
        // One Newton step doubles the number of digits.
        let root = Self(root, 0.0);
        (root + self / root) * Self(0.5, 0.0)
    }
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (s, t) = (two_sum(self.0, b.0), two_sum(self.1, b.1));
        let s = two_sum(s.0, s.1 + t.0);
        two_sum(s.0, s.1 + t.1)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let p = two_product(self.0, b.0);
        two_sum(p.0, p.1 + (self.0 * b.1 + self.1 * b.0))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let q = self.0 / b.0;
        let rest = self - b * Self::from(q);
        let more = rest.0 / b.0;
        let rest = rest - b * Self::from(more);
        two_sum(q, more) + Self::from(rest.0 / b.0)
    }
}

impl From<DVec3> for DoubleDoubleVec {
    fn from(v: DVec3) -> Self {
        Self(v.to_array().map(DoubleDouble::from))
    }
}

impl DoubleDoubleVec {
    pub fn dot(self, b: Self) -> DoubleDouble {
        self.0[0] * b.0[0] + self.0[1] * b.0[1] + self.0[2] * b.0[2]
    }

    pub fn cross(self, b: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, b.0);
        Self([y * w - z * v, z * u - x * w, x * v - y * u])
    }

    pub fn scaled(self, s: DoubleDouble) -> Self {
        Self(self.0.map(|x| x * s))
    }

    pub fn value(self) -> DVec3 {
        DVec3::from_array(self.0.map(DoubleDouble::value))
    }
}

impl Add for DoubleDoubleVec {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self([self.0[0] + b.0[0], self.0[1] + b.0[1], self.0[2] + b.0[2]])
    }
}

impl Sub for DoubleDoubleVec {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self([self.0[0] - b.0[0], self.0[1] - b.0[1], self.0[2] - b.0[2]])
    }
}

/// An affine map in double-double precision.
#[derive(Clone, Copy, Debug)]
pub struct Affine {
    pub columns: [DoubleDoubleVec; 3],
    pub shift: DoubleDoubleVec,
}

impl From<DAffine3> for Affine {
    fn from(map: DAffine3) -> Self {
        let DMat3 { x_axis, y_axis, z_axis } = map.matrix3;
        Self { columns: [x_axis, y_axis, z_axis].map(DoubleDoubleVec::from), shift: map.translation.into() }
    }
}

impl Affine {
    pub fn vector(&self, v: DoubleDoubleVec) -> DoubleDoubleVec {
        let [a, b, c] = self.columns;
        a.scaled(v.0[0]) + b.scaled(v.0[1]) + c.scaled(v.0[2])
    }

    pub fn point(&self, p: DoubleDoubleVec) -> DoubleDoubleVec {
        self.vector(p) + self.shift
    }

    /// Returns the map that applies `inner` first, then this map.
    pub fn after(&self, inner: &Self) -> Self {
        Self { columns: inner.columns.map(|c| self.vector(c)), shift: self.point(inner.shift) }
    }

    /// Returns the rows of the inverse of the linear part, computed from cofactors.
    ///
    /// In the worst tested case, 16 of 31 decimal digits cancel.
    pub fn inverse_rows(&self) -> [DoubleDoubleVec; 3] {
        let [a, b, c] = self.columns;
        let volume = a.dot(b.cross(c));
        [b.cross(c), c.cross(a), a.cross(b)].map(|r| r.scaled(DoubleDouble::ONE / volume))
    }

    /// Transforms a vector by the inverse of the linear part.
    pub fn back(&self, v: DoubleDoubleVec) -> DoubleDoubleVec {
        DoubleDoubleVec(self.inverse_rows().map(|r| r.dot(v)))
    }

    /// Transforms a point by the inverse map.
    pub fn point_back(&self, p: DoubleDoubleVec) -> DoubleDoubleVec {
        self.back(p - self.shift)
    }

    /// Transforms a normal by the inverse transpose; the result has any length.
    pub fn normal(&self, n: DoubleDoubleVec) -> DoubleDoubleVec {
        let [x, y, z] = self.inverse_rows();
        x.scaled(n.0[0]) + y.scaled(n.0[1]) + z.scaled(n.0[2])
    }
}
