//! Integrators against each other, against Mitsuba 3, and against the furnace.
//!
//! Passes are independent: integrators that repeat their camera paths get a seed for each pass.
//! Every comparison is a t-test at a stated false-alarm rate. It also limits the noise, because
//! noise could hide an error.

mod adjoint;
mod chance;
mod compare;
mod furnaces;
mod hard;
mod imported;
mod methods;
mod pbrt;
mod principled;
mod references;
mod scenes;
mod sheets;
mod spotfog;
