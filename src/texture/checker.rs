//! Checkerboard textures, with exact means over boxes.

use crate::color::Rgb;
use glam::DVec2;

/// Step of the finite differences of bump maps, in sides of a checkerboard square.
pub(super) const BUMP_STEP: f64 = 1e-3;

/// A checkerboard of unit squares in texture coordinates (u, v): the first color where ⌊u⌋ + ⌊v⌋ is
/// even, else the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checkerboard {
    /// Colors of the squares where ⌊u⌋ + ⌊v⌋ is even, and where it is odd.
    pub colors: [Rgb; 2],
}

impl Checkerboard {
    /// Exact mean color over the axis-aligned box with center `uv` and sides `size`, in texture
    /// coordinates.
    ///
    /// The pattern is a product of two square waves, so its mean has a closed form.
    #[must_use]
    pub fn box_mean(&self, uv: DVec2, size: DVec2) -> Rgb {
        let product = square_wave_mean(uv.x, size.x) * square_wave_mean(uv.y, size.y);
        let [even, odd] = self.colors;
        even.lerp(odd, (0.5 - 0.5 * product) as f32)
    }

    /// Mean color of an infinite checkerboard: the mean of both colors.
    pub(super) fn mean(&self) -> Rgb {
        (self.colors[0] + self.colors[1]) * 0.5
    }
}

/// Mean over `[x − w/2, x + w/2]` of the square wave that is 1 where ⌊x⌋ is even, else −1.
fn square_wave_mean(x: f64, w: f64) -> f64 {
    // For a narrower box, the difference of integrals would be rounding error.
    if w < 1e-9 * x.abs().max(1.0) {
        return if x.floor() % 2.0 == 0.0 { 1.0 } else { -1.0 };
    }
    (square_wave_integral(x + 0.5 * w) - square_wave_integral(x - 0.5 * w)) / w
}

/// Integral from 0 to `x` of the square wave that is 1 where ⌊x⌋ is even, else −1.
///
/// The integral is a triangle wave of period 2 with values in \[0, 1].
fn square_wave_integral(x: f64) -> f64 {
    let phase = x - 2.0 * (0.5 * x).floor();
    phase.min(2.0 - phase)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHECKER: Checkerboard = Checkerboard { colors: [Rgb::ZERO, Rgb::ONE] };

    fn checkerboard_mean(u: f64, v: f64, w: f64, h: f64) -> f64 {
        f64::from(CHECKER.box_mean(DVec2::new(u, v), DVec2::new(w, h)).x)
    }

    #[test]
    fn checkerboard_alternates_at_negative_coordinates() {
        for i in -3..4 {
            for j in -3..4 {
                let odd = f64::from((i + j) & 1);
                assert_eq!(checkerboard_mean(f64::from(i) + 0.25, f64::from(j) + 0.75, 0.0, 0.0), odd, "{i} {j}");
            }
        }
    }

    /// Compares box means with the fraction of odd squares in the box, summed square by square.
    #[test]
    fn box_means_match_summed_squares() {
        for (u, v, w, h) in [(0.3, 0.4, 0.2, 0.2), (1.0, 0.5, 0.5, 0.1), (-3.3, 7.1, 2.7, 5.3), (1e4, 0.1, 3.1, 0.9)] {
            let overlap = |x: f64, w: f64, cell: f64| (x + 0.5 * w).min(cell + 1.0) - (x - 0.5 * w).max(cell);
            let cells = |x: f64, w: f64| {
                let first = (x - 0.5 * w).floor() as i64;
                (first..first + w.ceil() as i64 + 2).map(move |c| (c, overlap(x, w, c as f64).max(0.0)))
            };
            let odd: f64 = cells(u, w)
                .flat_map(|(i, a)| cells(v, h).map(move |(j, b)| if (i + j) & 1 == 1 { a * b } else { 0.0 }))
                .sum();
            // The color is rounded to f32.
            assert!((checkerboard_mean(u, v, w, h) - odd / (w * h)).abs() < 1e-6, "{u} {v} {w} {h}");
        }
        for x in [0.0, 0.3, 17.9] {
            assert!((checkerboard_mean(x, 0.2, 4.0, 0.1) - 0.5).abs() < 1e-7, "whole periods hold half of each");
        }
    }
}
