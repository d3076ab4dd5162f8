//! Piecewise constant distribution on the unit square, over a rectangular grid.

use super::DiscreteDistribution;
use glam::{UVec2, Vec2};

/// Probability distribution on \[0, 1)² with a constant pdf in each cell of a rectangular grid.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2d {
    /// Marginal distribution over the rows.
    rows: DiscreteDistribution,
    /// Conditional distribution over the columns, for each row; `None` for a row of weight 0.
    columns: Vec<Option<DiscreteDistribution>>,
    width: usize,
}

impl PiecewiseConstant2d {
    /// Creates the distribution over a grid of `width` × `height` cells, in which the probability
    /// of a cell is proportional to `weight(column, row)`.
    ///
    /// Returns `None` if there are no cells, if a weight is negative, or if their sum is 0 or not
    /// finite.
    #[must_use]
    pub fn new(width: usize, height: usize, weight: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let mut negative = false;
        let mut totals = Vec::with_capacity(height);
        let columns = (0..height).map(|y| {
            let weights = (0..width).map(|x| weight(x, y));
            totals.push(weights.clone().inspect(|w| negative |= *w < 0.0).sum());
            DiscreteDistribution::new(weights)
        });
        let columns: Vec<_> = columns.collect();
        let rows = DiscreteDistribution::new(totals)?;
        (!negative).then_some(Self { rows, columns, width })
    }

    /// Samples a point by the uniform point `u` in \[0, 1)².
    ///
    /// Returns three values. The first is the cell of the sampled point as (column, row). The
    /// second is the relative position of the point in this cell, in \[0, 1)². The third is the pdf
    /// on the unit square.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> (UVec2, Vec2, f32) {
        let (row, _) = self.rows.sample(u.y);
        let within = self.rows.remapped_sample(u.y, row);
        let Some(columns) = &self.columns[row] else {
            return (UVec2::new(0, row as u32), Vec2::new(u.x, within), 0.0);
        };
        let (column, _) = columns.sample(u.x);
        let cell = UVec2::new(column as u32, row as u32);
        (cell, Vec2::new(columns.remapped_sample(u.x, column), within), self.pdf(cell))
    }

    /// Inverse of [`PiecewiseConstant2d::sample`]: returns the point in \[0, 1)² for which `sample`
    /// returns `cell` and the position `within`.
    ///
    /// `cell` is (column, row), and `within` is the relative position in the cell, in \[0, 1)².
    #[inline]
    #[must_use]
    pub fn inverse_sample(&self, cell: UVec2, within: Vec2) -> Vec2 {
        let y = self.rows.inverse_sample(cell.y as usize, within.y);
        let columns = self.columns[cell.y as usize].as_ref();
        Vec2::new(columns.map_or(within.x, |columns| columns.inverse_sample(cell.x as usize, within.x)), y)
    }

    /// Pdf on the unit square, anywhere in the cell (column, row).
    #[inline]
    #[must_use]
    pub fn pdf(&self, cell: UVec2) -> f32 {
        let columns = self.columns[cell.y as usize].as_ref();
        let cells = (self.width * self.columns.len()) as f32;
        columns.map_or(0.0, |c| c.probability(cell.x as usize) * self.rows.probability(cell.y as usize) * cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Dimension, Key, Purpose};

    #[test]
    fn sampled_cells_follow_weights_and_positions_are_uniform() {
        let weights = [1.0, 0.0, 3.0, 0.0, 0.0, 0.0, 2.0, 2.0, 8.0];
        let grid = PiecewiseConstant2d::new(3, 3, |x, y| weights[3 * y + x]).unwrap();
        let n = 160_000u64;
        let (mut counts, mut sums) = ([0u32; 9], [Vec2::ZERO; 9]);
        for i in 0..n {
            let u = Key::new(4).purpose_key(Purpose::Test).child_key(i).uniform_2d(Dimension::LightDirection);
            let (cell, within, pdf) = grid.sample(u);
            let i = (cell.y * 3 + cell.x) as usize;
            assert!(within.cmpge(Vec2::ZERO).all() && within.cmplt(Vec2::ONE).all());
            // The inverse and the pdf are computed in f64 and rounded to f32.
            assert!((grid.inverse_sample(cell, within) - u).abs().max_element() < 2e-7, "{cell} {within} {u}");
            assert!((f64::from(pdf) / (weights[i] / 16.0 * 9.0) - 1.0).abs() < 1e-6 && pdf == grid.pdf(cell));
            counts[i] += 1;
            sums[i] += within;
        }
        for ((count, sum), weight) in counts.iter().zip(sums).zip(weights) {
            let mean = n as f64 * weight / 16.0;
            // The tolerance is five standard deviations, for counts and for means of uniform
            // numbers.
            assert!((f64::from(*count) - mean).abs() <= 5.0 * mean.sqrt(), "{count} {mean}");
            let sigma = (1.0 / (12.0 * *count as f32)).sqrt();
            assert!(*count == 0 || (sum / *count as f32 - 0.5).abs().max_element() < 5.0 * sigma, "{sum}");
        }
        assert_eq!(grid.pdf(UVec2::new(1, 1)), 0.0);
    }

    #[test]
    fn distributions_refuse_invalid_weights() {
        for weights in [&[0.0, 0.0][..], &[], &[1.0, -0.5, 2.0, 2.0], &[f64::NAN, 1.0], &[f64::MAX, f64::MAX]] {
            let height = weights.len() / 2;
            assert!(PiecewiseConstant2d::new(2, height, |x, y| weights[2 * y + x]).is_none(), "{weights:?}");
        }
    }
}
