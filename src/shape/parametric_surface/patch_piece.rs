//! Nearly flat pieces of rational surfaces, and their intersection with lines.

use super::box_bvh::Line;
use super::polynomial::{Coefficient, MAX_DEGREE, evaluate_2d_with_derivatives, reparametrize, reparametrize_rows};
use super::root_finding::{
    MAX_DERIVATIVE_CHANGE, MAX_FIRST_NEWTON_STEP, NEWTON_CONVERGENCE_RATE, PIECE_OVERLAP, RootClassification,
    TANGENT_HIT_RELATIVE_SIZE,
};
use glam::{DVec2, DVec3};

/// Nearly flat piece of a rational surface, with parameters x and y in \[−1, 1].
///
/// Let p be the surface point at (x, y), w its weight, and c the centre of the piece, where w is 1.
/// Polynomials in x and y give w·(p − c) and w.
#[derive(Clone, Copy, Debug)]
pub struct PatchPiece<'a> {
    /// Coefficients of xⁱyʲ for the four components of (w·(p − c), w); j varies fastest.
    pub coefficients: &'a [Coefficient<4>],
    /// Object-space position of the piece's centre.
    pub center_point: DVec3,
    /// Number of coefficients per power of x: the degree in y plus 1.
    pub columns: usize,
    /// Constant and linear terms of `coefficients`, and bounds on the higher terms.
    pub linear_terms: LinearTermsWithBounds,
    /// Upper bound on the rounding error of a point that is computed from the polynomials
    /// \[object-space length].
    pub point_error_bound: f64,
}

/// Constant and linear terms of a polynomial, and bounds on its higher terms.
#[derive(Clone, Copy, Debug)]
pub struct LinearTermsWithBounds {
    /// Coefficients of the constant term, the term in y, and the term in x.
    linear: [Coefficient<4>; 3],
    /// Bound on the sum of the terms aᵢⱼ xⁱ yʲ with i + j ≥ 2, for x and y in \[−1, 1]: Σ |aᵢⱼ|.
    higher_term_bounds: Coefficient<4>,
    /// Bound on the change of the first derivatives from the centre of the piece to any other
    /// point: Σ (i + j)|aᵢⱼ| over the terms with i + j ≥ 2.
    derivative_change_bounds: Coefficient<4>,
}

impl LinearTermsWithBounds {
    /// Collects the terms and bounds of the polynomial `a` with `columns` coefficients per power of
    /// x.
    #[inline]
    pub fn from_coefficients(a: &[Coefficient<4>], columns: usize) -> Self {
        let mut bounds =
            Self { linear: [a[0], a[1], a[columns]], higher_term_bounds: [0.0; 4], derivative_change_bounds: [0.0; 4] };
        for (i, row) in a.chunks_exact(columns).enumerate() {
            for (j, c) in row.iter().enumerate().skip(2usize.saturating_sub(i)) {
                for (k, c) in c.iter().enumerate() {
                    bounds.higher_term_bounds[k] += c.abs();
                    bounds.derivative_change_bounds[k] += (i + j) as f64 * c.abs();
                }
            }
        }
        bounds
    }

    /// Bound on each component of |w·(p − base)|, for a surface point p of weight w. `sums` holds
    /// bounds on the components of |w·p| and on w.
    #[inline]
    fn weighted_offset_bound(sums: &Coefficient<4>, base: DVec3) -> DVec3 {
        split_homogeneous(sums).0 + base.abs() * sums[3]
    }
}

/// Splits homogeneous coordinates (w·p, w) into w·p and w.
#[inline]
fn split_homogeneous(a: &Coefficient<4>) -> (DVec3, f64) {
    (DVec3::new(a[0], a[1], a[2]), a[3])
}

/// Converts homogeneous coordinates (w·p, w) to w·(p − base). The conversion is linear, so it also
/// applies to derivatives.
#[inline]
fn weighted_offset_from_base(a: &Coefficient<4>, base: DVec3) -> DVec3 {
    let (p, w) = split_homogeneous(a);
    p - base * w
}

impl PatchPiece<'_> {
    /// Parameters (x, y) of the nearest hit of `line`; `None` if the line misses the piece.
    ///
    /// Only hits within `range`, an interval of arc length τ, count. Moves the end of `range` to
    /// the hit. `size` is the size of the whole surface \[object-space length].
    #[inline]
    pub fn nearest_hit(&self, line: &Line, range: &mut [f64; 2], size: f64) -> Option<DVec2> {
        // Bounds on the change of weights grow with the distance of the line's base, so the base is
        // moved near the piece.
        let (near, start) = self.line_relative_to_center(line);
        let mut own = range.map(|t| t - start);
        let found =
            match classify_roots(self.coefficients, self.columns, &self.linear_terms, &near, self.point_error_bound) {
                RootClassification::NoRoot => None,
                RootClassification::Root(at, t) => (own[0] <= t && t <= own[1]).then(|| {
                    own[1] = t;
                    at
                }),
                _ => match self.coefficients.len() {
                    ..=16 => self.nearest_hit_by_bisection::<16>(&near, &mut own, size),
                    17..=64 => self.nearest_hit_by_bisection::<64>(&near, &mut own, size),
                    _ => {
                        self.nearest_hit_by_bisection::<{ (MAX_DEGREE + 1) * (MAX_DEGREE + 1) }>(&near, &mut own, size)
                    }
                },
            }?;
        range[1] = own[1] + start;
        Some(found)
    }

    /// The line relative to the piece's centre, with its base moved to the point nearest to the
    /// centre.
    ///
    /// Also returns the arc length τ of the new base on the given line.
    #[inline]
    fn line_relative_to_center(&self, line: &Line) -> (Line, f64) {
        let start = (self.center_point - line.base).dot(line.direction);
        (Line { base: line.base + line.direction * start - self.center_point, ..*line }, start)
    }

    /// Change of the parameters `at` = (x, y) by one Newton step towards the intersection with
    /// `line`.
    pub fn newton_step_at(&self, line: &Line, at: DVec2) -> DVec2 {
        newton_step(self.coefficients, self.columns, &self.line_relative_to_center(line).0, at).0
    }

    /// Object-space point at the parameters (x, y) = `at`, and its derivatives with respect to x
    /// and y.
    #[inline]
    pub fn point_and_derivatives(&self, at: DVec2) -> [DVec3; 3] {
        let [value, along_x, along_y] = evaluate_2d_with_derivatives(self.coefficients, self.columns, at.x, at.y);
        let (p, w) = split_homogeneous(&value);
        let p = p / w;
        [p + self.center_point, weighted_offset_from_base(&along_x, p) / w, weighted_offset_from_base(&along_y, p) / w]
    }

    /// Parameters (x, y) of the nearest hit within `range`, by recursive halving of the parameter
    /// box.
    ///
    /// Moves the end of `range` to the hit. Boxes are halved along their longer side. Halving ends
    /// when a box has no root, one root, or the size of a rounding error. `ROOM` is at least the
    /// number of coefficients.
    #[cold]
    #[inline(never)]
    fn nearest_hit_by_bisection<const ROOM: usize>(
        &self,
        line: &Line,
        range: &mut [f64; 2],
        size: f64,
    ) -> Option<DVec2> {
        let columns = self.columns;
        let mut boxes = [(DVec2::ZERO, DVec2::ZERO); 128];
        boxes[0] = (DVec2::ZERO, DVec2::ONE);
        let mut count = 1;
        let mut found = None;
        let mut own = [[0.0; 4]; ROOM];
        let a = &mut own[..self.coefficients.len()];
        while count > 0 {
            count -= 1;
            let (middle, half) = boxes[count];
            a.copy_from_slice(self.coefficients);
            if half.x < 1.0 {
                reparametrize_rows(a, columns, middle.x, half.x);
            }
            if half.y < 1.0 {
                a.chunks_exact_mut(columns).for_each(|row| reparametrize(row, middle.y, half.y));
            }
            let bounds = LinearTermsWithBounds::from_coefficients(a, columns);
            let Some(reach) = self.half_extent_if_hit(&bounds, line, *range) else { continue };
            let point = || DVec2::new(middle.x, middle.y);
            let touched = match classify_roots(a, columns, &bounds, line, self.point_error_bound) {
                RootClassification::NoRoot => None,
                RootClassification::Root(at, t) => Some((middle + half * at, t)),
                _ if reach.max_element() <= 4.0 * self.point_error_bound => {
                    Some((point(), tau_nearest_to_center(a, line)))
                }
                RootClassification::LineInSurface if reach.max_element() <= TANGENT_HIT_RELATIVE_SIZE * size => {
                    Some((point(), tau_nearest_to_center(a, line)))
                }
                RootClassification::LineInSurface => None,
                // A hundred halvings shrink a box to the size of rounding errors, and the stack has
                // room for them. If the stack is full, the box counts as missed.
                RootClassification::Unclear if count + 2 <= boxes.len() => {
                    let side = if is_longer_in_x(a, columns) { DVec2::X } else { DVec2::Y };
                    let (step, rest) = (0.5 * half * side, half * (1.0 - 0.5 * side));
                    boxes[count] = (middle + step, rest);
                    boxes[count + 1] = (middle - step, rest);
                    count += 2;
                    None
                }
                RootClassification::Unclear => None,
            };
            if let Some((at, t)) = touched
                && range[0] <= t
                && t <= range[1]
            {
                range[1] = t;
                found = Some(at);
            }
        }
        found
    }

    /// Halves of the edge lengths of a box around the vectors w·(p − base); `None` if `line` misses
    /// this box.
    ///
    /// p is a point of the piece, w its weight, and base is `line.base`. `bounds` are those of the
    /// piece's polynomial. A hit counts only if its arc length τ on `line` is in `range`.
    fn half_extent_if_hit(&self, bounds: &LinearTermsWithBounds, line: &Line, range: [f64; 2]) -> Option<DVec3> {
        let [middle, along_y, along_x] = bounds.linear.map(|a| weighted_offset_from_base(&a, line.base));
        let reach = along_x.abs()
            + along_y.abs()
            + LinearTermsWithBounds::weighted_offset_bound(&bounds.higher_term_bounds, line.base)
            + self.point_error_bound;
        let (a1, a2) = ((middle - reach) * line.reciprocal_direction, (middle + reach) * line.reciprocal_direction);
        let (lo, hi) = (a1.min(a2).max_element(), a1.max(a2).min_element());
        // `lo` and `hi` bound w·τ, where w is the weight, which is positive and close to its value
        // at the centre. They are divided by the largest or smallest w to bound τ.
        let [w, along_y, along_x] = bounds.linear.map(|a| a[3]);
        let spread = along_x.abs() + along_y.abs() + bounds.higher_term_bounds[3];
        let (least, most) = ((w - spread).max(0.0), w + spread);
        let at_least = if lo > 0.0 { lo / most } else { lo / least };
        let at_most = if hi > 0.0 { hi / least } else { hi / most };
        (lo <= hi && !(at_least > range[1] || at_most < range[0])).then_some(reach)
    }
}

/// Arc length τ of the point of `line` that is nearest to the centre of the piece `a`.
fn tau_nearest_to_center(a: &[Coefficient<4>], line: &Line) -> f64 {
    weighted_offset_from_base(&a[0], line.base).dot(line.direction) / a[0][3]
}

/// True if the piece extends farther along its parameter x than along y.
fn is_longer_in_x(a: &[Coefficient<4>], columns: usize) -> bool {
    let (mut x, mut y) = (DVec3::ZERO, DVec3::ZERO);
    for (i, row) in a.chunks_exact(columns).enumerate() {
        for (j, c) in row.iter().enumerate() {
            let size = split_homogeneous(c).0.abs();
            x += if i > 0 { size } else { DVec3::ZERO };
            y += if j > 0 { size } else { DVec3::ZERO };
        }
    }
    x.max_element() > y.max_element()
}

/// Tests whether `line` intersects the piece with the coefficients `a` at x, y in \[−1, 1].
///
/// `bounds` are the linear terms and bounds of `a`. `noise` bounds the rounding error of points
/// computed from `a`.
#[inline]
fn classify_roots(
    a: &[Coefficient<4>],
    columns: usize,
    bounds: &LinearTermsWithBounds,
    line: &Line,
    noise: f64,
) -> RootClassification<DVec2> {
    let d = line.direction;
    let [miss, along_y, along_x] = bounds.linear.map(|a| weighted_offset_from_base(&a, line.base));
    let determinant = d.dot(along_x.cross(along_y));
    let least = determinant.abs();
    // A Newton step changes x by for_x · miss / determinant, and y by for_y · miss / determinant.
    let (for_x, for_y) = (d.cross(along_y), along_x.cross(d));
    let (size_x, size_y) = (for_x.abs(), for_y.abs());
    let (x, y) = (for_x.dot(miss), for_y.dot(miss));
    let error = LinearTermsWithBounds::weighted_offset_bound(&bounds.higher_term_bounds, line.base) + noise;
    if x.abs() > least + size_x.dot(error) || y.abs() > least + size_y.dot(error) {
        return RootClassification::NoRoot;
    }
    let turn = LinearTermsWithBounds::weighted_offset_bound(&bounds.derivative_change_bounds, line.base);
    let (turn_x, turn_y) = (size_x.dot(turn), size_y.dot(turn));
    if turn_x.max(turn_y) < MAX_DERIVATIVE_CHANGE * least {
        let blur = noise * size_x.element_sum().max(size_y.element_sum()) / least;
        let start = DVec2::new(x, y) / determinant;
        return newton_root(a, columns, line, start, PIECE_OVERLAP + 4.0 * blur)
            .map_or(RootClassification::NoRoot, |(at, t)| RootClassification::Root(at, t));
    }
    let blur = (size_x.element_sum() + size_y.element_sum()) * noise;
    if least + turn_x + turn_y <= blur { RootClassification::LineInSurface } else { RootClassification::Unclear }
}

/// Newton step from the parameters `at` towards the intersection of the piece `a` with `line`.
///
/// Also returns the arc length τ on the line after the step.
#[inline]
fn newton_step(a: &[Coefficient<4>], columns: usize, line: &Line, at: DVec2) -> (DVec2, f64) {
    let values = evaluate_2d_with_derivatives(a, columns, at.x, at.y);
    let [miss, along_x, along_y] = values.map(|v| weighted_offset_from_base(&v, line.base));
    let d = line.direction;
    let determinant = d.dot(along_x.cross(along_y));
    let step = DVec2::new(d.cross(along_y).dot(miss), along_x.cross(d).dot(miss)) / determinant;
    let w = values[0][3] + step.x * values[1][3] + step.y * values[2][3];
    (step, (miss + along_x * step.x + along_y * step.y).dot(d) / w)
}

/// Parameters (x, y) and arc length τ of the only possible hit, by Newton's method from `start`.
///
/// `None` if there is no hit. If there is one, the steps shrink at least by the factor
/// [`NEWTON_CONVERGENCE_RATE`]. Slower convergence therefore means that there is none.
fn newton_root(
    a: &[Coefficient<4>],
    columns: usize,
    line: &Line,
    start: DVec2,
    tolerance: f64,
) -> Option<(DVec2, f64)> {
    let mut at = start.clamp(DVec2::NEG_ONE, DVec2::ONE);
    let mut longest = MAX_FIRST_NEWTON_STEP;
    loop {
        let (step, t) = newton_step(a, columns, line, at);
        let size = step.abs().max_element();
        if size.is_nan() || size > longest.max(tolerance) {
            return None;
        }
        longest *= NEWTON_CONVERGENCE_RATE;
        let next = (at + step).clamp(DVec2::NEG_ONE, DVec2::ONE);
        let moved = (next - at).abs().max_element();
        at = next;
        if size <= tolerance {
            return Some((at, t));
        }
        if moved <= 0.01 * tolerance {
            return None;
        }
    }
}
