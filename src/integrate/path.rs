//! `path`: path tracing, unbiased (Veach 1997, chapters 9 and 10).
//!
//! # Algorithm
//! - **Prepare**: guide shadow rays to the environment light, and guide scattering points, the
//!   points in media from which shadow rays start.
//! - **Each pass**: trace camera paths. At each surface a path does next-event estimation and
//!   continues in a direction sampled from the BSDF. The balance heuristic combines both.

use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::{IndirectPhotons, LightTracing, Settings};
use crate::scene::{Effect, Effects};

/// Returns the rules of camera paths for path tracing.
pub(super) fn path_policy(effects: Effects, _: &Settings) -> PathPolicy {
    let interreflection = effects.has(Effect::Interreflection);
    PathPolicy {
        effects,
        default_samples_per_pixel: 4,
        passes_share_paths: false,
        uses_nee: true,
        light_sampling: LightSampling::OneRay,
        continuation: if interreflection { PathContinuation::Always } else { PathContinuation::Never },
        directions: DirectionSampling::Bsdf,
        adds_caustics: effects.has(Effect::Caustics),
        min_throughput: 0.0,
        lookups: PhotonLookups::Never,
        shrinking_radii: true,
        light_tracing: LightTracing::Off,
        indirect_photons: IndirectPhotons::Off,
    }
}
