//! Random numbers as pure functions of names, well-spread points, and discrete choices.

mod discrete;
mod draw;
mod key;
mod piecewise;
mod sobol;

pub use discrete::Discrete;
pub use draw::Draw;
pub use key::{Dimension, Key, Purpose};
pub use piecewise::Piecewise2d;
pub use sobol::sobol_2d;
