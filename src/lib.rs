//! Caustica: a photon-mapping renderer that tells what accuracy costs.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod accel;
pub mod bsdf;
pub mod camera;
pub mod cli;
pub mod color;
pub mod format;
pub mod image;
pub mod integrate;
pub mod light;
pub mod math;
pub mod photon;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shape;
pub mod stats;
