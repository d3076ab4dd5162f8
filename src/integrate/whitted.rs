//! `whitted`: recursive ray tracing (Whitted 1980).
//!
//! # Algorithm
//! - **Prepare**: nothing.
//! - **Each pass**: reflect camera rays at mirrors, and split them at glass into a reflected and a
//!   refracted branch. Shade other surfaces by shadow rays to the center of each light. A branch
//!   ends if it is too deep or too faint.

use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::{IndirectPhotons, LightTracing, Settings};
use crate::scene::Effects;

/// Throughput, as a mean over RGB, below which a camera path ends: 1/256, one level of an 8-bit
/// picture.
const MIN_THROUGHPUT: f32 = 1.0 / 256.0;

/// Returns the rules of camera paths for recursive ray tracing.
pub(super) fn path_policy(effects: Effects, _: &Settings) -> PathPolicy {
    PathPolicy {
        effects,
        default_samples_per_pixel: 1,
        passes_share_paths: false,
        uses_nee: true,
        light_sampling: LightSampling::Centers,
        continuation: PathContinuation::Never,
        directions: DirectionSampling::Bsdf,
        adds_caustics: true,
        min_throughput: MIN_THROUGHPUT,
        lookups: PhotonLookups::Never,
        shrinking_radii: true,
        light_tracing: LightTracing::Off,
        indirect_photons: IndirectPhotons::Off,
    }
}
