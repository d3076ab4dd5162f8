//! Transforms that mirror, shear, squeeze and nest.
//!
//! Distances and normals stay right, and singular transforms are refused.

pub mod double_double;
mod instances;
mod maps;
mod nested;
mod quarters;
mod shapes;
