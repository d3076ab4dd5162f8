//! Caustica: a photon-mapping renderer that tells what accuracy costs.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod format;
pub mod math;
