//! B-spline bases, and the Bézier pieces of B-spline curves.

use super::polynomial::{Coefficient, MAX_DEGREE};
use crate::stats::format_bytes;

/// Error: control points and knots define no curve or surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SplineError {
    /// The degree is 0, or above [`MAX_DEGREE`].
    #[error("the degree is {0}, and must be from 1 to {MAX_DEGREE}")]
    InvalidDegree(usize),
    /// The curve has too few control points: degree p needs at least p + 1.
    #[error("{controls} control points are too few for degree {degree}: at least {} are needed", degree + 1)]
    TooFewControlPoints {
        /// Number of control points.
        controls: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// The number of knots is not the number of control points plus the degree plus 1.
    #[error("{knots} knots do not fit {controls} control points of degree {degree}: {} are needed", controls + degree + 1)]
    WrongKnotCount {
        /// Number of knots.
        knots: usize,
        /// Number of control points.
        controls: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// The knot with this index is less than the knot before it.
    #[error("knot {0} (counted from 0) is less than the one before it")]
    DecreasingKnots(usize),
    /// The range of the curve is empty: its first and last knot are equal, or differ by a subnormal
    /// number.
    #[error("the range of the curve, from knot {first} to knot {last} (counted from 0), has no length")]
    EmptyKnotRange {
        /// Index of the first knot of the curve's range.
        first: usize,
        /// Index of the last knot of the curve's range.
        last: usize,
    },
    /// The knot span that begins at the knot with this index is too short for f32 parameters.
    #[error("the stretch that begins at knot {0} (counted from 0) is shorter than 1/4194304 of the curve's range")]
    NarrowKnotSpan(usize),
    /// The number of control points is not the product of rows and columns.
    #[error("{controls} control points do not make a net of {rows} × {columns}")]
    WrongNetSize {
        /// Number of control points.
        controls: usize,
        /// Number of rows, along u.
        rows: usize,
        /// Number of columns, along v.
        columns: usize,
    },
    /// The weight of the control point with this index is not above 0.
    #[error("the weight of control point {0} (counted from 0) is not above 0")]
    NonPositiveWeight(usize),
    /// The absolute value of a coordinate, weight or knot is not below 10¹⁰⁰.
    #[error("a control point or knot is too large")]
    TooLarge,
    /// The surface takes more memory than its limit.
    #[error("the surface takes {} of memory or more, and {} are free", format_bytes(*needed), format_bytes(*free))]
    MemoryLimitExceeded {
        /// Bytes needed when construction stopped. The whole surface needs this many or more.
        needed: u64,
        /// Memory limit in bytes.
        free: u64,
    },
    /// The whole surface lies in a line or a point.
    #[error("the surface has no area")]
    NoArea,
}

/// Length of the shortest accepted knot span, relative to the range of the curve.
///
/// f32 parameters near 1 are 2⁻²⁴ apart, and each span needs several distinct values.
pub(super) const MIN_RELATIVE_KNOT_SPAN: f64 = 1.0 / 4_194_304.0;

/// B-spline basis: the degree and the knots along one parameter, checked for consistency.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineBasis {
    degree: usize,
    control_count: usize,
    knots: Vec<f64>,
}

/// Interval between two consecutive, different knots.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnotSpan {
    /// Index of the knot at the start of the span.
    start_knot_index: usize,
    /// Start and end of the span, as fractions in \[0, 1] of the whole curve's range.
    pub range: [f64; 2],
}

impl SplineBasis {
    /// Basis of a single Bézier curve with `controls` control points.
    ///
    /// # Errors
    ///
    /// [`SplineError::InvalidDegree`] for fewer than 2 or too many control points.
    pub fn bezier_basis(controls: usize) -> Result<Self, SplineError> {
        let degree = controls.saturating_sub(1);
        let knots = [0.0, 1.0].into_iter().flat_map(|k| std::iter::repeat_n(k, controls.min(MAX_DEGREE + 1))).collect();
        validate_degree(degree)?;
        Ok(Self { degree, control_count: controls, knots })
    }

    /// Uniform basis with the knots i/(n + p), for n control points and degree p.
    ///
    /// The curve is unclamped: it does not reach its first and last control points.
    ///
    /// # Errors
    ///
    /// [`SplineError`] if the degree is invalid, if there are too few control points for the
    /// degree, or so many that knot spans are too narrow.
    pub fn uniform_spline_basis(degree: usize, controls: usize) -> Result<Self, SplineError> {
        validate_degree(degree)?;
        let last = controls + degree;
        Self::new(degree, controls, (0..=last).map(|i| i as f64 / last as f64).collect())
    }

    /// Basis for n = `controls` control points of degree p = `degree`, with non-decreasing `knots`.
    ///
    /// The curve ranges from knot p to knot n, counted from 0.
    ///
    /// # Errors
    ///
    /// [`SplineError`] if degree, number of control points and knots are inconsistent.
    pub fn new(degree: usize, controls: usize, knots: Vec<f64>) -> Result<Self, SplineError> {
        validate_degree(degree)?;
        if controls <= degree {
            return Err(SplineError::TooFewControlPoints { controls, degree });
        }
        if knots.len() != controls + degree + 1 {
            return Err(SplineError::WrongKnotCount { knots: knots.len(), controls, degree });
        }
        if !knots.iter().all(|k| k.abs() < 1e100) {
            return Err(SplineError::TooLarge);
        }
        if let Some(i) = knots.windows(2).position(|w| w[1] < w[0]) {
            return Err(SplineError::DecreasingKnots(i + 1));
        }
        let range = knots[controls] - knots[degree];
        if !range.is_normal() {
            return Err(SplineError::EmptyKnotRange { first: degree, last: controls });
        }
        let basis = Self { degree, control_count: controls, knots };
        let narrow = basis.knot_spans().find(|span| span.range[1] - span.range[0] < MIN_RELATIVE_KNOT_SPAN);
        narrow.map_or(Ok(()), |span| Err(SplineError::NarrowKnotSpan(span.start_knot_index)))?;
        Ok(basis)
    }

    /// Polynomial degree of each piece.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of control points.
    #[must_use]
    pub fn control_count(&self) -> usize {
        self.control_count
    }

    /// Knot spans with a length above 0, ascending.
    pub(super) fn knot_spans(&self) -> impl Iterator<Item = KnotSpan> {
        let (first, last) = (self.knots[self.degree], self.knots[self.control_count]);
        let place = move |knot: f64| (knot - first) / (last - first);
        (self.degree..self.control_count)
            .filter(|k| self.knots[*k] < self.knots[k + 1])
            .map(move |k| KnotSpan { start_knot_index: k, range: [place(self.knots[k]), place(self.knots[k + 1])] })
    }

    /// Bézier control points of the curve over one knot span.
    ///
    /// The control points of the curve are `controls[first]`, `controls[first + stride]`, … So the
    /// curve may also be a row or column of a surface's control net. For degree p, result j is the
    /// polar form (blossom) of the curve with j arguments at the end knot of the span and p − j at
    /// its start knot (Ramshaw 1989). Each step is a weighted mean, so digits do not cancel.
    pub(super) fn bezier_control_points<const N: usize>(
        &self,
        span: KnotSpan,
        controls: &[Coefficient<N>],
        (first, stride): (usize, usize),
    ) -> Vec<Coefficient<N>> {
        let (p, k) = (self.degree, span.start_knot_index);
        let polar = |j: usize| {
            let mut points: Vec<Coefficient<N>> = (0..=p).map(|i| controls[first + (k - p + i) * stride]).collect();
            for r in 1..=p {
                let at = if r <= j { self.knots[k + 1] } else { self.knots[k] };
                for i in (r..=p).rev() {
                    let (start, end) = (self.knots[k - p + i], self.knots[k + 1 + i - r]);
                    let (before, after) = ((end - at) / (end - start), (at - start) / (end - start));
                    points[i] = std::array::from_fn(|c| before * points[i - 1][c] + after * points[i][c]);
                }
            }
            points[p]
        };
        (0..=p).map(polar).collect()
    }
}

/// Checks that a degree is from 1 to [`MAX_DEGREE`].
fn validate_degree(degree: usize) -> Result<(), SplineError> {
    if (1..=MAX_DEGREE).contains(&degree) { Ok(()) } else { Err(SplineError::InvalidDegree(degree)) }
}

#[cfg(test)]
mod tests;
