//! Bézier and B-spline curves and nets of control points, and their Bézier pieces.

use super::polynomial::{Coefficients, MAX_DEGREE};
use crate::stats::format_bytes;

/// Reason why control points and knots define no curve or surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SplineError {
    /// The degree is 0, or above [`MAX_DEGREE`].
    #[error("the degree is {0}, and must be from 1 to {MAX_DEGREE}")]
    Degree(usize),
    /// The curve has too few control points: degree p needs more than p.
    #[error("{controls} control points are too few for degree {degree}: at least {} are needed", degree + 1)]
    Controls {
        /// Number of control points.
        controls: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// The number of knots is not the number of control points plus the degree plus 1.
    #[error("{knots} knots do not fit {controls} control points of degree {degree}: {} are needed", controls + degree + 1)]
    Knots {
        /// Number of knots.
        knots: usize,
        /// Number of control points.
        controls: usize,
        /// Degree of the curve.
        degree: usize,
    },
    /// This knot, counted from 0, is less than the knot before it.
    #[error("knot {0} (counted from 0) is less than the one before it")]
    Decreasing(usize),
    /// The first and the last knot of the curve's range are equal.
    #[error("the range of the curve, from knot {first} to knot {last} (counted from 0), has no length")]
    NoRange {
        /// Index of the first knot of the range.
        first: usize,
        /// Index of the last knot of the range.
        last: usize,
    },
    /// The span that begins at this knot, counted from 0, is too short for single precision.
    #[error("the stretch that begins at knot {0} (counted from 0) is shorter than 1/4194304 of the curve's range")]
    Narrow(usize),
    /// The number of control points does not make a net.
    #[error("{controls} control points do not make a net of {rows} × {columns}")]
    Net {
        /// Number of control points.
        controls: usize,
        /// Number of rows, along u.
        rows: usize,
        /// Number of columns, along v.
        columns: usize,
    },
    /// The weight of this control point, counted from 0, is not above 0.
    #[error("the weight of control point {0} (counted from 0) is not above 0")]
    Weight(usize),
    /// A coordinate, weight or knot is not finite, or its square is not.
    #[error("a control point or knot is too large")]
    TooLarge,
    /// The surface takes more memory than is free.
    #[error("the surface takes {} of memory or more, and {} are free", format_bytes(*needed), format_bytes(*free))]
    Memory {
        /// Bytes in use when the limit was exceeded.
        needed: u64,
        /// Bytes that the surface may take.
        free: u64,
    },
    /// The whole surface lies in a line or a point.
    #[error("the surface has no area")]
    NoArea,
}

/// Shortest span relative to the range.
///
/// Single-precision coordinates below 1 are 2⁻²⁴ apart, and each span needs several of them.
pub(super) const MIN_SPAN: f64 = 1.0 / 4_194_304.0;

/// Checked degree and knots of one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineBasis {
    degree: usize,
    controls: usize,
    knots: Vec<f64>,
}

/// Interval between two different knots.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnotSpan {
    /// Index of the knot at its start.
    knot: usize,
    /// Position within the curve's range, which is \[0, 1].
    pub range: [f64; 2],
}

impl SplineBasis {
    /// A single Bézier curve with `controls` control points.
    ///
    /// # Errors
    ///
    /// [`SplineError::Degree`] for fewer than 2 or too many control points.
    pub fn bezier(controls: usize) -> Result<Self, SplineError> {
        let degree = controls.saturating_sub(1);
        let knots = [0.0, 1.0].into_iter().flat_map(|k| std::iter::repeat_n(k, controls.min(MAX_DEGREE + 1))).collect();
        check_degree(degree)?;
        Ok(Self { degree, controls, knots })
    }

    /// A uniform, unclamped B-spline with knots i/(n + p); it does not reach its first and last
    /// control point.
    ///
    /// # Errors
    ///
    /// [`SplineError`] if degree and number do not fit.
    pub fn uniform_knots(degree: usize, controls: usize) -> Result<Self, SplineError> {
        check_degree(degree)?;
        let last = controls + degree;
        Self::new(degree, controls, (0..=last).map(|i| i as f64 / last as f64).collect())
    }

    /// A B-spline with non-decreasing knots; its range is from knot p to knot n, counted from 0.
    ///
    /// # Errors
    ///
    /// [`SplineError`] if degree, numbers and knots do not fit.
    pub fn new(degree: usize, controls: usize, knots: Vec<f64>) -> Result<Self, SplineError> {
        check_degree(degree)?;
        if controls <= degree {
            return Err(SplineError::Controls { controls, degree });
        }
        if knots.len() != controls + degree + 1 {
            return Err(SplineError::Knots { knots: knots.len(), controls, degree });
        }
        if !knots.iter().all(|k| k.abs() < 1e100) {
            return Err(SplineError::TooLarge);
        }
        if let Some(i) = knots.windows(2).position(|w| w[1] < w[0]) {
            return Err(SplineError::Decreasing(i + 1));
        }
        let range = knots[controls] - knots[degree];
        if !range.is_normal() {
            return Err(SplineError::NoRange { first: degree, last: controls });
        }
        let basis = Self { degree, controls, knots };
        let narrow = basis.knot_spans().find(|span| span.range[1] - span.range[0] < MIN_SPAN);
        narrow.map_or(Ok(()), |span| Err(SplineError::Narrow(span.knot)))?;
        Ok(basis)
    }

    /// Polynomial degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of control points.
    #[must_use]
    pub fn control_count(&self) -> usize {
        self.controls
    }

    /// The spans with a length above 0.
    pub(super) fn knot_spans(&self) -> impl Iterator<Item = KnotSpan> {
        let (first, last) = (self.knots[self.degree], self.knots[self.controls]);
        let place = move |knot: f64| (knot - first) / (last - first);
        (self.degree..self.controls)
            .filter(|k| self.knots[*k] < self.knots[k + 1])
            .map(move |k| KnotSpan { knot: k, range: [place(self.knots[k]), place(self.knots[k + 1])] })
    }

    /// Bézier control points of a span, from the control points at `first`, `first + stride`, … of
    /// `controls`.
    ///
    /// The j-th is the polar form with j arguments at the end knot and p − j at the start knot
    /// (Ramshaw 1989). Each step is a weighted mean, so nothing cancels.
    pub(super) fn bezier_piece<const N: usize>(
        &self,
        span: KnotSpan,
        controls: &[Coefficients<N>],
        (first, stride): (usize, usize),
    ) -> Vec<Coefficients<N>> {
        let (p, k) = (self.degree, span.knot);
        let polar = |j: usize| {
            let mut points: Vec<Coefficients<N>> = (0..=p).map(|i| controls[first + (k - p + i) * stride]).collect();
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

fn check_degree(degree: usize) -> Result<(), SplineError> {
    if (1..=MAX_DEGREE).contains(&degree) { Ok(()) } else { Err(SplineError::Degree(degree)) }
}

#[cfg(test)]
mod tests;
