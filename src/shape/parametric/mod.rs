//! Parametric surfaces, intersected as they are: no triangles stand in for them.
//!
//! A surface is cut once into short pieces, each a polynomial around its middle with bounds on what lies beyond the linear terms.
//! A ray walks a tree of boxes around them. In each piece that it may meet, the bounds tell for certain that there is no root, or
//! that there is at most one, which Newton's method then finds or finds missing; else the piece is halved. What remains in doubt at the
//! size of rounding is a ray that touches the surface within rounding: it counts as a hit where the surface is curved, and as a
//! miss where the ray runs inside a flat part.

mod axis_ray;
mod box_tree;
mod patch;
mod patch_build;
mod patch_piece;
mod polynomial;
mod profile;
mod revolution;
mod revolution_build;
mod ring_tree;
mod spline;

pub use patch::Patch;
pub use polynomial::MAX_DEGREE;
pub use revolution::Revolution;
pub use spline::{Basis, SplineError};

use super::widen;
use crate::math::{Ray, Transform};
use glam::DVec3;

/// A hit is known within so many times 32 ulps of the surface's size: sums over the degree, and the noise in which a touch is a hit.
const SLACK: f64 = 256.0;

/// Gauss and Legendre's five points and weights on \[−1, 1].
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// A ray in the space of a surface, from where it is nearest to the surface's middle.
struct Nearest {
    base: DVec3,
    /// Unit.
    direction: DVec3,
    /// How far along it that is.
    start: f64,
    /// How far a unit of t goes.
    length: f64,
}

impl Nearest {
    fn new(ray: &Ray, to_world: &Transform) -> Self {
        let (o, d) = widen(ray);
        let inverse = to_world.inverse();
        let (o, d) = (inverse.transform_point3(o), inverse.transform_vector3(d));
        let length = d.length();
        let direction = d / length;
        let start = -o.dot(direction);
        // Twice, as the first step rounds in proportion to a distance that may be long.
        let base = o + direction * start;
        let more = -base.dot(direction);
        Self { base: base + direction * more, direction, start: start + more, length }
    }
}

#[cfg(test)]
mod tests;
