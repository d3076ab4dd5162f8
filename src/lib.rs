//! Caustica: a photon-mapping renderer that tells what accuracy costs.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod bsdf;
pub mod camera;
pub mod color;
pub mod light;
pub mod math;
pub mod sampling;
pub mod shape;
pub mod photon;
pub mod scene;
