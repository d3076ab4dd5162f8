//! Triangles in extreme cases: without area, and with rays along, through and from their edges. No
//! ray leaks, and none hits twice.

pub mod closed;
mod edges;
mod leaks;
mod starts;
