//! Constants and results of the root finders for parametric surfaces.

/// Ratio of the position error bound of parametric surfaces to the bound of other shapes.
///
/// The larger bound covers the errors of polynomial evaluation and the tolerance for tangent rays.
pub(super) const PARAMETRIC_ERROR_FACTOR: f64 = 256.0;

/// Points and weights of five-point Gauss–Legendre quadrature on \[−1, 1].
pub(super) const GAUSS_LEGENDRE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// Largest change of the Jacobian J over a parameter box, relative to J at the centre of the box,
/// for which Newton's method surely converges.
///
/// Let q be this relative change, and J̄ the mean of J on the line from an iterate to the root.
/// Then |1 − J⁻¹J̄| ≤ 2q/(1 − q), which is [`NEWTON_CONVERGENCE_RATE`].
pub(super) const MAX_DERIVATIVE_CHANGE: f64 = 0.25;

/// Largest factor by which a Newton step multiplies the distance from the iterate to the root.
///
/// [`MAX_DERIVATIVE_CHANGE`] guarantees this rate.
pub(super) const NEWTON_CONVERGENCE_RATE: f64 = 2.0 / 3.0;

/// Longest first Newton step to a root inside a box, in half widths of the box.
///
/// The distance to the root is at most 2 half widths, and the step is J⁻¹J̄ times this distance.
/// [`MAX_DERIVATIVE_CHANGE`] defines J and J̄.
pub(super) const MAX_FIRST_NEWTON_STEP: f64 = 2.0 * (1.0 + NEWTON_CONVERGENCE_RATE);

/// Distance outside a piece at which a root still counts as inside, in half widths of the piece.
///
/// Adjacent pieces overlap by this distance, so no root is lost between them.
pub(super) const PIECE_OVERLAP: f64 = 1e-10;

/// Size of a piece of a surface, relative to the whole surface, below which the piece counts as a
/// point. A ray that lies in so small a piece then has one hit there.
pub(super) const TANGENT_HIT_RELATIVE_SIZE: f64 = 1e-6;

/// Result of a test whether a ray hits a surface within a box of surface parameters.
pub(super) enum RootClassification<X> {
    /// The ray misses the surface within the box.
    NoRoot,
    /// The ray hits the surface once within the box: at these parameters and arc length τ.
    Root(X, f64),
    /// The test does not decide; the box must be halved.
    Unclear,
    /// The ray lies in the surface over the whole box, up to rounding.
    LineInSurface,
}
