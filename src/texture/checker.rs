//! Squares.

use crate::color::Rgb;
use glam::DVec2;

/// A step across an edge between squares, in sides.
pub(super) const GRAIN: f64 = 1e-3;

/// Squares of side 1: the first colour where ⌊u⌋ + ⌊v⌋ is even, else the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// The two colours.
    pub colors: [Rgb; 2],
}

impl Checker {
    /// The exact mean over the box of sides `size` around `uv`: the pattern is a product of two square waves.
    #[must_use]
    pub fn at(&self, uv: DVec2, size: DVec2) -> Rgb {
        let product = wave(uv.x, size.x) * wave(uv.y, size.y);
        let [even, odd] = self.colors;
        even.lerp(odd, (0.5 - 0.5 * product) as f32)
    }

    pub(super) fn mean(&self) -> Rgb {
        (self.colors[0] + self.colors[1]) * 0.5
    }
}

/// Mean over `[x − w/2, x + w/2]` of the wave that is 1 where ⌊x⌋ is even, else −1.
fn wave(x: f64, w: f64) -> f64 {
    // Narrower, differences of integrals would be rounding.
    if w < 1e-9 * x.abs().max(1.0) {
        return if x.floor() % 2.0 == 0.0 { 1.0 } else { -1.0 };
    }
    (integral(x + 0.5 * w) - integral(x - 0.5 * w)) / w
}

/// Integral of the wave from 0: a zigzag of period 2.
fn integral(x: f64) -> f64 {
    let phase = x - 2.0 * (0.5 * x).floor();
    phase.min(2.0 - phase)
}
