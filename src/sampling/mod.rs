//! Random numbers as pure functions of names, well-spread points, and discrete choices.

mod discrete;
mod histogram;
mod key;
mod sobol;

pub use discrete::Discrete;
pub use histogram::Histogram;
pub use key::{Dimension, Key, Purpose};
pub use sobol::sobol_2d;
