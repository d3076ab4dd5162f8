//! Densities on a grid.

use super::majorant_iterator::MajorantIterator;
use crate::math::{Ray, Singular, Transform};
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Cells along the side of a block that has one majorant.
pub(super) const BLOCK: u32 = 8;

/// What is wrong with a grid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GridDensityError {
    /// A side has no cells.
    #[error("a grid of {0} × {1} × {2} cells is empty: every side needs at least one")]
    Empty(u32, u32, u32),
    /// The cells are more than memory holds.
    #[error("a grid of {0} × {1} × {2} cells does not fit into memory: make it coarser")]
    TooLarge(u32, u32, u32),
    /// The number of densities is not that of the cells.
    #[error("the grid has {expected} cells, but {found} densities are given")]
    Count {
        /// Cells.
        expected: usize,
        /// Densities.
        found: usize,
    },
    /// A density is negative, infinite or no number.
    #[error("the density of cell ({x}, {y}, {z}), counted from 0, is {value}: it must be finite and at least 0")]
    Cell {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// Layer.
        z: u32,
        /// Its density.
        value: f32,
    },
    /// The grid has no place in space.
    #[error("the grid cannot be placed: {0}")]
    Placement(#[from] Singular),
}

/// A density that varies inside a box, and is 0 outside.
///
/// Values stand at the middles of cells, x running fastest; between them the density is trilinear, and in the outer half of
/// the outer cells it stays what it is at their middles. Copies share the values.
#[derive(Clone, Debug)]
pub struct GridDensity {
    grid: Arc<Grid>,
    /// Unit cube to world.
    placement: Transform,
}

/// What does not depend on the place.
#[derive(Debug)]
struct Grid {
    size: [u32; 3],
    values: Vec<f32>,
    /// Blocks along each side.
    blocks: [u32; 3],
    /// The greatest density in each block.
    majorants: Vec<f32>,
    maximum: f32,
}

impl GridDensity {
    /// A grid of `size` cells, x fastest, in the image of the unit cube under `placement`.
    ///
    /// # Errors
    /// [`GridDensityError`] where the grid is empty, the number of values is not its number of cells, a value is negative or not
    /// finite, or the placement flattens space.
    pub fn new(size: [u32; 3], values: Vec<f32>, placement: DAffine3) -> Result<Self, GridDensityError> {
        let expected = count(size)?;
        if values.len() != expected {
            return Err(GridDensityError::Count { expected, found: values.len() });
        }
        if let Some(i) = values.iter().position(|v| !(*v >= 0.0 && v.is_finite())) {
            let (row, layer) = (size[0] as usize, size[0] as usize * size[1] as usize);
            let [x, y, z] = [i % row, i % layer / row, i / layer].map(|i| i as u32);
            return Err(GridDensityError::Cell { x, y, z, value: values[i] });
        }
        let placement = Transform::new(placement)?;
        let blocks = size.map(|n| n.div_ceil(BLOCK));
        let majorants = majorants(size, &values, blocks);
        let maximum = majorants.iter().copied().fold(0.0, f32::max);
        Ok(Self { grid: Arc::new(Grid { size, values, blocks, majorants, maximum }), placement })
    }

    /// The same with the values of `density` at the middles of the cells, which it is given in the unit cube.
    ///
    /// # Errors
    /// As [`GridDensity::new`], and [`GridDensityError::TooLarge`] where memory does not suffice.
    pub fn from_fn(
        size: [u32; 3],
        placement: DAffine3,
        density: impl Fn(DVec3) -> f32 + Sync,
    ) -> Result<Self, GridDensityError> {
        let [nx, ny, nz] = size;
        let cells = count(size)?;
        let mut values = Vec::new();
        values.try_reserve_exact(cells).map_err(|_| GridDensityError::TooLarge(nx, ny, nz))?;
        values.resize(cells, 0.0);
        let scale = DVec3::new(f64::from(nx), f64::from(ny), f64::from(nz)).recip();
        values.par_chunks_mut(nx as usize).enumerate().for_each(|(row, values)| {
            let (y, z) = (row % ny as usize, row / ny as usize);
            for (x, value) in values.iter_mut().enumerate() {
                *value = density((DVec3::new(x as f64, y as f64, z as f64) + 0.5) * scale);
            }
        });
        Self::new(size, values, placement)
    }

    /// The field moved by `by`.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        Self { grid: Arc::clone(&self.grid), placement: self.placement.translated(by) }
    }

    /// The density at a point of the world.
    #[must_use]
    pub fn density(&self, p: Vec3) -> f32 {
        let q = self.placement.inverse().transform_point3(p.as_dvec3());
        let inside = q.cmpge(DVec3::ZERO).all() && q.cmple(DVec3::ONE).all();
        if inside { self.grid.at(q * self.grid.cells()) } else { 0.0 }
    }

    /// A density that is nowhere exceeded.
    #[must_use]
    pub fn maximum(&self) -> f32 {
        self.grid.maximum
    }

    /// Cells along each side.
    #[must_use]
    pub fn size(&self) -> [u32; 3] {
        self.grid.size
    }

    /// Unit cube to world.
    #[must_use]
    pub fn placement(&self) -> &DAffine3 {
        self.placement.forward()
    }

    /// What it takes \[bytes].
    #[must_use]
    pub fn memory(&self) -> usize {
        size_of::<Grid>() + size_of::<f32>() * (self.grid.values.len() + self.grid.majorants.len())
    }

    /// The blocks that `ray` passes up to `distance`.
    pub(super) fn along(&self, ray: &Ray, distance: f32) -> Line<'_> {
        let cells = self.grid.cells();
        let inverse = self.placement.inverse();
        let origin = inverse.transform_point3(ray.origin.as_dvec3()) * cells;
        let step = inverse.transform_vector3(ray.direction.as_dvec3()) * cells;
        Line { grid: &self.grid, origin, step, distance: f64::from(distance) }
    }
}

/// A ray in the space where cells have side 1.
pub(super) struct Line<'a> {
    grid: &'a Grid,
    origin: DVec3,
    step: DVec3,
    distance: f64,
}

impl Line<'_> {
    /// Where it enters a block, where it leaves it, and the block's majorant, from near to far; blocks without density are left
    /// out.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let Grid { blocks, majorants, .. } = self.grid;
        let side = f64::from(BLOCK);
        let far = self.grid.cells() / side;
        MajorantIterator::new(self.origin / side, self.step / side, far, *blocks, self.distance).filter_map(
            |(t0, t1, index)| {
                let majorant = f64::from(majorants[index]);
                (majorant > 0.0).then_some((t0, t1, majorant))
            },
        )
    }

    /// The density at `t` in the box.
    pub(super) fn density(&self, t: f64) -> f64 {
        f64::from(self.grid.at(self.origin + self.step * t))
    }
}

impl Grid {
    fn cells(&self) -> DVec3 {
        let [x, y, z] = self.size.map(f64::from);
        DVec3::new(x, y, z)
    }

    /// The density at `q`, in cells; outside it is that of the nearest point of the box.
    fn at(&self, q: DVec3) -> f32 {
        let last = self.cells() - 1.0;
        let q = (q - 0.5).clamp(DVec3::ZERO, last);
        let low = q.floor();
        let f = (q - low).as_vec3();
        let high = (low + 1.0).min(last).as_uvec3().to_array().map(|i| i as usize);
        let low = low.as_uvec3().to_array().map(|i| i as usize);
        let [nx, ny, _] = self.size.map(|n| n as usize);
        let along = |y: usize, z: usize| {
            let row = (z * ny + y) * nx;
            lerp(f.x, self.values[row + low[0]], self.values[row + high[0]])
        };
        let near = lerp(f.y, along(low[1], low[2]), along(high[1], low[2]));
        let far = lerp(f.y, along(low[1], high[2]), along(high[1], high[2]));
        lerp(f.z, near, far)
    }
}

/// Weights of both ends, so that it is never negative and finite where they are.
fn lerp(t: f32, a: f32, b: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// The number of cells.
fn count(size: [u32; 3]) -> Result<usize, GridDensityError> {
    let [x, y, z] = size;
    if x.min(y).min(z) == 0 {
        return Err(GridDensityError::Empty(x, y, z));
    }
    let cells = (x as usize).checked_mul(y as usize).and_then(|n| n.checked_mul(z as usize));
    cells.filter(|n| n.checked_mul(size_of::<f32>()).is_some()).ok_or(GridDensityError::TooLarge(x, y, z))
}

/// The greatest value that a point of each block is interpolated from: of its cells and of their neighbours.
fn majorants(size: [u32; 3], values: &[f32], blocks: [u32; 3]) -> Vec<f32> {
    let [nx, ny, _] = size.map(|n| n as usize);
    let [bx, by, bz] = blocks;
    let range = |b: u32, n: u32| {
        let (low, high) = ((b * BLOCK).saturating_sub(1), b.saturating_add(1).saturating_mul(BLOCK).saturating_add(1));
        low as usize..high.min(n) as usize
    };
    let index = (0..bz).flat_map(|z| (0..by).flat_map(move |y| (0..bx).map(move |x| [x, y, z])));
    let greatest = |[x, y, z]: [u32; 3]| {
        let columns = range(x, size[0]);
        let rows = range(z, size[2]).flat_map(|z| range(y, size[1]).map(move |y| (z * ny + y) * nx));
        rows.flat_map(|row| &values[row + columns.start..row + columns.end]).copied().fold(0.0, f32::max)
    };
    index.map(greatest).collect()
}
