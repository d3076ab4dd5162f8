//! Guide for next-event estimation in homogeneous media: it samples scattering points, the points
//! from which shadow rays start.
//!
//! Shadow rays from points of a medium find light only where direct light arrives, such as in the
//! cone of a spot light or in the shafts behind a window. A grid over the visible part of the media
//! holds a value for each cell and light: the root mean square of the radiance that a shadow ray
//! from the cell finds. A pdf proportional to this value has the least noise for points along a
//! camera ray (Rath et al. 2020, "Variance-Aware Path Guiding").

use crate::math::{Bounds, Ray};
use glam::{UVec3, Vec3};

/// Largest number of cells of the grid over the visible media.
const MAX_CELLS: f32 = 24_000.0;

/// Weight of the neighborhood in the estimate of a cell (shrinkage estimator): the mean of the
/// 3×3×3 block around the cell counts as much as one shadow ray.
const NEIGHBORHOOD_WEIGHT: f64 = 1.0;

/// Learned radiance that shadow rays to each light find, in each cell of a grid over the visible
/// media. Most shadow rays start at points that are sampled in proportion to this radiance times
/// the transmittance along the camera ray.
#[derive(Debug)]
pub(super) struct ScatterPointGuide {
    grid: MediumCellGrid,
    /// Root mean square of the radiance that a shadow ray finds, for each light and cell \[W/(m²
    /// sr)]: all cells of the first light come first.
    rms_radiance_by_light_and_cell: Vec<f32>,
}

/// Data to which [`ScatterPointGuide`] is fitted: for each light and cell, the number of pilot
/// shadow rays and the sum of the squared radiance that they found.
pub(super) struct ScatterPointGuideFitter {
    grid: MediumCellGrid,
    ray_counts: Vec<f64>,
    squared_radiance_sums: Vec<f64>,
}

/// Light that one shadow ray of a pilot (small simulation before the first pass) found from a point
/// of a medium.
#[derive(Clone, Copy, Debug)]
pub(super) struct InScatteringSample {
    /// Index of the light.
    pub light: usize,
    /// Point of the medium where the light scatters and the shadow ray starts, in world space.
    pub p: Vec3,
    /// Value E·f/n \[W/(m² sr)]. E is the irradiance that arrives from the light, f the phase
    /// function, and n the number of shadow rays that a surface point sends to the light. Times n
    /// and the scattering coefficient, the value is the radiance that the medium scatters per unit
    /// of length.
    pub scattered_radiance: f64,
    /// Contribution of the ray to the radiance of its camera path \[W/(m² sr)].
    pub contribution: f64,
}

/// Piecewise constant distribution of distances along a ray, at which shadow rays start. It has one
/// piece for each cell of the guide's grid that the ray crosses.
///
/// Its memory is reused from ray to ray.
#[derive(Debug, Default)]
pub(super) struct GuidedDistanceDistribution {
    /// Distance along the ray at which the first piece begins \[length].
    start: f32,
    /// Distance along the ray at which each piece ends \[length].
    ends: Vec<f32>,
    /// For each piece, the sum of the weights of this piece and of all earlier pieces.
    cumulative: Vec<f32>,
}

/// Grid of equal cells over an axis-aligned bounding box.
#[derive(Clone, Debug)]
struct MediumCellGrid {
    origin: Vec3,
    /// Edge lengths of a cell along x, y and z \[length].
    cell: Vec3,
    cells_per_axis: UVec3,
}

impl ScatterPointGuide {
    /// Fills `distances` with the guided distribution of distances along `ray`, for the light with
    /// index `light`, in a medium of mean extinction coefficient `extinction` \[1/length].
    ///
    /// The total weight of `distances` is 0 if the pilot found no light in the cells along the ray
    /// or next to them, or if it did not record the light with index `light`.
    pub fn distances_along(
        &self,
        light: usize,
        ray: &Ray,
        extinction: f32,
        distances: &mut GuidedDistanceDistribution,
    ) {
        distances.clear();
        let len = self.grid.len();
        // The guide has no values for lights that the pilot did not record.
        let Some(values) = self.rms_radiance_by_light_and_cell.get(light * len..(light + 1) * len) else { return };
        self.grid.for_each_cell(ray, |cell, from, to| {
            // Approximate exp(−depth) by a rational function: any positive weight is unbiased.
            let depth = extinction * 0.5 * (from + to);
            let transmittance = 1.0 / (1.0 + depth * (1.0 + 0.5 * depth));
            distances.push_piece(from, to, values[cell] * transmittance * (to - from));
        });
    }
}

impl ScatterPointGuideFitter {
    /// Makes a fitter without data for `lights` lights, with a grid over the bounding box of
    /// `points`. Returns `None` if the box is empty, a single point, or not finite.
    pub fn new(points: impl Iterator<Item = Vec3>, lights: usize) -> Option<Self> {
        let grid = MediumCellGrid::new(&Bounds::from_points(points))?;
        let len = grid.len() * lights;
        Some(Self { grid, ray_counts: vec![0.0; len], squared_radiance_sums: vec![0.0; len] })
    }

    /// Adds the radiance that one shadow ray of the pilot found.
    pub fn add(&mut self, sample: &InScatteringSample) {
        let i = sample.light * self.grid.len() + self.grid.cell_index(sample.p);
        self.ray_counts[i] += 1.0;
        self.squared_radiance_sums[i] += sample.scattered_radiance * sample.scattered_radiance;
    }

    /// Returns the guide fitted to the added rays.
    ///
    /// To reduce noise, the mean of each cell is drawn towards the mean of the block of 3×3×3 cells
    /// around it.
    pub fn fitted_guide(self) -> ScatterPointGuide {
        let len = self.grid.len();
        let mean = |i: usize| {
            let (mut count, mut square) = (0.0, 0.0);
            self.grid.for_each_cell_in_neighborhood(i % len, |cell| {
                count += self.ray_counts[i / len * len + cell];
                square += self.squared_radiance_sums[i / len * len + cell];
            });
            let neighborhood = if count > 0.0 { square / count } else { 0.0 };
            let mean = (self.squared_radiance_sums[i] + NEIGHBORHOOD_WEIGHT * neighborhood)
                / (self.ray_counts[i] + NEIGHBORHOOD_WEIGHT);
            mean.sqrt() as f32
        };
        let values = (0..self.ray_counts.len()).map(mean).collect();
        ScatterPointGuide { grid: self.grid, rms_radiance_by_light_and_cell: values }
    }
}

impl GuidedDistanceDistribution {
    /// Removes all pieces.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.cumulative.clear();
    }

    /// Adds a piece from distance `from`, where the last piece ended, to distance `to` \[length].
    fn push_piece(&mut self, from: f32, to: f32, weight: f32) {
        if self.ends.is_empty() {
            self.start = from;
        }
        let weight = if weight.is_finite() { weight } else { 0.0 };
        self.cumulative.push(self.total_weight() + weight);
        self.ends.push(to);
    }

    /// Returns the sum of the weights of all pieces; 0 if the distribution is empty.
    pub fn total_weight(&self) -> f32 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// Samples a distance along the ray \[length] by uniform `u` in \[0, 1). The total weight must
    /// be positive.
    pub fn sample(&self, u: f32) -> f32 {
        let target = u * self.total_weight();
        let i = self.cumulative.partition_point(|sum| *sum <= target).min(self.ends.len() - 1);
        let (from, below) = self.piece_start(i);
        let fraction = (target - below) / (self.cumulative[i] - below);
        (from + fraction.clamp(0.0, 1.0) * (self.ends[i] - from)).min(self.ends[i])
    }

    /// Returns the pdf of distance `t` \[1/length]; 0 outside all pieces. The total weight must be
    /// positive.
    pub fn pdf(&self, t: f32) -> f32 {
        let i = self.ends.partition_point(|end| *end < t);
        if t < self.start || i == self.ends.len() {
            return 0.0;
        }
        let (from, below) = self.piece_start(i);
        (self.cumulative[i] - below) / (self.total_weight() * (self.ends[i] - from))
    }

    /// Returns the distance along the ray at which piece `i` begins \[length], and the sum of the
    /// weights before it.
    fn piece_start(&self, i: usize) -> (f32, f32) {
        if i == 0 { (self.start, 0.0) } else { (self.ends[i - 1], self.cumulative[i - 1]) }
    }
}

impl MediumCellGrid {
    /// Makes a grid of nearly cubic cells over `bounds`; `None` if the box is empty, a single
    /// point, or not finite.
    fn new(bounds: &Bounds) -> Option<Self> {
        let extent = bounds.extent();
        let longest = extent.max_element();
        if bounds.is_empty() || !longest.is_finite() || longest <= 0.0 {
            return None;
        }
        // A flat box gets a little depth, so that each cell has a volume.
        let extent = extent.max(Vec3::splat(longest * 1e-3));
        let mut edge = longest / libm::cbrtf(MAX_CELLS);
        let counts = |edge: f32| (extent / edge).ceil().max(Vec3::ONE);
        // Cells shrink while there are too few of them.
        while counts(edge / 1.1).element_product() <= MAX_CELLS {
            edge /= 1.1;
        }
        let counts = counts(edge);
        let origin = bounds.center() - 0.5 * extent;
        Some(Self { origin, cell: extent / counts, cells_per_axis: counts.as_uvec3() })
    }

    /// Returns the number of cells.
    fn len(&self) -> usize {
        self.cells_per_axis.element_product() as usize
    }

    /// Returns the index of the cell that contains `p`, or of the cell nearest to `p` if `p` is
    /// outside of the grid.
    fn cell_index(&self, p: Vec3) -> usize {
        let cell = ((p - self.origin) / self.cell).max(Vec3::ZERO).as_uvec3().min(self.cells_per_axis - UVec3::ONE);
        self.index(cell)
    }

    /// Returns the index of the cell with the integer coordinates `cell`.
    fn index(&self, cell: UVec3) -> usize {
        ((cell.z * self.cells_per_axis.y + cell.y) * self.cells_per_axis.x + cell.x) as usize
    }

    /// Calls `visit` with the index of each cell of the 3×3×3 block around cell `index`, including
    /// `index` itself.
    fn for_each_cell_in_neighborhood(&self, index: usize, mut visit: impl FnMut(usize)) {
        let index = index as u32;
        let cell = UVec3::new(
            index % self.cells_per_axis.x,
            index / self.cells_per_axis.x % self.cells_per_axis.y,
            index / (self.cells_per_axis.x * self.cells_per_axis.y),
        );
        let (low, high) = (cell.saturating_sub(UVec3::ONE), (cell + 1).min(self.cells_per_axis - UVec3::ONE));
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    visit(self.index(UVec3::new(x, y, z)));
                }
            }
        }
    }

    /// Calls `visit` with the index of each cell along `ray`, and with the distances at which the
    /// ray enters and leaves that cell.
    ///
    /// Source: Amanatides and Woo 1987, "A Fast Voxel Traversal Algorithm for Ray Tracing".
    fn for_each_cell(&self, ray: &Ray, mut visit: impl FnMut(usize, f32, f32)) {
        let end = self.origin + self.cell * self.cells_per_axis.as_vec3();
        let inverse = ray.direction.recip();
        let (a, b) = ((self.origin - ray.origin) * inverse, (end - ray.origin) * inverse);
        // Coordinates to which the ray is perpendicular give infinities, or NaN on a face of the
        // box. `max` and `min` skip these.
        let mut from = a.min(b).max_element().max(0.0);
        let last = a.max(b).min_element().min(ray.t_max);
        let meets_box = from < last;
        if !meets_box {
            return;
        }
        let p = (ray.at(from) - self.origin) / self.cell;
        let mut cell = p.max(Vec3::ZERO).as_uvec3().min(self.cells_per_axis - UVec3::ONE);
        loop {
            // Find the nearest of the three planes through which the ray may leave the cell.
            let forward = ray.direction.cmpgt(Vec3::ZERO);
            let side = Vec3::select(forward, Vec3::ONE, Vec3::ZERO);
            let exits = (self.origin + (cell.as_vec3() + side) * self.cell - ray.origin) * inverse;
            let exits = Vec3::select(ray.direction.cmpeq(Vec3::ZERO), Vec3::INFINITY, exits);
            let axis = if exits.x <= exits.y && exits.x <= exits.z {
                0
            } else if exits.y <= exits.z {
                1
            } else {
                2
            };
            let to = exits[axis].clamp(from, last);
            if to > from {
                visit(self.index(cell), from, to);
            }
            from = to;
            let leaves =
                if ray.direction[axis] > 0.0 { cell[axis] + 1 == self.cells_per_axis[axis] } else { cell[axis] == 0 };
            if leaves || from >= last {
                return;
            }
            cell[axis] = if ray.direction[axis] > 0.0 { cell[axis] + 1 } else { cell[axis] - 1 };
        }
    }
}

#[cfg(test)]
mod tests;
