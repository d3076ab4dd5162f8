//! Algorithms that turn a scene into an image, each in a file, behind one trait.

mod adapt;
mod algorithm;
mod balance;
mod direct;
mod distributed;
mod eye;
mod gauged;
mod guide;
mod hybrid;
mod maker;
mod maps;
mod method;
mod pass;
mod path;
mod pilot;
mod pm;
mod ppm;
mod prepared;
mod progressive;
mod raycast;
mod settings;
mod sketch;
mod sppm;
mod tiles;
mod visible;
mod volume;
mod whitted;

pub use algorithm::Algorithm;
pub use balance::Balance;
pub use gauged::{Discs, Gauged};
pub use maker::CAUSTIC_K;
pub use pass::{Expected, Monitor, Pass, PhotonReport, Seconds, Silent, Stage};
pub use pilot::{GuidingReports, Radii};
pub use progressive::{ALPHA, RadiusLaw, shrink};
pub use settings::{EyeSettings, FinalGathering, Settings};
pub use volume::VolumeEstimate;

use crate::plan::{Effects, Plan};
use crate::stats::Counters;

/// An algorithm made ready to render the passes of a scene.
///
/// Pass `i` is a function of the scene, the settings and `i`: any pass can be computed alone, and the image of a render is the
/// mean of its passes.
pub trait Integrator: Sync {
    /// Computes pass `pass`, counted from 0.
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass;

    /// How a pass divides its work, where a pilot found that.
    fn balance(&self) -> Option<Balance> {
        None
    }

    /// Largest gather radii of the first pass; `None` without photons.
    fn radii(&self) -> Option<Radii> {
        None
    }

    /// How radii go from pass to pass; `None` without estimates.
    fn radius_law(&self) -> Option<RadiusLaw> {
        None
    }

    /// Whether passes tell of the error of their estimates.
    fn gauged(&self) -> bool {
        false
    }

    /// What a pass will keep in memory, found from few paths.
    fn expected(&self) -> Expected {
        Expected::default()
    }

    /// The work of the first pass, were only `effects` of the plan simulated; about, counted on few rays and photons. Pilots do not count.
    fn expected_work(&self, effects: Effects) -> Counters;

    /// What of light is simulated.
    fn plan(&self) -> &Plan;

    /// What emission learned from a pilot.
    fn lessons(&self) -> GuidingReports {
        GuidingReports::default()
    }
}
