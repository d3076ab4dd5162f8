//! Guided sampling of the environment light: shadow rays prefer directions from which the light of
//! the environment reaches the scene.
//!
//! Walls block shadow rays towards the environment: in a room, only rays through a window find
//! light. A grid over the scene holds in each cell a distribution over the unit square. The
//! environment map turns points of this square into directions, as its own importance sampling
//! does. So guided directions follow the product of the map's radiance and the visibility from the
//! cell. A pdf proportional to the root mean square of a ray's contribution to the picture has the
//! least noise (Rath et al. 2020, "Variance-Aware Path Guiding").

use crate::light::{DirectLightSample, EnvironmentLight, ShadowTarget};
use crate::sampling::SquareGridDistribution;
use glam::{Vec2, Vec3};

/// Number of histogram bins along each side of the unit square, which the environment light maps to
/// directions. Each cell of the grid over the scene has a histogram of its shadow-ray directions.
const BINS_PER_SIDE: usize = 32;

/// Number of bins of shadow-ray directions in each cell of the grid over the scene.
const BINS_PER_CELL: usize = BINS_PER_SIDE * BINS_PER_SIDE;

/// Number of times that the grid over the scene is refined when [`EnvironmentGuide`] is fitted.
/// Each refinement splits each cell into eight, and each bin of directions into four.
const REFINEMENTS: u32 = 3;

/// Number of cells of the finest grid along each axis of the scene.
const CELLS_PER_AXIS: u32 = 1 << REFINEMENTS;

/// Fraction of shadow-ray directions that follow the environment light's own distribution instead
/// of the learned one (defensive sampling).
///
/// The fraction bounds the weight of a guided ray: at most 1/0.2 = 5 times its weight without
/// guiding.
const DEFENSIVE_FRACTION: f64 = 0.2;

/// Weight of the parent bin in the estimate of a bin's mean squared contribution (shrinkage
/// estimator): the parent's mean counts as much as 2 rays in the bin. The parent is the larger bin
/// of the next coarser level that contains the bin.
const PARENT_WEIGHT: f64 = 2.0;

/// Learned distributions of the directions from which the environment light reaches each cell of a
/// grid over the scene.
#[derive(Debug)]
pub(super) struct EnvironmentGuide {
    grid: SceneCellGrid,
    /// Distribution of shadow-ray directions in each cell, over the unit square.
    /// [`EnvironmentLight::sample`] turns points of the square into directions.
    cells: Vec<SquareGridDistribution>,
}

/// Data to which [`EnvironmentGuide`] is fitted: for each bin of directions in each cell of a grid
/// over the scene, the number of pilot rays and the sum of their squared contributions to the
/// picture.
pub(super) struct EnvironmentGuideFitter {
    grid: SceneCellGrid,
    counts: Vec<f64>,
    squared_contribution_sums: Vec<f64>,
}

impl EnvironmentGuide {
    /// Samples the direct light of the environment `light` that arrives at `p`, by `u` in \[0, 1)².
    /// Directions follow the distribution learned for the cell of `p`.
    ///
    /// Returns `None` if `light` is black or the pdf is 0.
    #[inline]
    pub fn sample_li(&self, light: &EnvironmentLight, p: Vec3, u: Vec2) -> Option<DirectLightSample> {
        let (u, _) = self.sample_unit_square(p, u);
        let (wi, _) = light.sample(u)?;
        // Compute the pdf from the direction, as MIS weights do. Rounding may move the direction to
        // another bin than `u`.
        let pdf = self.pdf_li(light, p, wi);
        let weight = light.radiance(wi) / pdf;
        (pdf > 0.0).then_some(DirectLightSample { wi, target: ShadowTarget::Infinity, weight, pdf: Some(pdf) })
    }

    /// Returns the pdf \[1/sr] with which [`EnvironmentGuide::sample_li`] samples unit direction
    /// `wi` at `p`.
    #[inline]
    pub fn pdf_li(&self, light: &EnvironmentLight, p: Vec3, wi: Vec3) -> f32 {
        let cell = &self.cells[self.grid.cell_index(p)];
        light.pdf(wi) * light.inverse_sample(wi).map_or(0.0, |u| cell.pdf(u))
    }

    /// Samples a point of the unit square from the distribution learned for the cell of `p`.
    /// Returns the point and its pdf. The environment light then turns the point into the direction
    /// of a shadow ray from `p`. `u` is uniform in \[0, 1)².
    #[inline]
    pub fn sample_unit_square(&self, p: Vec3, u: Vec2) -> (Vec2, f32) {
        self.cells[self.grid.cell_index(p)].sample(u)
    }
}

impl EnvironmentGuideFitter {
    /// Makes a fitter without data. Its grid divides the scene into 8 layers along each axis, such
    /// that each layer holds the same number of the positions `points`.
    pub fn new(points: &[Vec3]) -> Self {
        let bins = (CELLS_PER_AXIS * CELLS_PER_AXIS * CELLS_PER_AXIS) as usize * BINS_PER_CELL;
        Self { grid: SceneCellGrid::new(points), counts: vec![0.0; bins], squared_contribution_sums: vec![0.0; bins] }
    }

    /// Adds one shadow ray of the pilot. The ray started at `p`. The environment light turned the
    /// point `u` in \[0, 1)² into the direction of the ray.
    ///
    /// `square` is the square of the ray's contribution to the picture, weighted as if unguided
    /// sampling had chosen the ray.
    pub fn add(&mut self, p: Vec3, u: Vec2, square: f64) {
        let bin = self.grid.cell_index(p) * BINS_PER_CELL + SquareGridDistribution::cell_index(BINS_PER_SIDE, u);
        self.counts[bin] += 1.0;
        self.squared_contribution_sums[bin] += square;
    }

    /// Returns the guide fitted to the added pilot rays; `None` if no ray contributed to the
    /// picture.
    ///
    /// A bin is a range of directions in one grid cell. The squared contributions are averaged in
    /// each bin. To reduce noise, each average is drawn towards the average of its parent bin, the
    /// larger bin of the next coarser level. The parent's average is first drawn towards its own
    /// parent's. The coarsest averages are drawn towards the average over all pilot rays.
    pub fn fitted_guide(&self) -> Option<EnvironmentGuide> {
        let mean = self.squared_contribution_sums.iter().sum::<f64>() / self.counts.iter().sum::<f64>().max(1.0);
        let mut means = vec![mean; RefinementLevel(0).bin_count()];
        for level in (0..=REFINEMENTS).map(RefinementLevel) {
            let (counts, squares) = (level.bin_sums(&self.counts), level.bin_sums(&self.squared_contribution_sums));
            let mean = |i: usize| {
                let parent = if level == RefinementLevel(0) { mean } else { means[level.parent_bin(i)] };
                (squares[i] + PARENT_WEIGHT * parent) / (counts[i] + PARENT_WEIGHT)
            };
            means = (0..counts.len()).map(mean).collect();
        }
        let cells = means.chunks_exact(BINS_PER_CELL).map(distribution).collect::<Option<Vec<_>>>()?;
        Some(EnvironmentGuide { grid: self.grid.clone(), cells })
    }
}

/// Level of refinement of the cells over the scene, and of the bins of directions in each cell.
/// Level 0 is the coarsest; each next level halves the edges of cells and bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct RefinementLevel(u32);

impl RefinementLevel {
    /// Returns the number of cells of this level along each axis of the scene.
    fn cells_per_axis(self) -> usize {
        1 << self.0
    }

    /// Returns the number of direction bins of this level along each side of a cell's unit square.
    fn bins_per_side(self) -> usize {
        BINS_PER_SIDE >> (REFINEMENTS - self.0)
    }

    /// Returns the total number of direction bins in all cells of this level.
    fn bin_count(self) -> usize {
        self.cells_per_axis()
            * self.cells_per_axis()
            * self.cells_per_axis()
            * self.bins_per_side()
            * self.bins_per_side()
    }

    /// Returns the index of the parent bin of bin `bin`: the bin of the next coarser level that
    /// contains it. `bin` is an index into this level.
    fn parent_bin(self, bin: usize) -> usize {
        let (cells, bins) = (self.cells_per_axis(), self.bins_per_side());
        let (cell, bin) = (bin / (bins * bins), bin % (bins * bins));
        let (x, y, z) = (cell % cells, cell / cells % cells, cell / (cells * cells));
        let cell = ((z / 2) * (cells / 2) + y / 2) * (cells / 2) + x / 2;
        (cell * (bins / 2) + bin / bins / 2) * (bins / 2) + bin % bins / 2
    }

    /// Returns the sum of `values` in each bin of this level. `values` holds one value for each bin
    /// of the finest level.
    fn bin_sums(self, values: &[f64]) -> Vec<f64> {
        let mut sums = values.to_vec();
        for fine in (self.0 + 1..=REFINEMENTS).rev().map(RefinementLevel) {
            let mut coarse = vec![0.0; RefinementLevel(fine.0 - 1).bin_count()];
            for (i, value) in sums.iter().enumerate() {
                coarse[fine.parent_bin(i)] += value;
            }
            sums = coarse;
        }
        sums
    }
}

/// Returns the distribution from which the shadow-ray directions of a cell are sampled, over the
/// unit square; `None` if all `means` are 0.
///
/// `means` are the mean squared contributions of rays to the picture, for each bin. The probability
/// of a bin is proportional to the square root of its mean, mixed with a uniform part of
/// [`DEFENSIVE_FRACTION`].
fn distribution(means: &[f64]) -> Option<SquareGridDistribution> {
    let roots: Vec<f64> = means.iter().map(|mean| mean.sqrt()).collect();
    let total: f64 = roots.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let weight = |root: &f64| (1.0 - DEFENSIVE_FRACTION) * root / total + DEFENSIVE_FRACTION / BINS_PER_CELL as f64;
    SquareGridDistribution::new(BINS_PER_SIDE, &roots.iter().map(weight).collect::<Vec<_>>())
}

/// Grid of 8 × 8 × 8 cells, divided by axis-aligned planes at uneven distances. The outer cells are
/// infinite.
#[derive(Clone, Debug)]
struct SceneCellGrid {
    /// Coordinates of the seven planes between cells along each axis, in ascending order \[length].
    planes: [[f32; CELLS_PER_AXIS as usize - 1]; 3],
}

impl SceneCellGrid {
    fn new(points: &[Vec3]) -> Self {
        let planes = [0, 1, 2].map(|axis| {
            let mut positions: Vec<f32> = points.iter().map(|p| p[axis]).collect();
            positions.sort_by(f32::total_cmp);
            let plane =
                |i: usize| positions.get((i + 1) * positions.len() / CELLS_PER_AXIS as usize).copied().unwrap_or(0.0);
            std::array::from_fn(plane)
        });
        Self { planes }
    }

    /// Returns the index of the cell that contains `p`.
    #[inline]
    fn cell_index(&self, p: Vec3) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.planes[axis].partition_point(|plane| *plane <= p[axis]));
        (z * CELLS_PER_AXIS as usize + y) * CELLS_PER_AXIS as usize + x
    }
}

#[cfg(test)]
mod tests;
