//! Random numbers as pure functions of names, well-spread points, and discrete choices.

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
