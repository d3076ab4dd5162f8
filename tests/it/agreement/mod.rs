//! Methods against pictures of another renderer, against each other, and against what no light may do.
//!
//! Passes of one method have seeds of their own, so that they are independent, those of methods that repeat their camera walks
//! too. Every comparison is a t-test at a stated false-alarm rate, and states how sharp it must be.

mod adjoint;
mod compare;
mod furnaces;
mod hard;
mod methods;
mod references;
mod scenes;
