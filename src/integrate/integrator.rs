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

/// A rendering algorithm, prepared to render passes of one scene. Its *pilots*, small simulations
/// before the first pass, have run.
///
/// The picture is the mean of all passes. Pass `i` depends only on the scene, the settings and `i`,
/// so any pass can be computed alone.
pub trait Integrator: Send + Sync {
    /// Renders the pass with number `pass`, counted from 0.
    fn render_pass(&self, pass: u32, monitor: &dyn ProgressMonitor) -> PassResult;

    /// Returns the plan, which says for each effect of light whether it is simulated, and why.
    fn plan(&self) -> &Plan;

    /// Estimates the ray and photon counts of the first pass of a render that simulates only
    /// `effects`.
    fn expected_work(&self, effects: Effects) -> Counters;

    /// Returns the number of photon paths of a pass, and an estimate of how many photons the pass
    /// stores. The estimate comes from a few traced photon paths. All numbers are 0 if the
    /// algorithm traces no photons.
    fn expected_photons(&self) -> ExpectedPhotons {
        ExpectedPhotons::default()
    }

    /// Returns the numbers of camera rays and photon paths that a pilot (small simulation before
    /// the first pass) chose; `None` if no pilot chose them.
    fn ray_photon_balance(&self) -> Option<RayPhotonBalance> {
        None
    }

    /// Returns the mean number of prefix rays per pixel and pass.
    ///
    /// Prefix rays are extra camera paths that end at the first surface that stores photons, such
    /// as a diffuse wall.
    fn prefix_rays_per_pixel(&self) -> f64 {
        0.0
    }

    /// Returns the weight in \[0, 1] of photon estimates for indirect light in pass `pass` of
    /// `hybrid`, as a mean over the picture. Camera paths find the rest of this light. Returns 0
    /// for other algorithms.
    ///
    /// Here, indirect light excludes the indirect light of caustics, because photons always carry
    /// that light in `hybrid`.
    fn interreflection_photon_weight(&self, _pass: u32) -> f64 {
        0.0
    }

    /// Returns the largest gather radii of the caustic and the indirect map in the first pass
    /// \[length]; `None` without photons. In later passes, radii may be smaller.
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

    /// True if passes divide the light of each pixel into direct, indirect and caustic light
    /// ([`LightGroup`](super::LightGroup)).
    fn groups_light(&self) -> bool {
        false
    }

    /// True if passes limit the radiance of each camera path (clamping), and also return the
    /// radiance that clamping removed.
    fn clamps_light(&self) -> bool {
        false
    }

    /// True if the scene has emitting media whose light on surfaces is missing from the picture.
    ///
    /// Only camera paths that continue from surfaces find this light: photon paths never start in
    /// media, and shadow rays never aim at media that emit light.
    fn omits_light_from_media(&self) -> bool {
        false
    }

    /// Returns the work and benefit of the pilot (small simulation before the first pass) that
    /// guides shadow rays to the environment light; `None` if no such pilot ran.
    fn environment_guiding_report(&self) -> Option<EnvironmentGuidingReport> {
        None
    }

    /// Returns the work and benefit of the pilot (small simulation before the first pass) that
    /// learns where direct light arrives in media, so that shadow rays can start there; `None` if
    /// no such pilot ran.
    fn scatter_point_guiding_report(&self) -> Option<ScatterPointGuidingReport> {
        None
    }

    /// Returns the work and benefit of guiding photon emission towards points that the camera sees.
    /// There is one report for photon paths that start in all directions, and one for photon paths
    /// aimed at casters, such as glass.
    fn emission_guiding_reports(&self) -> EmissionGuidingReports {
        EmissionGuidingReports::default()
    }
}
