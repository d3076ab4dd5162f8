//! Cases that break naive renderers, in the groups of docs/theory/stability.md.
//!
//! A failure is a wrong mean, a non-finite value, a crack, a leak, a hang or a panic. A comment in
//! each test derives its tolerances; none is fitted to a result.

mod accumulation;
mod cameras;
mod curved;
mod input;
mod media;
mod normals;
mod photons;
mod refraction;
mod sampling;
mod scale;
mod transforms;
mod triangles;
