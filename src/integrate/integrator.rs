//! The trait that all rendering algorithms implement.

use super::balance::RayPhotonBalance;
use super::environment_pilot::EnvironmentGuidingReport;
use super::pass::{ExpectedPhotons, PassResult, ProgressMonitor};
use super::radius_law::RadiusLaw;
use super::radius_pilot::{EmissionGuidingReports, GatherRadii};
use super::scatter_point_pilot::ScatterPointGuidingReport;
use crate::plan::Plan;
use crate::scene::Effects;
use crate::stats::Counters;

/// A rendering algorithm, prepared to render passes of one scene. *Pilots* are small simulations
/// that run when the integrator is made, before the first pass.
///
/// The picture is the mean of all passes. Pass `i` depends only on the scene, the settings and
/// `i`, so any pass can be computed alone.
pub trait Integrator: Send + Sync {
    /// Renders the pass with number `pass`, counted from 0.
    fn render_pass(&self, pass: u32, monitor: &dyn ProgressMonitor) -> PassResult;

    /// Returns the plan: the decision for each effect of light whether it is simulated, and why.
    fn plan(&self) -> &Plan;

    /// Estimates the ray and photon counts of the first pass, if only `effects` are simulated.
    fn expected_work(&self, effects: Effects) -> Counters;

    /// Returns how many photon paths a pass traces. Also estimates how many photons it stores, by
    /// tracing a few paths. All numbers are 0 without photons.
    fn expected_photons(&self) -> ExpectedPhotons {
        ExpectedPhotons::default()
    }

    /// Returns the numbers of camera rays and photon paths that a pilot chose; `None` if no pilot
    /// chose them.
    fn ray_photon_balance(&self) -> Option<RayPhotonBalance> {
        None
    }

    /// Returns the mean number of prefix rays per pixel and pass.
    ///
    /// Prefix rays are extra camera paths that end at their first receiver (see
    /// [`PhotonKind`](crate::photon::PhotonKind)).
    fn prefix_rays_per_pixel(&self) -> f64 {
        0.0
    }

    /// Returns the weight in \[0, 1] of photon estimates from the interreflection map of `hybrid`
    /// in pass `pass`, as a mean over the picture. Returns 0 for other algorithms.
    ///
    /// Camera paths have the rest of the weight. The indirect light of caustics does not count: in
    /// `hybrid`, photons always carry it.
    fn interreflection_photon_weight(&self, _pass: u32) -> f64 {
        0.0
    }

    /// Returns the largest gather radii of the caustic and the indirect map in the first pass;
    /// `None` without photons. In later passes, radii may be smaller.
    fn initial_gather_radii(&self) -> Option<GatherRadii> {
        None
    }

    /// Returns the law by which gather radii shrink from pass to pass; `None` without photons.
    fn radius_law(&self) -> Option<RadiusLaw> {
        None
    }

    /// True if passes return the data from which the error of the picture is estimated. With
    /// photons, the data include [`NestedDifferences`](super::NestedDifferences).
    fn estimates_error(&self) -> bool {
        false
    }

    /// True if passes divide the light of each pixel into the parts of
    /// [`LightGroup`](super::LightGroup).
    fn groups_light(&self) -> bool {
        false
    }

    /// True if passes clamp the light of camera paths, and return the light that this removes.
    fn clamps_light(&self) -> bool {
        false
    }

    /// True if media of the scene emit light with which the passes do not light surfaces.
    ///
    /// Only camera paths that continue from receivers find this light: media emit no photons, and
    /// get no shadow rays.
    fn omits_light_from_media(&self) -> bool {
        false
    }

    /// Returns the work and benefit of the pilot that guides shadow rays to the environment light;
    /// `None` if no such pilot ran.
    fn environment_guiding_report(&self) -> Option<EnvironmentGuidingReport> {
        None
    }

    /// Returns the work and benefit of the pilot that guides the points of media from which shadow
    /// rays start; `None` if no such pilot ran.
    fn scatter_point_guiding_report(&self) -> Option<ScatterPointGuidingReport> {
        None
    }

    /// Returns the work and benefit of guiding photon emission towards points that the camera sees,
    /// for photon paths in all directions and for paths aimed at casters.
    fn emission_guiding_reports(&self) -> EmissionGuidingReports {
        EmissionGuidingReports::default()
    }
}
