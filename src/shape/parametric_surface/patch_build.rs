//! Subdivision of Bézier patches until they are nearly flat.

use super::box_bvh::BoxCorners;
use super::patch_piece::LinearTermsWithBounds;
use super::polynomial::{Coefficient, bernstein_to_power_basis, split_bezier};
use super::spline::{MIN_RELATIVE_KNOT_SPAN, SplineError};
use glam::{DVec2, DVec3, Vec2};

/// Limit of the change of the derivatives over a piece, relative to the derivatives. A piece below
/// this limit counts as nearly flat, and is not divided further.
const MAX_RELATIVE_BEND: f64 = 1.0 / 16.0;

/// Maximum number of nested halvings of a Bézier patch. Only pieces at poles, cusps and collapsed
/// edges reach this number, because they never become flat.
const MAX_HALVINGS: u32 = 14;

/// Smallest size of a piece that is still divided, relative to the size of its Bézier patch.
const MIN_RELATIVE_SIZE: f64 = 1.0 / 256.0;

/// Memory of a leaf, a nearly flat piece of a patch \[bytes]. The bounding box of the leaf, and its
/// nodes in the bounding volume hierarchy and in the subdivision tree, are included.
///
/// The polynomial coefficients of the leaf are not included.
const BYTES_PER_LEAF: u64 = 512;

/// Leaf of a patch: a nearly flat piece, which covers a rectangle of the parameters (u, v).
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchLeaf {
    /// Centre of the parameter rectangle, as (u, v).
    pub parameter_center: DVec2,
    /// Half widths of the parameter rectangle along u and along v.
    pub parameter_half_widths: DVec2,
    /// Position of the surface at the centre of the rectangle, in object space.
    pub center_point: DVec3,
    /// Constant and linear terms of the leaf's polynomial, and bounds on its higher terms.
    pub linear_terms: LinearTermsWithBounds,
}

/// Node of the subdivision tree of a patch, which finds the leaf that contains given parameters.
#[derive(Clone, Copy, Debug)]
pub(super) enum SubdivisionNode {
    /// A leaf, by its index in the list of leaves.
    Leaf(u32),
    /// An inner node, by the index of its [`SubdivisionCut`] in the list of cuts.
    Cut(u32),
}

/// Inner node of the subdivision tree: a piece divided into two.
#[derive(Clone, Copy, Debug)]
pub(super) struct SubdivisionCut {
    /// Number of the parameter whose range is divided: 0 for u, 1 for v.
    pub axis: usize,
    /// Value of this parameter at which its range is divided.
    pub split_value: f64,
    /// Subtrees for parameter values below `split_value`, and for values from `split_value` on.
    pub children: [SubdivisionNode; 2],
}

impl PatchLeaf {
    /// Converts the position `at` in this leaf, in \[−1, 1]², to the surface parameters (u, v).
    ///
    /// The rounded result is never in a neighbouring leaf.
    pub fn leaf_to_surface_uv(&self, at: DVec2) -> Vec2 {
        let (low, high) =
            (self.parameter_center - self.parameter_half_widths, self.parameter_center + self.parameter_half_widths);
        let round = |x: f64, low: f64, high: f64| {
            let x = x as f32;
            if f64::from(x) < low {
                x.next_up()
            } else if f64::from(x) >= high && high < 1.0 {
                x.next_down()
            } else {
                x
            }
        };
        let p = self.parameter_center + self.parameter_half_widths * at;
        Vec2::new(round(p.x, low.x, high.x), round(p.y, low.y, high.y))
    }
}

/// Divides Bézier patches into nearly flat pieces, called leaves, and collects them.
pub(super) struct PatchBuilder {
    /// Degrees along u and v.
    degree: [usize; 2],
    /// Memory limit of the surface \[bytes]; `None` is no limit.
    memory_limit: Option<u64>,
    pub leaves: Vec<PatchLeaf>,
    /// Polynomial coefficients of all leaves, one leaf after another; `PatchPiece` defines them.
    pub coefficients: Vec<Coefficient<4>>,
    /// Bounding box of each leaf in object space.
    pub boxes: Vec<BoxCorners>,
    /// Root of the subdivision tree of each Bézier patch.
    pub subdivision_roots: Vec<SubdivisionNode>,
    /// Inner nodes of all subdivision trees.
    pub cuts: Vec<SubdivisionCut>,
}

impl PatchBuilder {
    /// Builder without leaves for patches of the given degrees; `free` is the memory limit
    /// \[bytes].
    pub fn new(degree: [usize; 2], free: Option<u64>) -> Self {
        let (leaves, powers, boxes) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            degree,
            memory_limit: free,
            leaves,
            coefficients: powers,
            boxes,
            subdivision_roots: Vec::new(),
            cuts: Vec::new(),
        }
    }

    /// Divides a Bézier patch into leaves (nearly flat pieces), and adds them to the builder.
    ///
    /// The patch covers the intervals `ranges` of u and v of the whole surface.
    ///
    /// # Errors
    ///
    /// [`SplineError::MemoryLimitExceeded`] if the leaves exceed the memory limit.
    pub fn add_bezier_patch(&mut self, controls: &[Coefficient<4>], ranges: [[f64; 2]; 2]) -> Result<(), SplineError> {
        let [min, max] = control_point_bounds(controls);
        let root =
            self.subdivide_bezier_patch(controls, ranges, MIN_RELATIVE_SIZE * (max - min).length(), MAX_HALVINGS)?;
        self.subdivision_roots.push(root);
        Ok(())
    }

    /// Estimated memory of all leaves \[bytes]. A quarter is added for unused capacity of lists.
    pub fn memory_bytes(&self) -> u64 {
        let own =
            BYTES_PER_LEAF * self.leaves.len() as u64 + (size_of::<Coefficient<4>>() * self.coefficients.len()) as u64;
        own + own / 4
    }

    /// Divides a Bézier patch recursively into leaves (nearly flat pieces), adds them to the
    /// builder, and returns the subdivision tree.
    ///
    /// The patch covers the intervals `ranges` of u and v. A piece is not divided if it is smaller
    /// than `small` \[object-space length], or after `depth` halvings.
    fn subdivide_bezier_patch(
        &mut self,
        controls: &[Coefficient<4>],
        ranges: [[f64; 2]; 2],
        small: f64,
        depth: u32,
    ) -> Result<SubdivisionNode, SplineError> {
        let [p, q] = self.degree;
        let columns = q + 1;
        let mut powers = controls.to_vec();
        (0..=p).for_each(|i| bernstein_to_power_basis(&mut powers, i * columns, 1, q));
        (0..=q).for_each(|j| bernstein_to_power_basis(&mut powers, j, columns, p));
        let weight = powers[0][3];
        powers.iter_mut().flatten().for_each(|x| *x /= weight);
        let point = homogeneous_xyz(&powers[0]);
        for c in &mut powers {
            let seen = homogeneous_xyz(c) - point * c[3];
            *c = seen.extend(c[3]).to_array();
        }
        let corners = control_point_bounds(controls);
        let tiny = (corners[1] - corners[0]).length() <= small;
        if depth > 0
            && !tiny
            && let Some(axis) = axis_to_halve(&powers, columns)
            && ranges[axis][1] - ranges[axis][0] >= 2.0 * MIN_RELATIVE_KNOT_SPAN
        {
            let [start, end] = ranges[axis];
            let at = 0.5 * (start + end);
            let (first, last) = halve_control_net(controls, columns, axis);
            let part = |range: [f64; 2]| {
                let mut ranges = ranges;
                ranges[axis] = range;
                ranges
            };
            let index = self.cuts.len();
            let placeholder = SubdivisionNode::Leaf(0);
            self.cuts.push(SubdivisionCut { axis, split_value: at, children: [placeholder; 2] });
            let parts = [
                self.subdivide_bezier_patch(&first, part([start, at]), small, depth - 1)?,
                self.subdivide_bezier_patch(&last, part([at, end]), small, depth - 1)?,
            ];
            self.cuts[index].children = parts;
            return Ok(SubdivisionNode::Cut(index as u32));
        }
        let [[u0, u1], [v0, v1]] = ranges;
        self.leaves.push(PatchLeaf {
            parameter_center: 0.5 * DVec2::new(u0 + u1, v0 + v1),
            parameter_half_widths: 0.5 * DVec2::new(u1 - u0, v1 - v0),
            center_point: point,
            linear_terms: LinearTermsWithBounds::from_coefficients(&powers, columns),
        });
        self.coefficients.extend(powers);
        self.boxes.push(corners);
        let needed = self.memory_bytes();
        match self.memory_limit {
            Some(free) if needed > free => Err(SplineError::MemoryLimitExceeded { needed, free }),
            _ => Ok(SubdivisionNode::Leaf(self.leaves.len() as u32 - 1)),
        }
    }
}

/// Vector w·(x, y, z), the first three components of a homogeneous coefficient (w·x, w·y, w·z, w).
fn homogeneous_xyz(c: &Coefficient<4>) -> DVec3 {
    DVec3::new(c[0], c[1], c[2])
}

/// Axis-aligned bounding box of the control points, which are given in homogeneous coordinates.
fn control_point_bounds(controls: &[Coefficient<4>]) -> BoxCorners {
    let points = controls.iter().map(|c| homogeneous_xyz(c) / c[3]);
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], p| [min.min(p), max.max(p)])
}

/// Parameter along which to halve a piece: 0 for u, 1 for v; `None` if the piece is flat enough.
///
/// `a` are the polynomial coefficients of the piece. For each power of the first parameter, there
/// are `columns` of them.
fn axis_to_halve(a: &[Coefficient<4>], columns: usize) -> Option<usize> {
    let (along_x, along_y) = (homogeneous_xyz(&a[columns]), homogeneous_xyz(&a[1]));
    let normal = along_x.cross(along_y);
    let mut turns = [DVec3::ZERO; 2];
    for (i, row) in a.chunks_exact(columns).enumerate() {
        for (j, c) in row.iter().enumerate().filter(|(j, _)| i + j >= 2) {
            let size = homogeneous_xyz(c).abs();
            turns[0] += size * i as f64;
            turns[1] += size * j as f64;
        }
    }
    // `for_x` and `for_y` are the rows of the inverse Jacobian times |normal|², by absolute value.
    // The Jacobian has the columns `along_x`, `along_y` and the unit normal.
    let length = normal.length();
    let (for_x, for_y) = (along_y.cross(normal).abs(), normal.cross(along_x).abs());
    let turn = turns[0] + turns[1];
    if for_x.dot(turn).max(for_y.dot(turn)) <= MAX_RELATIVE_BEND * length * length && length > 0.0 {
        return None;
    }
    let [x, y] = turns.map(DVec3::length);
    let longer = usize::from(along_y.length() > along_x.length());
    Some(if x > 1.5 * y {
        0
    } else if y > 1.5 * x {
        1
    } else {
        longer
    })
}

/// Divides a Bézier patch at the middle of u (`axis` 0) or v (`axis` 1); returns both control nets.
fn halve_control_net(
    controls: &[Coefficient<4>],
    columns: usize,
    axis: usize,
) -> (Vec<Coefficient<4>>, Vec<Coefficient<4>>) {
    let (mut first, mut last) = (controls.to_vec(), controls.to_vec());
    let rows = controls.len() / columns;
    let (lines, stride) = if axis == 0 { (columns, columns) } else { (rows, 1) };
    for i in 0..lines {
        let start = if axis == 0 { i } else { i * columns };
        let count = if axis == 0 { rows } else { columns };
        let line: Vec<Coefficient<4>> = (0..count).map(|k| controls[start + k * stride]).collect();
        let (a, b) = split_bezier(&line, 0.5);
        for (k, (a, b)) in a.into_iter().zip(b).enumerate() {
            (first[start + k * stride], last[start + k * stride]) = (a, b);
        }
    }
    (first, last)
}
