//! `sppm`: stochastic progressive photon mapping (Hachisuka and Jensen 2009) by independent passes
//! (Knaus and Zwicker 2011).
//!
//! # Algorithm
//! - **Prepare**: aim and guide photon emission, find gather radii, guide shadow rays, and balance
//!   camera rays against photons.
//! - **Each pass**: trace new photons into a caustic map and an indirect map. Trace new camera
//!   paths. Each ends at the first surface that stores photons. There it does next-event estimation
//!   and reads both maps. Gather radii shrink from pass to pass.

use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::{IndirectPhotons, LightTracing, Settings};
use crate::scene::Effects;

/// Returns the rules of camera paths for stochastic progressive photon mapping.
pub(super) fn path_policy(effects: Effects, _: &Settings) -> PathPolicy {
    PathPolicy {
        effects,
        default_samples_per_pixel: 1,
        passes_share_paths: false,
        uses_nee: true,
        light_sampling: LightSampling::Rays(4),
        continuation: PathContinuation::Never,
        directions: DirectionSampling::Bsdf,
        adds_caustics: false,
        min_throughput: 0.0,
        lookups: PhotonLookups::FirstReceiver,
        shrinking_radii: true,
        light_tracing: LightTracing::Off,
        indirect_photons: IndirectPhotons::Off,
    }
}
