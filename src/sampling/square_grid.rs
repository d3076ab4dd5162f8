//! Piecewise constant distribution on the unit square, over a square grid.

use glam::Vec2;

/// Probability distribution on \[0, 1)² with a constant pdf in each of `side` × `side` cells.
///
/// Sampling inverts the cumulative probabilities of the rows, then those of the columns in the
/// sampled row. Inversion is monotonic, so stratified points stay stratified. Probabilities of
/// rows, and of columns in a row, are multiples of 2⁻²⁴, like the uniform random numbers. So even
/// the smallest probabilities are sampled exactly.
#[derive(Clone, Debug)]
pub struct SquareGridDistribution {
    side: usize,
    /// Cumulative probabilities of the rows: `side + 1` numbers from 0 to 1.
    row_cdf: Vec<f32>,
    /// Cumulative probabilities of the columns in each row: `side + 1` numbers per row.
    column_cdfs: Vec<f32>,
    /// Lookup tables made by [`first_candidates`], which speed up searches in the cumulative
    /// probabilities: one table for `row_cdf`, then one for the columns of each row. Each table has
    /// `side` numbers.
    first_candidates: Vec<u16>,
}

/// Number of steps between 0 and 1: probabilities are multiples of 1/`PROBABILITY_STEPS` = 2⁻²⁴.
const PROBABILITY_STEPS: f64 = 16_777_216.0;

/// Smallest probability, in steps of 2⁻²⁴, of a row or column whose weight is not 0. A weight of 0
/// gives the probability 0.
///
/// Random numbers have the same steps. So a row of n steps can be sampled at only n distinct
/// positions, and a small n would be too coarse.
const MIN_CELL_STEPS: f64 = 64.0;

impl SquareGridDistribution {
    /// Creates the distribution in which the probability of a cell is proportional to its weight.
    /// `weights` lists `side` × `side` cells, row by row.
    ///
    /// Returns `None` unless `side` is a power of two up to 1024 and there are `side`² weights.
    /// Weights must be finite and at least 0, and one must be above 0.
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
        let rows = cumulative_probabilities(&sums);
        let columns: Vec<f32> = weights.chunks_exact(side).flat_map(cumulative_probabilities).collect();
        let cdfs = std::iter::once(rows.as_slice()).chain(columns.chunks_exact(side + 1));
        let first_candidates = cdfs.flat_map(first_candidates).collect();
        Some(Self { side, row_cdf: rows, column_cdfs: columns, first_candidates })
    }

    /// Samples a point in \[0, 1)² by the uniform point `u` in \[0, 1)²; returns the sampled point
    /// and its pdf.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let (rows, columns) = self.first_candidates.split_at(self.side);
        let (row, y, height) = find_interval(&self.row_cdf, rows, u.y);
        let columns = &columns[row * self.side..(row + 1) * self.side];
        let (column, x, width) = find_interval(self.cumulative_column_probabilities(row), columns, u.x);
        // Rounding must not move a point into the next cell, which has another pdf.
        let within = |cell: usize, x: f32| (cell as f32 + x).min((cell as f32 + 1.0).next_down());
        (Vec2::new(within(column, x), within(row, y)) / self.side as f32, self.cell_pdf(width, height))
    }

    /// Pdf at the point `u` in \[0, 1)².
    #[inline]
    #[must_use]
    pub fn pdf(&self, u: Vec2) -> f32 {
        let cell = |x: f32| ((x * self.side as f32) as usize).min(self.side - 1);
        let (column, row) = (cell(u.x), cell(u.y));
        let columns = self.cumulative_column_probabilities(row);
        self.cell_pdf(columns[column + 1] - columns[column], self.row_cdf[row + 1] - self.row_cdf[row])
    }

    /// Index of the cell that contains `u`, row by row, in a grid of `side` × `side` cells.
    #[inline]
    #[must_use]
    pub fn cell_index(side: usize, u: Vec2) -> usize {
        let cell = |x: f32| ((x * side as f32) as usize).min(side - 1);
        cell(u.y) * side + cell(u.x)
    }

    /// Cumulative probabilities of the columns in `row`: `side + 1` numbers from 0 to 1.
    fn cumulative_column_probabilities(&self, row: usize) -> &[f32] {
        let stride = self.side + 1;
        &self.column_cdfs[row * stride..(row + 1) * stride]
    }

    /// Pdf in a cell. `height` is the probability of the cell's row, and `width` is the probability
    /// of the cell's column in this row.
    fn cell_pdf(&self, width: f32, height: f32) -> f32 {
        let side = self.side as f32;
        (width * side) * (height * side)
    }
}

/// Returns cumulative probabilities from 0 to 1. The probability of item i is wᵢ/Σw for `weights`
/// w, rounded to a multiple of 2⁻²⁴.
///
/// Each weight above 0 gets at least [`MIN_CELL_STEPS`] such steps. If all weights are 0, all
/// probabilities are equal.
fn cumulative_probabilities(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let weight = |w: &f64| if total > 0.0 { *w / total } else { 1.0 / weights.len() as f64 };
    let kept = weights.iter().filter(|w| weight(w) > 0.0).count() as f64 * MIN_CELL_STEPS;
    let (mut sum, mut least) = (0.0, 0.0);
    let inner = weights.iter().map(|w| {
        sum += weight(w);
        least += if weight(w) > 0.0 { MIN_CELL_STEPS } else { 0.0 };
        (((sum.min(1.0) * (PROBABILITY_STEPS - kept)).round() + least) / PROBABILITY_STEPS) as f32
    });
    std::iter::once(0.0).chain(inner).collect()
}

/// Returns a lookup table that speeds up searches in `bounds`, the cumulative probabilities of n
/// intervals. Number i of the table is the index of the first bound above i/n.
///
/// A search for u in \[i/n, (i + 1)/n) begins at this bound, and takes few steps on average
/// (cutpoint method, Chen and Asau 1974).
fn first_candidates(bounds: &[f32]) -> impl Iterator<Item = u16> + '_ {
    let count = bounds.len() - 1;
    (0..count).map(move |i| bounds.partition_point(|b| *b <= i as f32 / count as f32) as u16)
}

/// Returns three values for the interval that contains `u`: the index of the interval, the relative
/// position of `u` in it, and the length of the interval, which is above 0.
///
/// `bounds` are the ends of the intervals, from 0 to 1. The number of intervals must be a power of
/// two. `candidates` is the lookup table that [`first_candidates`] makes of `bounds`.
#[inline]
fn find_interval(bounds: &[f32], candidates: &[u16], u: f32) -> (usize, f32, f32) {
    let part = ((u * candidates.len() as f32) as usize).min(candidates.len() - 1);
    let first = usize::from(candidates[part]);
    let above = first + bounds[first..].iter().take_while(|b| **b <= u).count();
    let i = above.clamp(1, bounds.len() - 1) - 1;
    let length = bounds[i + 1] - bounds[i];
    (i, (u - bounds[i]) / length, length)
}

#[cfg(test)]
mod tests;
