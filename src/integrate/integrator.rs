//! The interface of all algorithms.

use super::balance::Balance;
use super::pass::{Expected, Monitor, Pass};
use super::radius_law::RadiusLaw;
use super::radius_pilot::{GuidingReports, Radii};
use crate::plan::{Effects, Plan};
use crate::stats::Counters;

/// An algorithm, prepared to render the passes of one scene.
///
/// Pass `i` is a function of the scene, the settings and `i`: any pass can be computed alone. The
/// picture of a render is the mean of its passes.
pub trait Integrator: Sync {
    /// Renders pass `pass`, counted from 0.
    fn pass(&self, pass: u32, monitor: &dyn Monitor) -> Pass;

    /// The effects that are simulated, and why.
    fn plan(&self) -> &Plan;

    /// Estimated work of the first pass if only `effects` of the plan are simulated; excludes
    /// pilots.
    fn expected_work(&self, effects: Effects) -> Counters;

    /// Estimated memory of a pass, from few paths.
    fn expected(&self) -> Expected {
        Expected::default()
    }

    /// Numbers of camera rays and photons that a pilot chose; `None` if none did.
    fn balance(&self) -> Option<Balance> {
        None
    }

    /// Largest gather radii of the first pass; `None` without photons.
    fn radii(&self) -> Option<Radii> {
        None
    }

    /// Radius law of the photon estimates; `None` without estimates.
    fn radius_law(&self) -> Option<RadiusLaw> {
        None
    }

    /// True if passes return nested estimates, for error estimation.
    fn nests_estimates(&self) -> bool {
        false
    }

    /// Results of emission guiding.
    fn guiding_reports(&self) -> GuidingReports {
        GuidingReports::default()
    }
}
