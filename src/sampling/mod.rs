//! Random numbers as pure functions of keys, low-discrepancy points, and discrete and piecewise
//! distributions.

mod discrete;
mod histogram;
mod key;
mod piecewise;
mod sampler;
mod sobol;

pub use discrete::Discrete;
pub use histogram::Histogram;
pub use key::{Dimension, Key, Purpose};
pub use piecewise::Piecewise2d;
pub use sampler::Sampler;
pub use sobol::sobol_2d;
