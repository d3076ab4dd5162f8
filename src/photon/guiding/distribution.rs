//! Guided pdfs of the primary samples in \[0, 1)⁴ (random numbers for position and direction) that
//! determine emitted photons. They are fitted to the samples of a pilot simulation.

use crate::light::{EmissionDimensions, Light};
use crate::sampling::SquareGridDistribution;
use glam::Vec2;

/// One photon path of the pilot, the small simulation before the render that trains emission
/// guiding. Holds the random numbers that determine the emitted ray (primary samples), and the
/// path's squared contribution to the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmissionGuidingSample {
    /// Index of the light that emits the path.
    pub light: usize,
    /// Primary sample in \[0, 1)² that determines the position on the light.
    pub position_sample: Vec2,
    /// Primary sample in \[0, 1)² that determines the emitted direction.
    pub direction_sample: Vec2,
    /// Inverse of the joint pdf of the primary samples `position_sample` and `direction_sample`.
    pub inverse_primary_pdf: f64,
    /// Sum of the squared contributions of the path's photons to the picture. The path starts with
    /// the emitted flux, not divided by the pdf, the probability of the light and the number of
    /// paths.
    pub squared_contribution: f64,
}

/// Smallest mean number of pilot paths per grid cell. The grid holds the piecewise constant pdf of
/// emission guiding. The grid is not refined if the finer grid would have fewer paths per cell.
const MIN_SAMPLES_PER_CELL: usize = 4;

/// Largest number of times that the grid of a light's guided pdf is subdivided. Each subdivision
/// splits each cell into four, so the grid has at most 4096 cells.
const MAX_SUBDIVISIONS: u32 = 6;

/// Weight of the parent in the estimated mean of a grid cell. The parent is the cell of the next
/// coarser grid that contains the cell. With n samples of mean m in the cell, and the parent's mean
/// M, the estimate is (n·m + 8·M)/(n + 8) (shrinkage estimator).
const PARENT_WEIGHT: f64 = 8.0;

/// Subdivisions of a grid over \[0, 1)⁴ for emission guiding: the number for the unit square of
/// positions, and the number for the unit square of directions.
///
/// n subdivisions give 2ⁿ cells along each side of a square.
type CellSubdivisions = (u32, u32);

/// A pilot sample as the fit reads it, once for each grid.
#[derive(Clone, Copy, Debug)]
struct GridSample {
    /// Column and row of the sample's cell in the finest grid of positions, then those in the
    /// finest grid of directions.
    finest_cell: [u8; 4],
    /// Inverse of the joint pdf of the primary samples.
    inverse_primary_pdf: f64,
    /// `inverse_primary_pdf` times the squared contribution of the path to the picture.
    weighted_square: f64,
}

impl GridSample {
    fn new(sample: &EmissionGuidingSample) -> Self {
        let side = 1u8 << MAX_SUBDIVISIONS;
        let cell = |x: f32| ((x * f32::from(side)) as u8).min(side - 1);
        let (p, d) = (sample.position_sample, sample.direction_sample);
        Self {
            finest_cell: [p.x, p.y, d.x, d.y].map(cell),
            inverse_primary_pdf: sample.inverse_primary_pdf,
            weighted_square: sample.inverse_primary_pdf * sample.squared_contribution,
        }
    }

    /// Returns the result of [`cell_index`] for the sample.
    #[inline]
    fn cell_index(&self, (position, direction): CellSubdivisions) -> usize {
        let index = |column: u8, row: u8, subdivisions: u32| {
            let cell = |finest: u8| usize::from(finest >> (MAX_SUBDIVISIONS - subdivisions));
            (cell(row) << subdivisions) + cell(column)
        };
        let [x, y, z, w] = self.finest_cell;
        (index(x, y, position) << (2 * direction)) + index(z, w, direction)
    }
}

/// Grid over the random numbers in \[0, 1)⁴ that determine the position and direction of an emitted
/// photon. For each cell, it holds the mean squared contribution of a photon path to the picture.
#[derive(Clone, Debug)]
struct EmissionGuidingCells {
    subdivisions: CellSubdivisions,
    /// Mean squared contribution of a photon path to the picture, in each cell. The cell of the
    /// position is the outer index, the cell of the direction the inner one.
    mean_squared_contributions: Vec<f64>,
}

impl EmissionGuidingCells {
    /// Averages the squared contributions of `samples` in each cell. The mean of a cell with few
    /// samples is drawn towards the mean of its parent cell in `parent_cells`.
    fn new<'s>(
        resolution: CellSubdivisions,
        samples: impl Iterator<Item = &'s GridSample>,
        parent_cells: Option<&Self>,
    ) -> Self {
        #[derive(Clone, Copy, Default)]
        struct CellSum {
            count: f64,
            weight: f64,
            square: f64,
        }
        let (positions, directions) = (1usize << resolution.0, 1usize << resolution.1);
        let mut sums = vec![CellSum::default(); (positions * directions) * (positions * directions)];
        for s in samples {
            let sum = &mut sums[s.cell_index(resolution)];
            sum.count += 1.0;
            sum.weight += s.inverse_primary_pdf;
            sum.square += s.weighted_square;
        }
        let center = |i: usize, side: usize| (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32;
        let square = |(i, sum): (usize, &CellSum)| {
            let inner = directions * directions;
            let parent = parent_cells.map(|p| {
                p.mean_squared_contributions
                    [cell_index(p.subdivisions, center(i / inner, positions), center(i % inner, directions))]
            });
            let own = if sum.count > 0.0 { sum.square / sum.weight } else { 0.0 };
            parent.map_or(own, |parent| (sum.count * own + PARENT_WEIGHT * parent) / (sum.count + PARENT_WEIGHT))
        };
        let squares = sums.iter().enumerate().map(square).collect();
        Self { subdivisions: resolution, mean_squared_contributions: squares }
    }

    /// Returns the mean over all cells of √(mean squared contribution of a photon path to the
    /// picture).
    ///
    /// The pdf of least variance is proportional to this square root. With this pdf, the returned
    /// mean is the root mean square of contribution / pdf.
    fn guided_root_mean_square(&self) -> f64 {
        self.mean_squared_contributions.iter().map(|s| s.sqrt()).sum::<f64>()
            / self.mean_squared_contributions.len() as f64
    }

    /// Returns the pdf of emission guiding in each cell, in which the uniform pdf has the weight
    /// `uniform`.
    ///
    /// The pdf is `uniform` + (1 − `uniform`)·s/s̄. Here, s is √(mean squared contribution) of the
    /// cell, and s̄ is the mean of s over all cells.
    ///
    /// If no sample contributes to the picture, the pdf is 1 in all cells.
    fn cell_pdfs(&self, uniform: f64) -> Vec<f64> {
        let mean = self.guided_root_mean_square();
        let pdf = |s: &f64| if mean > 0.0 { uniform + (1.0 - uniform) * s.sqrt() / mean } else { 1.0 };
        self.mean_squared_contributions.iter().map(pdf).collect()
    }

    /// Estimates Σ (contribution / pdf)² over photon paths that are sampled with the guided pdf of
    /// these cells. The number of these paths is the number of `samples`.
    ///
    /// `uniform` is the weight of the uniform pdf in the guided pdf. The estimate is unbiased only
    /// if the cells were fitted to other samples.
    fn second_moment_sum<'s>(&self, uniform: f64, samples: impl Iterator<Item = &'s GridSample>) -> f64 {
        let cell_pdfs = self.cell_pdfs(uniform);
        samples.map(|s| s.weighted_square / cell_pdfs[s.cell_index(self.subdivisions)]).sum()
    }
}

/// Returns the index into [`EmissionGuidingCells::mean_squared_contributions`] of the cell that
/// contains the primary sample (`position`, `direction`) in \[0, 1)⁴.
#[inline]
fn cell_index(resolution: CellSubdivisions, position: Vec2, direction: Vec2) -> usize {
    let directions = 1usize << resolution.1;
    SquareGridDistribution::cell_index(1 << resolution.0, position) * directions * directions
        + SquareGridDistribution::cell_index(directions, direction)
}

/// Grid for emission guiding, fitted to the pilot paths of one light. Its cells hold the mean
/// squared contribution of a photon path to the picture.
#[derive(Clone, Debug)]
pub(super) struct EmissionGuidingFit {
    cells: EmissionGuidingCells,
}

impl EmissionGuidingFit {
    /// Fits a grid of cells to the pilot samples of `light`.
    ///
    /// Each step subdivides the unit square of positions or the unit square of directions,
    /// whichever gives the smaller second moment of a path's contribution to the picture. The best
    /// grid of all steps is used. To avoid overfitting, second moments are cross-validated between
    /// two halves of the samples. `uniform` is the weight of the uniform pdf in the guided pdf.
    pub fn new(light: &Light, samples: &[&EmissionGuidingSample], uniform: f64) -> Self {
        let EmissionDimensions { uses_position, uses_direction } = light.emission_dimensions();
        let most =
            (if uses_position { MAX_SUBDIVISIONS } else { 0 }, if uses_direction { MAX_SUBDIVISIONS } else { 0 });
        let samples: Vec<GridSample> = samples.iter().map(|sample| GridSample::new(sample)).collect();
        let half = |i: usize| samples.iter().skip(i).step_by(2);
        // Only samples that contribute to the picture add to the second moment.
        let contributing = [0, 1].map(|i| half(i).filter(|s| s.weighted_square > 0.0).collect::<Vec<_>>());
        let cost = |halves: &[EmissionGuidingCells; 2]| {
            let second_moment_sum = |fitted: usize, other: usize| {
                halves[fitted].second_moment_sum(uniform, contributing[other].iter().copied())
            };
            second_moment_sum(0, 1) + second_moment_sum(1, 0)
        };
        let mut cells = EmissionGuidingCells::new((0, 0), samples.iter(), None);
        let mut halves = [0, 1].map(|i| EmissionGuidingCells::new((0, 0), half(i), None));
        let mut best = (cost(&halves), cells.clone());
        for subdivisions in 1..=MAX_SUBDIVISIONS {
            if MIN_SAMPLES_PER_CELL << (2 * subdivisions) > samples.len() {
                break;
            }
            let (p, d) = cells.subdivisions;
            let finer = [(p + 1, d), (p, d + 1)]
                .into_iter()
                .filter(|resolution| resolution.0 <= most.0 && resolution.1 <= most.1);
            let refined = finer.map(|resolution| {
                let halves = [0, 1].map(|i| EmissionGuidingCells::new(resolution, half(i), Some(&halves[i])));
                (cost(&halves), halves)
            });
            let Some((least, refined)) = refined.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            cells = EmissionGuidingCells::new(refined[0].subdivisions, samples.iter(), Some(&cells));
            halves = refined;
            if least < best.0 {
                best = (least, cells.clone());
            }
        }
        Self { cells: best.1 }
    }

    /// Returns the smallest root mean square of contribution / pdf that guiding can reach for this
    /// light, where contribution is what a photon path adds to the picture. Lights are chosen with
    /// probabilities proportional to this number.
    pub fn guided_root_mean_square(&self) -> f64 {
        self.cells.guided_root_mean_square()
    }

    /// Returns the pdf of emission guiding, in which the uniform pdf has the weight `uniform`;
    /// `None` if the grid has only one cell, so the pdf would be uniform.
    pub fn to_distribution(&self, uniform: f64) -> Option<EmissionGuidingDistribution> {
        let (p, d) = self.cells.subdivisions;
        if (p, d) == (0, 0) {
            return None;
        }
        let cell_pdfs = self.cells.cell_pdfs(uniform);
        let directions = cell_pdfs.chunks_exact(1 << (2 * d));
        let positions: Vec<f64> = directions.clone().map(|d| d.iter().sum()).collect();
        Some(EmissionGuidingDistribution {
            side: 1 << p,
            positions: SquareGridDistribution::new(1 << p, &positions)?,
            directions: directions
                .map(|weights| SquareGridDistribution::new(1 << d, weights))
                .collect::<Option<_>>()?,
        })
    }
}

/// Guided pdf of the photons that one light emits, fitted to pilot samples. It is a piecewise
/// constant pdf of the primary samples in \[0, 1)⁴ of position and direction.
#[derive(Clone, Debug)]
pub(in crate::photon) struct EmissionGuidingDistribution {
    /// Number of cells of `positions` along each side of its unit square.
    side: usize,
    /// Marginal pdf of the position's primary sample.
    positions: SquareGridDistribution,
    /// Conditional pdf of the direction's primary sample, for each cell of `positions`.
    directions: Vec<SquareGridDistribution>,
}

impl EmissionGuidingDistribution {
    /// Warps two uniform points of \[0, 1)² to a position and a direction sample that follow the
    /// guided pdf. Returns these two samples and their joint pdf.
    #[inline]
    pub fn sample(&self, position: Vec2, direction: Vec2) -> (Vec2, Vec2, f32) {
        let (position, pdf) = self.positions.sample(position);
        let (direction, conditional) =
            self.directions[SquareGridDistribution::cell_index(self.side, position)].sample(direction);
        (position, direction, pdf * conditional)
    }

    /// Joint pdf with which [`Self::sample`] returns the primary samples `position` and
    /// `direction`.
    #[cfg(test)]
    pub fn pdf(&self, position: Vec2, direction: Vec2) -> f32 {
        self.positions.pdf(position)
            * self.directions[SquareGridDistribution::cell_index(self.side, position)].pdf(direction)
    }
}
