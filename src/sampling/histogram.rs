//! Piecewise constant distribution on the unit square, for square grids of a power of two.

use glam::Vec2;

/// Distribution on \[0, 1)² with a constant density in each of `side` × `side` cells.
///
/// Samples come by inversion, first of the row and then of the column. Inversion is monotonic along
/// each axis, so stratified points stay stratified. Probabilities are multiples of 2⁻²⁴, the
/// resolution of the uniform numbers: even the smallest cell is sampled exactly as often as its
/// density says.
#[derive(Clone, Debug)]
pub struct Histogram {
    side: usize,
    /// `side + 1` ascending bounds of the rows, from 0 to 1.
    rows: Vec<f32>,
    /// `side + 1` ascending bounds of the columns for each row.
    columns: Vec<f32>,
}

/// Number of steps of 2⁻²⁴ in \[0, 1).
const STEPS: f64 = 16_777_216.0;

/// Steps that each cell with a weight above zero gets at least, so that points within it still
/// spread.
const LEAST: f64 = 64.0;

impl Histogram {
    /// Distribution in proportion to `side`² `weights`, row by row.
    ///
    /// `None` if `side` is not a power of two up to 1024, if the number of weights differs, if one
    /// is negative or not finite, or if all are zero.
    #[must_use]
    pub fn new(side: usize, weights: &[f64]) -> Option<Self> {
        let valid = weights.iter().all(|w| *w >= 0.0 && w.is_finite());
        if !valid
            || weights.iter().all(|w| *w == 0.0)
            || !side.is_power_of_two()
            || side > 1024
            || weights.len() != side * side
        {
            return None;
        }
        let sums: Vec<f64> = weights.chunks_exact(side).map(|row| row.iter().sum()).collect();
        let rows = bounds(&sums);
        let columns = weights.chunks_exact(side).flat_map(bounds).collect();
        Some(Self { side, rows, columns })
    }

    /// Point for uniform `u` in \[0, 1)², and the density there.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (row, y, height) = find(&self.rows, u.y);
        let (column, x, width) = find(self.columns_of(row), u.x);
        // Rounding must not carry a point into the next cell, which has another density.
        let within = |cell: usize, x: f32| (cell as f32 + x).min((cell as f32 + 1.0).next_down());
        (Vec2::new(within(column, x), within(row, y)) / self.side as f32, self.to_density(width, height))
    }

    /// Density at `u` in \[0, 1)².
    #[inline]
    #[must_use]
    pub fn density(&self, u: Vec2) -> f32 {
        let cell = |x: f32| ((x * self.side as f32) as usize).min(self.side - 1);
        let (column, row) = (cell(u.x), cell(u.y));
        let columns = self.columns_of(row);
        self.to_density(columns[column + 1] - columns[column], self.rows[row + 1] - self.rows[row])
    }

    /// Index of the cell at `u`, row by row, in a grid of `side`² cells.
    #[inline]
    #[must_use]
    pub fn cell(side: usize, u: Vec2) -> usize {
        let cell = |x: f32| ((x * side as f32) as usize).min(side - 1);
        cell(u.y) * side + cell(u.x)
    }

    fn columns_of(&self, row: usize) -> &[f32] {
        let stride = self.side + 1;
        &self.columns[row * stride..(row + 1) * stride]
    }

    fn to_density(&self, width: f32, height: f32) -> f32 {
        let side = self.side as f32;
        (width * side) * (height * side)
    }
}

/// Bounds of intervals in proportion to `weights`, in whole steps; equal intervals if all weights
/// are zero.
fn bounds(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let weight = |w: &f64| if total > 0.0 { *w / total } else { 1.0 / weights.len() as f64 };
    let kept = weights.iter().filter(|w| weight(w) > 0.0).count() as f64 * LEAST;
    let (mut sum, mut least) = (0.0, 0.0);
    let inner = weights.iter().map(|w| {
        sum += weight(w);
        least += if weight(w) > 0.0 { LEAST } else { 0.0 };
        (((sum.min(1.0) * (STEPS - kept)).round() + least) / STEPS) as f32
    });
    std::iter::once(0.0).chain(inner).collect()
}

/// Interval that contains `u`, the position in it in \[0, 1), and its length, which is never zero.
#[inline]
fn find(bounds: &[f32], u: f32) -> (usize, f32, f32) {
    let i = bounds.partition_point(|b| *b <= u).clamp(1, bounds.len() - 1) - 1;
    let length = bounds[i + 1] - bounds[i];
    (i, (u - bounds[i]) / length, length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Dimension, Key, Purpose, sobol_2d};

    const SIDE: usize = 16;

    /// Weights from 0 to 10⁴, with one row and one column of zeros.
    fn weights() -> Vec<f64> {
        let key = Key::new(3).purpose(Purpose::Test);
        let weight = |i: usize| {
            let (row, column) = (i / SIDE, i % SIDE);
            let u = f64::from(key.with(i as u64).uniform(Dimension::Light));
            if row == 3 || column == 15 || u < 0.2 { 0.0 } else { u * u * u * if u > 0.95 { 1e4 } else { 1.0 } }
        };
        (0..SIDE * SIDE).map(weight).collect()
    }

    fn points(n: u64) -> impl Iterator<Item = Vec2> {
        let key = Key::new(9).purpose(Purpose::Test);
        (0..n).map(move |i| key.with(i).uniform_2d(Dimension::LightPosition))
    }

    /// Chi-square test of a million samples over cells split in four; false-alarm rate 10⁻⁴.
    #[test]
    fn samples_follow_the_density() {
        let histogram = Histogram::new(SIDE, &weights()).unwrap();
        let n = 1_000_000;
        let fine = 2 * SIDE;
        let mut counts = vec![0.0; fine * fine];
        for u in points(n) {
            let (at, density) = histogram.sample(u);
            assert!(at.cmpge(Vec2::ZERO).all() && at.cmplt(Vec2::ONE).all());
            assert_eq!(density, histogram.density(at));
            counts[Histogram::cell(fine, at)] += 1.0;
        }
        // Cells that expect fewer than ten points are pooled.
        let (mut chi2, mut nu, mut rest) = (0.0, -1.0, (0.0, 0.0));
        for (i, count) in counts.iter().enumerate() {
            let middle = (Vec2::new((i % fine) as f32, (i / fine) as f32) + 0.5) / fine as f32;
            let expected = f64::from(histogram.density(middle)) * n as f64 / (fine * fine) as f64;
            assert!(expected > 0.0 || *count == 0.0);
            if expected < 10.0 {
                rest = (rest.0 + expected, rest.1 + count);
            } else {
                chi2 += (count - expected) * (count - expected) / expected;
                nu += 1.0;
            }
        }
        if rest.0 > 0.0 {
            chi2 += (rest.1 - rest.0) * (rest.1 - rest.0) / rest.0;
            nu += 1.0;
        }
        // Wilson–Hilferty: the cube root of χ²/ν is normal with mean 1 − 2/(9ν) and variance
        // 2/(9ν).
        let z = (libm::cbrt(chi2 / nu) - (1.0 - 2.0 / (9.0 * nu))) / (2.0 / (9.0 * nu)).sqrt();
        assert!(z.abs() < 3.9, "z = {z}, {nu} degrees of freedom");
    }

    /// The tolerance is the 64 steps that each cell gets in its row, and each row in its column.
    #[test]
    fn density_is_proportional_to_weights() {
        let weights = weights();
        let histogram = Histogram::new(SIDE, &weights).unwrap();
        let total: f64 = weights.iter().sum();
        let mut integral = 0.0;
        for (i, w) in weights.iter().enumerate() {
            let middle = (Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
            let p = f64::from(histogram.density(middle)) / (SIDE * SIDE) as f64;
            assert_eq!(p > 0.0, *w > 0.0);
            let kept = 64.0 * (SIDE + 1) as f64 / STEPS;
            assert!((p - w / total).abs() <= 2.0 * kept, "{p} {}", w / total);
            integral += p;
        }
        assert!((integral - 1.0).abs() < 1e-5, "{integral}");
        let rare = Histogram::new(2, &[1.0, 1e-30, 1.0, 1.0]).unwrap();
        assert!(rare.density(Vec2::new(0.75, 0.25)) > 0.0, "a weight above zero must keep some density");
    }

    /// Each row gets its share of 256 stratified points, up to one point per bound.
    #[test]
    fn stratified_points_stay_stratified() {
        let mut weights = vec![1.0; 16];
        weights[5] = 9.0;
        let histogram = Histogram::new(4, &weights).unwrap();
        let key = Key::new(2).purpose(Purpose::Test);
        let mut rows = [0.0; 4];
        for i in 0..256 {
            let (at, _) = histogram.sample(sobol_2d(i, key, Dimension::LightDirection));
            rows[(at.y * 4.0) as usize] += 1.0 / 256.0;
        }
        // Rows have the probabilities 4/24, 12/24, 4/24, 4/24; stratification is off by less than
        // one point per bound.
        for (row, expected) in rows.iter().zip([4.0, 12.0, 4.0, 4.0]) {
            assert!((row - expected / 24.0f64).abs() < 2.0 / 256.0, "{rows:?}");
        }
    }

    #[test]
    fn extreme_inputs_stay_in_range() {
        let histogram = Histogram::new(SIDE, &weights()).unwrap();
        for x in [0.0, 1e-30, 0.5, 1.0 - f32::EPSILON / 2.0] {
            for y in [0.0, 1e-30, 0.5, 1.0 - f32::EPSILON / 2.0] {
                let (at, density) = histogram.sample(Vec2::new(x, y));
                assert!(density > 0.0 && at.cmpge(Vec2::ZERO).all() && at.cmplt(Vec2::ONE).all(), "{at}");
            }
        }
        let even = Histogram::new(1, &[5.0]).unwrap();
        assert_eq!(even.sample(Vec2::new(0.3, 0.7)), (Vec2::new(0.3, 0.7), 1.0));
    }

    #[test]
    fn invalid_weights_are_refused() {
        for bad in [vec![0.0; 4], vec![1.0; 3], vec![1.0, 1.0, 1.0, -1.0], vec![f64::NAN; 4], vec![f64::INFINITY; 4]] {
            assert!(Histogram::new(2, &bad).is_none(), "{bad:?}");
        }
        assert!(Histogram::new(0, &[]).is_none() && Histogram::new(3, &[1.0; 9]).is_none());
    }
}
