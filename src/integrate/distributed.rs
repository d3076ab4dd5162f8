//! `distributed`: distributed ray tracing (Cook, Porter and Carpenter 1984).
//!
//! # Algorithm
//! - **Prepare**: run two pilots, small simulations before the first pass. One guides shadow rays
//!   to the environment light. The other guides scattering points, the points in media from which
//!   shadow rays start.
//! - **Each pass**: trace camera paths that sample area lights, glossy lobes, the lens and the
//!   pixel at random. A path continues only if the chosen BSDF lobe is not diffuse, so diffuse
//!   surfaces do not light each other.

use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::{IndirectPhotons, LightTracing, Settings};
use crate::scene::Effects;

/// Returns the rules of camera paths for distributed ray tracing.
pub(super) fn path_policy(effects: Effects, _: &Settings) -> PathPolicy {
    PathPolicy {
        effects,
        default_samples_per_pixel: 4,
        passes_share_paths: false,
        uses_nee: true,
        light_sampling: LightSampling::OneRay,
        continuation: PathContinuation::Glossy,
        directions: DirectionSampling::OneLobe,
        adds_caustics: true,
        min_throughput: 0.0,
        lookups: PhotonLookups::Never,
        shrinking_radii: true,
        light_tracing: LightTracing::Off,
        indirect_photons: IndirectPhotons::Off,
    }
}
