//! Transforms that mirror, shear, squeeze and nest: distances and normals stay right, singular ones
//! are refused.

pub mod double_double;
mod instances;
mod maps;
mod nested;
mod quarters;
mod shapes;
