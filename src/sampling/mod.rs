//! Random numbers as pure functions of names, well-spread points, and discrete choices.

mod discrete;
mod draw;
mod histogram;
mod key;
mod piecewise;
mod sobol;

pub use discrete::Discrete;
pub use draw::Draw;
pub use histogram::Histogram;
pub use key::{Dimension, Key, Purpose};
pub use piecewise::Piecewise2d;
pub use sobol::sobol_2d;
