//! Parametric surfaces, intersected as they are: no triangles stand in for them.
//!
//! A surface is cut once into short pieces, each a polynomial around its middle with bounds on what lies beyond the linear terms.
//! A ray walks a tree of boxes around them. In each piece that it may meet, the bounds tell for certain that there is no root, or
//! that there is at most one, which Newton's method then finds or finds missing; else the piece is halved. What remains in doubt at the
//! size of rounding is a ray that touches the surface within rounding: it counts as a hit where the surface is curved, and as a
//! miss where the ray runs inside a flat part.

mod axis_ray;
mod box_tree;
mod numeric;
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

#[cfg(test)]
mod tests;
