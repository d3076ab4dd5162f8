//! Algorithms that turn a scene into an image, each in a file, behind one trait.

mod direct;
mod pass;
mod photon_mapping;
mod pilot;
mod progressive;
mod raycast;
mod tiles;

pub use pass::{Monitor, Pass, Phase, PhotonReport, Seconds, Silent};
pub use photon_mapping::{CAUSTIC_K, PhotonMapping, PhotonSettings};
pub use pilot::{Radii, auto_radius};
pub use progressive::{ALPHA, shrink};
pub use raycast::RayCast;

/// An algorithm that renders independent passes.
///
/// Pass `i` is a function of the scene, the settings and `i`: any pass can be computed alone, and the image of a render is the
/// mean of its passes.
pub trait Integrator: Sync {
    /// Computes pass `pass`, counted from 0.
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass;
}
