//! Caustica: a photon-mapping renderer that tells what accuracy costs.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod bsdf;
pub mod color;
pub mod math;
pub mod sampling;
pub mod shape;
