//! Parametric surfaces, intersected directly, without triangles.
//!
//! A surface is divided once into short pieces. Each piece is a polynomial around its centre, with
//! bounds on the terms beyond the linear ones. A ray traverses a hierarchy of the pieces' boxes. In
//! each piece, the bounds prove that there is no root, or at most one, which Newton's method then
//! finds or excludes. Otherwise the piece is halved. A ray that is tangent within rounding is a hit
//! where the surface is curved, and a miss where it runs inside a flat part.

mod box_bvh;
mod cylindrical_ray;
mod numeric;
mod patch;
mod patch_build;
mod patch_piece;
mod polynomial;
mod profile;
mod revolution;
mod revolution_build;
mod ring_bvh;
mod spline;

pub use patch::Patch;
pub use polynomial::MAX_DEGREE;
pub use revolution::Revolution;
pub use spline::{SplineBasis, SplineError};

#[cfg(test)]
mod tests;
