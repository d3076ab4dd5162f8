//! Density of heterogeneous media on a grid, with upper bounds for blocks of cells.

use super::majorant_iterator::MajorantIterator;
use crate::math::{Ray, SingularTransformError, Transform};
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Number of grid cells along each side of a majorant block: a cube of cells for which one upper
/// bound of the density is stored.
pub(super) const BLOCK_SIDE: u32 = 8;

/// Reason why a density grid is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GridDensityError {
    /// The grid has no cells along some axis. The fields are its numbers of cells along x, y and z.
    #[error("a grid of {0} × {1} × {2} cells is empty: every side needs at least one")]
    Empty(u32, u32, u32),
    /// The grid does not fit into memory. The fields are its numbers of cells along x, y and z.
    #[error("a grid of {0} × {1} × {2} cells does not fit into memory: make it coarser")]
    TooLarge(u32, u32, u32),
    /// The number of listed densities differs from the number of cells.
    #[error("the grid has {expected} cells, but {found} densities are given")]
    DensityCountMismatch {
        /// Number of cells of the grid, which is the number of densities needed.
        expected: usize,
        /// Number of densities that were given.
        found: usize,
    },
    /// A density is negative or not finite.
    #[error("the density of cell ({x}, {y}, {z}), counted from 0, is {value}: it must be finite and at least 0")]
    InvalidDensity {
        /// Column of the invalid cell: its index along x.
        x: u32,
        /// Row of the invalid cell: its index along y.
        y: u32,
        /// Layer of the invalid cell: its index along z.
        z: u32,
        /// Invalid density of the cell.
        value: f32,
    },
    /// The map from the unit cube to scene coordinates is singular.
    #[error("the grid cannot be placed: {0}")]
    SingularPlacement(#[from] SingularTransformError),
}

/// Density of a medium on a regular grid that fills a box; 0 outside the box.
///
/// Values lie at cell centers and are stored with x fastest. The density is interpolated
/// trilinearly between centers, and constant in the outer half of the outermost cells. Clones share
/// the memory of the values.
#[derive(Clone, Debug)]
pub struct GridDensity {
    grid: Arc<SharedDensityGrid>,
    /// Map from the unit cube to the box of the grid, in scene coordinates.
    placement: Transform,
}

/// Cell densities and block majorants, which all copies of a grid share.
#[derive(Debug)]
struct SharedDensityGrid {
    cell_counts: [u32; 3],
    densities: Vec<f32>,
    /// Number of majorant blocks along each side of the grid.
    block_counts: [u32; 3],
    /// Majorant of each block, with x fastest: an upper bound of the density in the block.
    majorants: Vec<f32>,
    max_density: f32,
}

impl GridDensity {
    /// Creates a grid of `size` cells (along x, y and z) with densities `values`, x fastest.
    /// `placement` maps the unit cube to the box of the grid in scene coordinates.
    ///
    /// # Errors
    /// [`GridDensityError`] if a size, the number of values, a density or the placement is
    /// invalid.
    pub fn new(size: [u32; 3], values: Vec<f32>, placement: DAffine3) -> Result<Self, GridDensityError> {
        let expected = checked_cell_count(size)?;
        if values.len() != expected {
            return Err(GridDensityError::DensityCountMismatch { expected, found: values.len() });
        }
        if let Some(i) = values.iter().position(|v| !(*v >= 0.0 && v.is_finite())) {
            let (row, layer) = (size[0] as usize, size[0] as usize * size[1] as usize);
            let [x, y, z] = [i % row, i % layer / row, i / layer].map(|i| i as u32);
            return Err(GridDensityError::InvalidDensity { x, y, z, value: values[i] });
        }
        let placement = Transform::new(placement)?;
        let blocks = size.map(|n| n.div_ceil(BLOCK_SIDE));
        let majorants = block_majorants(size, &values, blocks);
        let max_density = majorants.iter().copied().fold(0.0, f32::max);
        Ok(Self {
            grid: Arc::new(SharedDensityGrid {
                cell_counts: size,
                densities: values,
                block_counts: blocks,
                majorants,
                max_density,
            }),
            placement,
        })
    }

    /// Creates a grid of `size` cells (along x, y and z) from the values of `density` at all cell
    /// centers.
    ///
    /// The argument of `density` is a point of the unit cube, which `placement` maps to scene
    /// coordinates.
    ///
    /// # Errors
    /// [`GridDensityError`] if a size, a density or the placement is invalid.
    pub fn from_fn(
        size: [u32; 3],
        placement: DAffine3,
        density: impl Fn(DVec3) -> f32 + Sync,
    ) -> Result<Self, GridDensityError> {
        let [nx, ny, nz] = size;
        let cells = checked_cell_count(size)?;
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

    /// Returns a copy of the grid, translated by `by` \[scene coordinates].
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        Self { grid: Arc::clone(&self.grid), placement: self.placement.translated(by) }
    }

    /// Returns a copy of the grid, transformed by `map`; `None` if the map is singular.
    #[must_use]
    pub fn transformed(&self, map: DAffine3) -> Option<Self> {
        let placement = Transform::new(map * *self.placement.forward()).ok()?;
        Some(Self { grid: Arc::clone(&self.grid), placement })
    }

    /// Density at point `p` in scene coordinates; 0 outside the grid.
    #[must_use]
    pub fn density(&self, p: Vec3) -> f32 {
        let q = self.placement.inverse().transform_point3(p.as_dvec3());
        let inside = q.cmpge(DVec3::ZERO).all() && q.cmple(DVec3::ONE).all();
        if inside { self.grid.interpolate_density(q * self.grid.cells_per_axis()) } else { 0.0 }
    }

    /// Largest density of the grid.
    #[must_use]
    pub fn max_density(&self) -> f32 {
        self.grid.max_density
    }

    /// Number of cells along x, y and z.
    #[must_use]
    pub fn cell_counts(&self) -> [u32; 3] {
        self.grid.cell_counts
    }

    /// Map from the unit cube to scene coordinates.
    #[must_use]
    pub fn unit_cube_to_scene(&self) -> &DAffine3 {
        self.placement.forward()
    }

    /// Memory of the grid's densities and majorants \[bytes].
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of::<SharedDensityGrid>() + size_of::<f32>() * (self.grid.densities.len() + self.grid.majorants.len())
    }

    /// Transforms the first `distance` \[length] of `ray` to grid space, where cells have side 1.
    pub(super) fn ray_in_grid(&self, ray: &Ray, distance: f32) -> GridRay<'_> {
        let cells = self.grid.cells_per_axis();
        let inverse = self.placement.inverse();
        let origin = inverse.transform_point3(ray.origin.as_dvec3()) * cells;
        let step = inverse.transform_vector3(ray.direction.as_dvec3()) * cells;
        GridRay { grid: &self.grid, origin, direction: step, max_distance: f64::from(distance) }
    }
}

/// A ray in grid space, where cells have side 1.
pub(super) struct GridRay<'a> {
    grid: &'a SharedDensityGrid,
    origin: DVec3,
    /// Change of the position in grid space per unit of scene distance along the ray.
    direction: DVec3,
    max_distance: f64,
}

impl GridRay<'_> {
    /// Iterates over the majorant blocks along the ray, from near to far, without blocks of
    /// majorant 0.
    ///
    /// Each item is (distance where the ray enters the block \[length], distance where it leaves
    /// the block \[length], majorant).
    pub(super) fn majorant_segments(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let SharedDensityGrid { block_counts: blocks, majorants, .. } = self.grid;
        let side = f64::from(BLOCK_SIDE);
        let far = self.grid.cells_per_axis() / side;
        MajorantIterator::new(self.origin / side, self.direction / side, far, *blocks, self.max_distance).filter_map(
            |(t0, t1, index)| {
                let majorant = f64::from(majorants[index]);
                (majorant > 0.0).then_some((t0, t1, majorant))
            },
        )
    }

    /// Density at distance `t` \[scene length] along the ray. The point there must be inside the
    /// grid.
    pub(super) fn density(&self, t: f64) -> f64 {
        f64::from(self.grid.interpolate_density(self.origin + self.direction * t))
    }
}

impl SharedDensityGrid {
    fn cells_per_axis(&self) -> DVec3 {
        let [x, y, z] = self.cell_counts.map(f64::from);
        DVec3::new(x, y, z)
    }

    /// Trilinearly interpolated density at `q` in grid space. For `q` outside the grid, the density
    /// at the grid point nearest to `q`.
    fn interpolate_density(&self, q: DVec3) -> f32 {
        let last = self.cells_per_axis() - 1.0;
        let q = (q - 0.5).clamp(DVec3::ZERO, last);
        let low = q.floor();
        let f = (q - low).as_vec3();
        let high = (low + 1.0).min(last).as_uvec3().to_array().map(|i| i as usize);
        let low = low.as_uvec3().to_array().map(|i| i as usize);
        let [nx, ny, _] = self.cell_counts.map(|n| n as usize);
        let along = |y: usize, z: usize| {
            let row = (z * ny + y) * nx;
            lerp(f.x, self.densities[row + low[0]], self.densities[row + high[0]])
        };
        let near = lerp(f.y, along(low[1], low[2]), along(high[1], low[2]));
        let far = lerp(f.y, along(low[1], high[2]), along(high[1], high[2]));
        lerp(f.z, near, far)
    }
}

/// Linear interpolation from `a` at `t` = 0 to `b` at `t` = 1, exact at both ends.
///
/// If `a` and `b` are finite and non-negative, so is the result.
fn lerp(t: f32, a: f32, b: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Returns the number of cells of a grid with `size` cells along x, y and z.
///
/// Returns an error if this number is 0, or if the densities do not fit into the address space.
fn checked_cell_count(size: [u32; 3]) -> Result<usize, GridDensityError> {
    let [x, y, z] = size;
    if x.min(y).min(z) == 0 {
        return Err(GridDensityError::Empty(x, y, z));
    }
    let cells = (x as usize).checked_mul(y as usize).and_then(|n| n.checked_mul(z as usize));
    cells.filter(|n| n.checked_mul(size_of::<f32>()).is_some()).ok_or(GridDensityError::TooLarge(x, y, z))
}

/// Returns the majorant of each block: the largest density of its cells and of all cells adjacent
/// to the block, which interpolation inside the block uses too.
///
/// `size` is the number of cells along each axis, and `blocks` the number of blocks.
fn block_majorants(size: [u32; 3], values: &[f32], blocks: [u32; 3]) -> Vec<f32> {
    let [nx, ny, _] = size.map(|n| n as usize);
    let [bx, by, bz] = blocks;
    let range = |b: u32, n: u32| {
        let (low, high) =
            ((b * BLOCK_SIDE).saturating_sub(1), b.saturating_add(1).saturating_mul(BLOCK_SIDE).saturating_add(1));
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
