//! Degenerate triangles, and rays along, through and from their edges: nothing leaks, nothing is
//! hit twice.

pub mod closed;
mod edges;
mod leaks;
mod starts;
