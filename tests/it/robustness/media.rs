//! Media at the limits of their coefficients, and paths across a million boundaries.

mod boundaries;
mod grids;
