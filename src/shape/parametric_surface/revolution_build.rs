//! Subdivision of profile curves into nearly straight pieces, each on one side of the axis.

use super::polynomial::{Coefficient, bernstein_to_power_basis, split_bezier};
use super::ring_bvh::RingBounds;
use super::spline::{MIN_RELATIVE_KNOT_SPAN, SplineError};
use libm::hypot;

/// Limit of the change of the derivative over a piece, relative to the derivative. A piece below
/// this limit counts as nearly straight, and is not divided further unless it crosses the axis.
const MAX_RELATIVE_BEND: f64 = 1.0 / 16.0;

/// Maximum number of nested halvings of a Bézier curve.
///
/// The maximum is reached at cusps and coincident control points, which never become straight.
pub(super) const MAX_HALVINGS: u32 = 9;

/// Memory of a leaf, a nearly straight piece of a profile curve \[bytes]. The bounding ring of the
/// leaf, and its nodes in the bounding volume hierarchy, are included.
///
/// The polynomial coefficients of the leaf are not included.
const BYTES_PER_LEAF: u64 = 256;

/// Leaf of a profile curve: a nearly straight piece on one side of the axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProfileLeaf {
    /// Index of the leaf's first coefficient in the list of all polynomial coefficients.
    pub first_coefficient: u32,
    /// Sign of the profile's x on this leaf, 1 or −1: the side of the axis on which the leaf lies.
    pub side_sign: f64,
    /// Centre of the leaf's interval of the profile parameter.
    pub parameter_center: f64,
    /// Half the width of the leaf's interval of the profile parameter.
    pub parameter_half_width: f64,
    /// Ring around the y axis that contains the leaf.
    pub ring: RingBounds,
}

/// Divides a profile curve into nearly straight pieces, called leaves, and collects them.
pub(super) struct ProfileBuilder {
    /// Leaves in the order of the profile parameter.
    pub leaves: Vec<ProfileLeaf>,
    /// Polynomial coefficients (radius, height) of all leaves, one leaf after another.
    pub coefficients: Vec<Coefficient<2>>,
    /// Memory limit of the surface \[bytes]; `None` is no limit.
    pub memory_limit: Option<u64>,
}

impl ProfileBuilder {
    /// Divides a Bézier curve recursively into leaves, and adds them to the builder.
    ///
    /// A leaf is a piece that is nearly straight and on one side of the axis, or that may not be
    /// halved further. `controls` are points (x, y). The curve covers the profile parameters from
    /// `start` to `end`. `depth` is the number of halvings that are still allowed. A piece that
    /// lies on the axis or in one point sweeps no area and is left out.
    ///
    /// # Errors
    ///
    /// [`SplineError::MemoryLimitExceeded`] if the leaves exceed the memory limit.
    pub fn subdivide_bezier_curve(
        &mut self,
        controls: &[Coefficient<2>],
        [start, end]: [f64; 2],
        depth: u32,
    ) -> Result<(), SplineError> {
        let (left, right) =
            controls.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, r), c| (l.min(c[0]), r.max(c[0])));
        let (low, high) =
            controls.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, r), c| (l.min(c[1]), r.max(c[1])));
        if left == 0.0 && right == 0.0 || left == right && low == high {
            return Ok(());
        }
        let side = if -left > right { -1.0 } else { 1.0 };
        let degree = controls.len() - 1;
        let mut powers: Vec<Coefficient<2>> = controls.iter().map(|c| [side * c[0], c[1]]).collect();
        bernstein_to_power_basis(&mut powers, 0, 1, degree);
        let crosses = left < 0.0 && right > 0.0;
        let bends = powers.iter().enumerate().skip(2).fold(0.0, |s, (k, c)| s + k as f64 * hypot(c[0], c[1]));
        let wide = end - start >= 2.0 * MIN_RELATIVE_KNOT_SPAN;
        if depth > 0 && wide && (crosses || bends > MAX_RELATIVE_BEND * hypot(powers[1][0], powers[1][1])) {
            let at = axis_crossing_parameter(controls).filter(|_| crosses).unwrap_or(0.5);
            let (mut first, mut last) = split_bezier(controls, at);
            if crosses && at != 0.5 {
                // The crossing parameter is rounded. The common control point of both halves must
                // lie exactly on the axis.
                (first[degree][0], last[0][0]) = (0.0, 0.0);
            }
            let middle = start + at * (end - start);
            self.subdivide_bezier_curve(&first, [start, middle], depth - 1)?;
            return self.subdivide_bezier_curve(&last, [middle, end], depth - 1);
        }
        let radius = if side < 0.0 { [-right, -left] } else { [left, right] };
        self.leaves.push(ProfileLeaf {
            first_coefficient: self.coefficients.len() as u32,
            side_sign: side,
            parameter_center: 0.5 * (start + end),
            parameter_half_width: 0.5 * (end - start),
            ring: RingBounds { radius, height: [low, high] },
        });
        self.coefficients.extend(powers);
        // The factor 2 covers the unused capacity of growing lists.
        let needed = 2
            * (BYTES_PER_LEAF * self.leaves.len() as u64
                + (size_of::<Coefficient<2>>() * self.coefficients.len()) as u64);
        match self.memory_limit {
            Some(free) if needed > free => Err(SplineError::MemoryLimitExceeded { needed, free }),
            _ => Ok(()),
        }
    }
}

/// Parameter in (0, 1) at which a Bézier curve crosses the axis x = 0.
///
/// `None` unless the x coordinates of the curve's control points change sign exactly once. Also
/// `None` if the first control point lies on the axis.
fn axis_crossing_parameter(controls: &[Coefficient<2>]) -> Option<f64> {
    let sides: Vec<bool> = controls.iter().map(|c| c[0]).filter(|x| *x != 0.0).map(|x| x > 0.0).collect();
    let [first, .., _] = sides[..] else { return None };
    if sides.windows(2).filter(|w| w[0] != w[1]).count() != 1 || controls[0][0] == 0.0 {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while let middle = 0.5 * (low + high)
        && low < middle
        && middle < high
    {
        let x = split_bezier(controls, middle).1[0][0];
        *(if (x > 0.0) == first { &mut low } else { &mut high }) = middle;
    }
    (0.0 < low && low < 1.0).then_some(low)
}
