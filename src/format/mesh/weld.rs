//! Welding: merges vertices that are closer than a tolerance.

use super::{TriangleMesh, point_bounds};
use ahash::RandomState;
use glam::DVec3;
use std::collections::HashMap;

const NO_POINT: u32 = u32::MAX;

/// Largest merge tolerance \[length]; its square does not overflow.
const MAX_SQUARABLE_TOLERANCE: f64 = 1e150;

pub(super) fn weld_vertices(mesh: &mut TriangleMesh, tolerance: f64) -> usize {
    let (_, before) = mesh.distinct_position_indices();
    let mut kept = WeldGrid::new(tolerance.clamp(0.0, MAX_SQUARABLE_TOLERANCE), &mesh.positions);
    for p in &mut mesh.positions {
        *p = kept.find_or_insert(*p);
    }
    mesh.merge_equal_vertices();
    let (_, after) = mesh.distinct_position_indices();
    before.saturating_sub(after)
}

/// Hash grid of the positions at which vertices lie after welding.
///
/// Cells are at least twice as wide as the merge tolerance, so that a search examines only 8 cells.
struct WeldGrid {
    tolerance: f64,
    low: DVec3,
    cell_size: f64,
    /// Index into `points` of the position that was added last to each cell, by cell coordinates.
    last_in_cell: HashMap<[i64; 3], u32, RandomState>,
    /// Positions in the grid. Each is followed by the index of the position that was added before
    /// it to the same cell; [`NO_POINT`] if there is none.
    points: Vec<(DVec3, u32)>,
}

impl WeldGrid {
    fn new(tolerance: f64, positions: &[DVec3]) -> Self {
        let (low, high) = point_bounds(positions.iter().copied());
        // At most 10¹² cells span the mesh, so cell indices fit into i64.
        let cell = (2.0 * tolerance).max((high - low).max_element() * 1e-12);
        Self {
            tolerance,
            low,
            cell_size: if cell > 0.0 && cell.is_finite() { cell } else { 1.0 },
            last_in_cell: HashMap::with_hasher(RandomState::with_seeds(1, 2, 3, 4)),
            points: Vec::new(),
        }
    }

    /// Returns the position that was added first among those within the tolerance of `p`.
    ///
    /// If the grid has no position so near, adds `p` and returns `p`.
    fn find_or_insert(&mut self, p: DVec3) -> DVec3 {
        let at = (p - self.low) / self.cell_size;
        let corner = at.floor();
        // A position within the tolerance is at most half a cell away, so it is in one of 8 cells.
        let side = (at - corner).cmpge(DVec3::splat(0.5));
        let base = corner.to_array().map(|x| x as i64);
        let step = [side.x, side.y, side.z].map(|upper| if upper { 1 } else { -1 });
        let mut found = NO_POINT;
        for neighbour in 0..8 {
            let cell = [0, 1, 2].map(|axis| base[axis] + if neighbour >> axis & 1 == 1 { step[axis] } else { 0 });
            let mut i = self.last_in_cell.get(&cell).copied().unwrap_or(NO_POINT);
            while i != NO_POINT {
                let (point, before) = self.points[i as usize];
                if (point - p).length() <= self.tolerance {
                    found = found.min(i);
                }
                i = before;
            }
        }
        if found != NO_POINT {
            return self.points[found as usize].0;
        }
        let number = self.points.len() as u32;
        let before = self.last_in_cell.insert(base, number).unwrap_or(NO_POINT);
        self.points.push((p, before));
        p
    }
}
