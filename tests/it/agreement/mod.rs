//! Integrators against each other, against Mitsuba 3, and against the furnace.
//!
//! Passes are independent: integrators that repeat their camera paths get a seed for each pass.
//! Every comparison is a t-test at a stated false-alarm rate, and states how sharp it must be.

mod adjoint;
mod chance;
mod compare;
mod furnaces;
mod hard;
mod methods;
mod references;
mod scenes;
