//! Bézier and B-spline curves and nets of control points, cut into Bézier pieces.

use super::polynomial::{MAX_DEGREE, Vector};
use crate::stats::bytes;

/// Why control points and knots make no curve or surface.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SplineError {
    /// Degree 0, or one beyond what evaluation has room for.
    #[error("the degree is {0}, and must be from 1 to {MAX_DEGREE}")]
    Degree(usize),
    /// A curve of degree p has more than p control points.
    #[error("{controls} control points are too few for degree {degree}: at least {} are needed", degree + 1)]
    Controls {
        /// How many there are.
        controls: usize,
        /// Of the curve.
        degree: usize,
    },
    /// The number of knots is not the number of control points plus the degree plus 1.
    #[error("{knots} knots do not fit {controls} control points of degree {degree}: {} are needed", controls + degree + 1)]
    Knots {
        /// How many there are.
        knots: usize,
        /// Number of control points.
        controls: usize,
        /// Of the curve.
        degree: usize,
    },
    /// Knots must not decrease; counted from 0.
    #[error("knot {0} (counted from 0) is less than the one before it")]
    Decreasing(usize),
    /// The first knot of the curve's range is its last too.
    #[error("the range of the curve, from knot {first} to knot {last} (counted from 0), has no length")]
    NoRange {
        /// Index of the first knot of the range.
        first: usize,
        /// Index of its last knot.
        last: usize,
    },
    /// A stretch too short for coordinates in single precision; its first knot, counted from 0.
    #[error("the stretch that begins at knot {0} (counted from 0) is shorter than 1/4194304 of the curve's range")]
    Narrow(usize),
    /// A number of control points that does not make a net.
    #[error("{controls} control points do not make a net of {rows} × {columns}")]
    Net {
        /// How many there are.
        controls: usize,
        /// Wanted along u.
        rows: usize,
        /// Wanted along v.
        columns: usize,
    },
    /// Weights must be above 0; the control point counted from 0.
    #[error("the weight of control point {0} (counted from 0) is not above 0")]
    Weight(usize),
    /// A coordinate, weight or knot that is not finite, or so large that its square is not.
    #[error("a control point or knot is too large")]
    TooLarge,
    /// More memory than there is.
    #[error("the surface takes {} of memory or more, and {} are free", bytes(*needed), bytes(*free))]
    Memory {
        /// Bytes that it took when it was given up.
        needed: u64,
        /// Bytes that it may take.
        free: u64,
    },
    /// All of it lies in one line or point.
    #[error("the surface has no area")]
    NoArea,
}

/// Shortest stretch in parts of the range: coordinates below 1 are 2⁻²⁴ apart in single precision, and each stretch is to hold some.
pub(super) const NARROWEST: f64 = 1.0 / 4_194_304.0;

/// The knots of one direction, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    degree: usize,
    controls: usize,
    knots: Vec<f64>,
}

/// A stretch between two different knots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Index of the knot at its start.
    knot: usize,
    /// Where it lies in the range of the curve, which is \[0, 1].
    pub range: [f64; 2],
}

impl Basis {
    /// One Bézier curve of so many control points.
    ///
    /// # Errors
    /// [`SplineError::Degree`] for fewer than 2 or too many of them.
    pub fn bezier(controls: usize) -> Result<Self, SplineError> {
        let degree = controls.saturating_sub(1);
        let knots = [0.0, 1.0].into_iter().flat_map(|k| std::iter::repeat_n(k, controls.min(MAX_DEGREE + 1))).collect();
        check_degree(degree)?;
        Ok(Self { degree, controls, knots })
    }

    /// A B-spline with the knots i/(n + p), unclamped, so that it begins and ends within its control points.
    ///
    /// # Errors
    /// [`SplineError`] where degree and number do not fit.
    pub fn uniform(degree: usize, controls: usize) -> Result<Self, SplineError> {
        check_degree(degree)?;
        let last = controls + degree;
        Self::new(degree, controls, (0..=last).map(|i| i as f64 / last as f64).collect())
    }

    /// A B-spline of any knots, which do not decrease. Its range is from knot p to knot n, counted from 0.
    ///
    /// # Errors
    /// [`SplineError`] where degree, numbers and knots do not fit.
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
        let narrow = basis.spans().find(|span| span.range[1] - span.range[0] < NARROWEST);
        narrow.map_or(Ok(()), |span| Err(SplineError::Narrow(span.knot)))?;
        Ok(basis)
    }

    /// The degree.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// How many control points there are.
    #[must_use]
    pub fn controls(&self) -> usize {
        self.controls
    }

    /// The stretches that have a length.
    pub(super) fn spans(&self) -> impl Iterator<Item = Span> {
        let (first, last) = (self.knots[self.degree], self.knots[self.controls]);
        let place = move |knot: f64| (knot - first) / (last - first);
        (self.degree..self.controls)
            .filter(|k| self.knots[*k] < self.knots[k + 1])
            .map(move |k| Span { knot: k, range: [place(self.knots[k]), place(self.knots[k + 1])] })
    }

    /// Bézier control points of a stretch, from the control points at `first`, `first + stride`, … of `controls`.
    ///
    /// The j-th is the polar form at j times the knot at the end and p − j times that at the start (Ramshaw 1989): each step is a
    /// weighted mean, so nothing cancels.
    pub(super) fn piece<const N: usize>(
        &self,
        span: Span,
        controls: &[Vector<N>],
        (first, stride): (usize, usize),
    ) -> Vec<Vector<N>> {
        let (p, k) = (self.degree, span.knot);
        let polar = |j: usize| {
            let mut points: Vec<Vector<N>> = (0..=p).map(|i| controls[first + (k - p + i) * stride]).collect();
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
