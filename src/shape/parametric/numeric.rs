//! Constants of the numerical methods for parametric surfaces.

/// Bound on the position error of a hit on a parametric surface, in units of 32 f64 ulps of the
/// surface's size.
///
/// The bound covers polynomial evaluation and the tolerance for tangent rays.
pub(super) const HIT_ERROR_SCALE: f64 = 256.0;

/// Points and weights of five-point Gauss–Legendre quadrature on \[−1, 1].
pub(super) const GAUSS_LEGENDRE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];
