//! Media at the ends of their coefficients, and boundaries by the million.

mod boundaries;
mod grids;
