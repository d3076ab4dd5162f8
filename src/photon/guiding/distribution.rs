//! Guiding distributions, fitted to the samples of a pilot.

use crate::light::{EmissionDimensions, Light};
use crate::sampling::SquareGridDistribution;
use glam::Vec2;

/// Sample of one pilot path.
#[derive(Clone, Copy, Debug)]
pub(super) struct GuidingSample {
    /// Index of the light.
    pub light: usize,
    /// Sample point of the position, in \[0, 1)².
    pub position: Vec2,
    /// Sample point of the direction, in \[0, 1)².
    pub direction: Vec2,
    /// Inverse pdf of position and direction.
    pub weight: f64,
    /// Sum of the squared changes of the picture, as if its light were the only one and not guided.
    pub square: f64,
}

/// Least mean number of samples per cell of the finest level.
const MIN_SAMPLES_PER_CELL: usize = 4;

/// Largest number of subdivisions of both squares together: 4096 cells.
const MAX_SUBDIVISIONS: u32 = 6;

/// Weight of a cell's parent, in samples (shrinkage).
const PARENT_WEIGHT: f64 = 8.0;

/// Numbers of subdivisions of the square of positions and of the square of directions.
type CellResolution = (u32, u32);

/// Mean squared changes in the cells of one level. Cells of positions are the outer index.
#[derive(Clone, Debug)]
struct GuidingCells {
    level: CellResolution,
    squares: Vec<f64>,
}

impl GuidingCells {
    fn new<'s>(
        level: CellResolution,
        samples: impl Iterator<Item = &'s GuidingSample>,
        parents: Option<&Self>,
    ) -> Self {
        #[derive(Clone, Copy, Default)]
        struct Sum {
            count: f64,
            weight: f64,
            square: f64,
        }
        let (positions, directions) = (1usize << level.0, 1usize << level.1);
        let mut sums = vec![Sum::default(); (positions * directions) * (positions * directions)];
        for s in samples {
            let sum = &mut sums[cell_index(level, s.position, s.direction)];
            sum.count += 1.0;
            sum.weight += s.weight;
            sum.square += s.weight * s.square;
        }
        let center = |i: usize, side: usize| (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32;
        let square = |(i, sum): (usize, &Sum)| {
            let inner = directions * directions;
            let parent = parents
                .map(|p| p.squares[cell_index(p.level, center(i / inner, positions), center(i % inner, directions))]);
            let own = if sum.count > 0.0 { sum.square / sum.weight } else { 0.0 };
            parent.map_or(own, |parent| (sum.count * own + PARENT_WEIGHT * parent) / (sum.count + PARENT_WEIGHT))
        };
        let squares = sums.iter().enumerate().map(square).collect();
        Self { level, squares }
    }

    /// Mean of the root mean squares: the standard deviation of a guided estimate.
    fn guided_deviation(&self) -> f64 {
        self.squares.iter().map(|s| s.sqrt()).sum::<f64>() / self.squares.len() as f64
    }

    /// Pdf of each cell, proportional to the root mean square, with a uniform fraction.
    fn cell_pdfs(&self, uniform: f64) -> Vec<f64> {
        let mean = self.guided_deviation();
        let pdf = |s: &f64| if mean > 0.0 { uniform + (1.0 - uniform) * s.sqrt() / mean } else { 1.0 };
        self.squares.iter().map(pdf).collect()
    }

    /// Second moment of an estimate that is guided by these cells, measured with other `samples`.
    fn second_moment<'s>(&self, uniform: f64, samples: impl Iterator<Item = &'s GuidingSample>) -> f64 {
        let cell_pdfs = self.cell_pdfs(uniform);
        samples.map(|s| s.weight * s.square / cell_pdfs[cell_index(self.level, s.position, s.direction)]).sum()
    }
}

#[inline]
fn cell_index(level: CellResolution, position: Vec2, direction: Vec2) -> usize {
    let directions = 1usize << level.1;
    SquareGridDistribution::cell_index(1 << level.0, position) * directions * directions
        + SquareGridDistribution::cell_index(directions, direction)
}

/// Cells fitted to the samples of one light.
#[derive(Clone, Debug)]
pub(super) struct GuidingFit {
    cells: GuidingCells,
}

impl GuidingFit {
    /// Fits cells to the samples of a light; `uniform` is the fraction of the distribution that
    /// stays uniform.
    ///
    /// Each step subdivides the square of positions or that of directions, whichever gives the
    /// smaller second moment. The best level of all steps is kept. Second moments are
    /// cross-validated between two halves of the samples against overfitting.
    pub fn new(light: &Light, samples: &[&GuidingSample], uniform: f64) -> Self {
        let EmissionDimensions { position, direction } = light.emission_dimensions();
        let most = (if position { MAX_SUBDIVISIONS } else { 0 }, if direction { MAX_SUBDIVISIONS } else { 0 });
        let half = |i: usize| samples.iter().copied().skip(i).step_by(2);
        let cost = |halves: &[GuidingCells; 2]| {
            halves[0].second_moment(uniform, half(1)) + halves[1].second_moment(uniform, half(0))
        };
        let mut cells = GuidingCells::new((0, 0), samples.iter().copied(), None);
        let mut halves = [0, 1].map(|i| GuidingCells::new((0, 0), half(i), None));
        let mut best = (cost(&halves), cells.clone());
        for subdivisions in 1..=MAX_SUBDIVISIONS {
            if MIN_SAMPLES_PER_CELL << (2 * subdivisions) > samples.len() {
                break;
            }
            let (p, d) = cells.level;
            let finer = [(p + 1, d), (p, d + 1)].into_iter().filter(|level| level.0 <= most.0 && level.1 <= most.1);
            let refined = finer.map(|level| {
                let halves = [0, 1].map(|i| GuidingCells::new(level, half(i), Some(&halves[i])));
                (cost(&halves), halves)
            });
            let Some((least, refined)) = refined.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            cells = GuidingCells::new(refined[0].level, samples.iter().copied(), Some(&cells));
            halves = refined;
            if least < best.0 {
                best = (least, cells.clone());
            }
        }
        Self { cells: best.1 }
    }

    /// Standard deviation of a guided path of this light, which determines its probability.
    pub fn guided_deviation(&self) -> f64 {
        self.cells.guided_deviation()
    }

    /// The guiding distribution with a uniform fraction; `None` for a single cell.
    pub fn to_distribution(&self, uniform: f64) -> Option<GuidingDistribution> {
        let (p, d) = self.cells.level;
        if (p, d) == (0, 0) {
            return None;
        }
        let cell_pdfs = self.cells.cell_pdfs(uniform);
        let directions = cell_pdfs.chunks_exact(1 << (2 * d));
        let positions: Vec<f64> = directions.clone().map(|d| d.iter().sum()).collect();
        Some(GuidingDistribution {
            side: 1 << p,
            positions: SquareGridDistribution::new(1 << p, &positions)?,
            directions: directions
                .map(|weights| SquareGridDistribution::new(1 << d, weights))
                .collect::<Option<_>>()?,
        })
    }
}

/// Distribution of the sample points of emission: of positions, and of directions within each cell
/// of positions.
#[derive(Clone, Debug)]
pub(in crate::photon) struct GuidingDistribution {
    /// Cells of positions along each side.
    side: usize,
    positions: SquareGridDistribution,
    /// Distribution of directions within each cell of positions.
    directions: Vec<SquareGridDistribution>,
}

impl GuidingDistribution {
    /// Maps two uniform points of \[0, 1)² to the sample points of a position and a direction, with
    /// their pdf.
    #[inline]
    pub fn sample(&self, position: Vec2, direction: Vec2) -> (Vec2, Vec2, f32) {
        let (position, pdf) = self.positions.sample(position);
        let (direction, conditional) =
            self.directions[SquareGridDistribution::cell_index(self.side, position)].sample(direction);
        (position, direction, pdf * conditional)
    }

    /// Pdf of the sample points of a position and a direction.
    #[cfg(test)]
    pub fn pdf(&self, position: Vec2, direction: Vec2) -> f32 {
        self.positions.pdf(position)
            * self.directions[SquareGridDistribution::cell_index(self.side, position)].pdf(direction)
    }
}
