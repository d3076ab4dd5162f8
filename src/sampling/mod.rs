//! Keyed random numbers, low-discrepancy points, and discrete and piecewise constant distributions.

mod discrete_distribution;
mod key;
mod piecewise_constant;
mod sampler;
mod sobol;
mod square_grid;

pub use discrete_distribution::DiscreteDistribution;
pub use key::{Dimension, Key, Purpose};
pub use piecewise_constant::PiecewiseConstant2d;
pub use sampler::Sampler;
pub use sobol::sobol_2d;
pub use square_grid::SquareGridDistribution;
