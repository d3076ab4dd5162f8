//! Parametric surfaces, intersected directly, without triangles.
//!
//! The builder divides a surface into nearly flat pieces, called leaves. A leaf stores a polynomial
//! around its centre, and bounds on the terms of degree 2 and above. A ray traverses a bounding
//! volume hierarchy of the leaves. In a leaf, the bounds prove that there is no hit, or at most
//! one, which Newton's method then finds or excludes. Otherwise the leaf is halved.
//!
//! A ray that touches a curved surface tangentially hits it, up to rounding errors. A ray that lies
//! in a flat surface misses it.

mod box_bvh;
mod cylindrical_ray;
mod patch;
mod patch_build;
mod patch_piece;
mod polynomial;
mod profile;
mod revolution;
mod revolution_build;
mod ring_bvh;
mod root_finding;
mod spline;

pub use patch::Patch;
pub use polynomial::MAX_DEGREE;
pub use revolution::Revolution;
pub use spline::{SplineBasis, SplineError};

#[cfg(test)]
mod tests;
