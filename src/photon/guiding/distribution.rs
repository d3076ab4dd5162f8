//! Densities of emission, fitted to what a pilot found.

use crate::light::{EmissionDimensions, Light};
use crate::sampling::Histogram;
use glam::Vec2;

/// One path of a pilot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Its light.
    pub light: usize,
    /// Where it left the light, in \[0, 1)².
    pub position: Vec2,
    /// Which way, in \[0, 1)².
    pub direction: Vec2,
    /// One over the density of position and direction.
    pub weight: f64,
    /// Mean square of its changes to the picture, as if its light were alone and unlearned.
    pub square: f64,
}

/// Fewest samples a cell of the finest level, on average.
const PER_CELL: usize = 4;

/// Most halvings of the two squares together: 4096 cells.
const MOST_BITS: u32 = 6;

/// Samples that a cell's parent counts for.
const BELIEF: f64 = 8.0;

/// Halvings of the sides of a light's two squares: of positions, and of directions.
type Bits = (u32, u32);

/// Mean squares in the cells of one level of refinement, positions before directions.
#[derive(Clone, Debug)]
struct Cells {
    bits: Bits,
    squares: Vec<f64>,
}

impl Cells {
    fn new<'s>(bits: Bits, samples: impl Iterator<Item = &'s Sample>, parents: Option<&Self>) -> Self {
        #[derive(Clone, Copy, Default)]
        struct Sum {
            count: f64,
            weight: f64,
            square: f64,
        }
        let (positions, directions) = (1usize << bits.0, 1usize << bits.1);
        let mut sums = vec![Sum::default(); (positions * directions) * (positions * directions)];
        for s in samples {
            let sum = &mut sums[index(bits, s.position, s.direction)];
            sum.count += 1.0;
            sum.weight += s.weight;
            sum.square += s.weight * s.square;
        }
        let center = |i: usize, side: usize| (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32;
        let square = |(i, sum): (usize, &Sum)| {
            let inner = directions * directions;
            let parent =
                parents.map(|p| p.squares[index(p.bits, center(i / inner, positions), center(i % inner, directions))]);
            let own = if sum.count > 0.0 { sum.square / sum.weight } else { 0.0 };
            parent.map_or(own, |parent| (sum.count * own + BELIEF * parent) / (sum.count + BELIEF))
        };
        let squares = sums.iter().enumerate().map(square).collect();
        Self { bits, squares }
    }

    /// Mean of the root mean squares: what is left of the deviation of an estimate if emission follows them.
    fn deviation(&self) -> f64 {
        self.squares.iter().map(|s| s.sqrt()).sum::<f64>() / self.squares.len() as f64
    }

    /// Density of each cell: in proportion to the root mean square, which gives the least variance, but for a `share` that is uniform.
    fn densities(&self, share: f64) -> Vec<f64> {
        let mean = self.deviation();
        let density = |s: &f64| if mean > 0.0 { share + (1.0 - share) * s.sqrt() / mean } else { 1.0 };
        self.squares.iter().map(density).collect()
    }

    /// Second moment of an estimate from paths emitted by these densities, judged by `samples`.
    fn judged<'s>(&self, share: f64, samples: impl Iterator<Item = &'s Sample>) -> f64 {
        let densities = self.densities(share);
        samples.map(|s| s.weight * s.square / densities[index(self.bits, s.position, s.direction)]).sum()
    }
}

#[inline]
fn index(bits: Bits, position: Vec2, direction: Vec2) -> usize {
    let directions = 1usize << bits.1;
    Histogram::cell(1 << bits.0, position) * directions * directions + Histogram::cell(directions, direction)
}

/// What was learned of a light.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    cells: Cells,
}

impl Fit {
    /// Refines the squares of a light where that pays: of each step's two ways, halving the sides of one square or of the other,
    /// the better one is gone, and of the levels on this way the best is kept. How good a level is each half of the
    /// samples says of the densities that the other half would give, so that luck is not taken for structure.
    pub fn new(light: &Light, samples: &[&Sample], share: f64) -> Self {
        let EmissionDimensions { position, direction } = light.emission_dimensions();
        let most = (if position { MOST_BITS } else { 0 }, if direction { MOST_BITS } else { 0 });
        let half = |i: usize| samples.iter().copied().skip(i).step_by(2);
        let judged = |halves: &[Cells; 2]| halves[0].judged(share, half(1)) + halves[1].judged(share, half(0));
        let mut cells = Cells::new((0, 0), samples.iter().copied(), None);
        let mut halves = [0, 1].map(|i| Cells::new((0, 0), half(i), None));
        let mut best = (judged(&halves), cells.clone());
        for bits in 1..=MOST_BITS {
            if PER_CELL << (2 * bits) > samples.len() {
                break;
            }
            let (p, d) = cells.bits;
            let ways = [(p + 1, d), (p, d + 1)].into_iter().filter(|way| way.0 <= most.0 && way.1 <= most.1);
            let refined = ways.map(|way| {
                let halves = [0, 1].map(|i| Cells::new(way, half(i), Some(&halves[i])));
                (judged(&halves), halves)
            });
            let Some((cost, refined)) = refined.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            cells = Cells::new(refined[0].bits, samples.iter().copied(), Some(&cells));
            halves = refined;
            if cost < best.0 {
                best = (cost, cells.clone());
            }
        }
        Self { cells: best.1 }
    }

    /// Deviation of what a path of this light brings: its claim to paths.
    pub fn deviation(&self) -> f64 {
        self.cells.deviation()
    }

    /// The density of emission, a `share` of it uniform; `None` where there is nothing to prefer.
    pub fn density(&self, share: f64) -> Option<GuidingDistribution> {
        let (p, d) = self.cells.bits;
        if (p, d) == (0, 0) {
            return None;
        }
        let densities = self.cells.densities(share);
        let directions = densities.chunks_exact(1 << (2 * d));
        let positions: Vec<f64> = directions.clone().map(|d| d.iter().sum()).collect();
        Some(GuidingDistribution {
            side: 1 << p,
            positions: Histogram::new(1 << p, &positions)?,
            directions: directions.map(|weights| Histogram::new(1 << d, weights)).collect::<Option<_>>()?,
        })
    }
}

/// Density of emission on a light's squares: of positions, and of directions in each cell of the positions.
#[derive(Clone, Debug)]
pub(in crate::photon) struct GuidingDistribution {
    side: usize,
    positions: Histogram,
    directions: Vec<Histogram>,
}

impl GuidingDistribution {
    /// Maps two uniform points of \[0, 1)² to a position and a direction, with their density.
    #[inline]
    pub fn sample(&self, position: Vec2, direction: Vec2) -> (Vec2, Vec2, f32) {
        let (position, density) = self.positions.sample(position);
        let (direction, conditional) = self.directions[Histogram::cell(self.side, position)].sample(direction);
        (position, direction, density * conditional)
    }

    /// The density at a position and a direction.
    #[cfg(test)]
    pub fn density(&self, position: Vec2, direction: Vec2) -> f32 {
        self.positions.density(position) * self.directions[Histogram::cell(self.side, position)].density(direction)
    }
}
