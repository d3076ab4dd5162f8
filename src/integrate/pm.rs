//! `pm`: photon mapping with two maps of fixed radii (Jensen 2001, chapter 9).
//!
//! # Algorithm
//! - **Prepare**: aim and guide photon emission, find gather radii, and balance camera rays against
//!   photons.
//! - **Each pass**: trace new photons into a caustic map and a global map. Trace camera paths with
//!   next-event estimation. At the first receiver a path reads the caustic map.
//!   - *Direct visualization*: it also reads the global map there and ends.
//!   - *Final gathering*: it sends a gather ray and reads both maps at the end of it, which hides
//!     the blur of the global map and its seams at edges. A gather ray too short to help does not
//!     end the path: it continues from there.

use super::policy::{Continuation, DirectionSampling, LightSampling, PathPolicy, PhotonLookups};
use super::settings::{FinalGathering, Settings};
use crate::plan::{Effect, Effects};

/// Policy of `pm`.
pub(super) fn policy(effects: Effects, settings: &Settings) -> PathPolicy {
    let (samples, light_sampling) = match settings.final_gathering {
        FinalGathering::None => (1, LightSampling::Rays(4)),
        // One gather ray per camera ray.
        FinalGathering::Bsdf | FinalGathering::Importance => (4, LightSampling::OneRay),
    };
    let gathers = effects.has(Effect::Gathering) && effects.has(Effect::Interreflection);
    let (continuation, directions, photons) = match settings.final_gathering {
        FinalGathering::Bsdf if gathers => {
            (Continuation::GatherRays, DirectionSampling::Bsdf, PhotonLookups::GatherRays)
        }
        FinalGathering::Importance if gathers => {
            (Continuation::GatherRays, DirectionSampling::Guided, PhotonLookups::GatherRays)
        }
        FinalGathering::None | FinalGathering::Bsdf | FinalGathering::Importance => {
            (Continuation::Never, DirectionSampling::Bsdf, PhotonLookups::FirstReceiver)
        }
    };
    PathPolicy {
        effects,
        samples,
        shares_paths: false,
        direct_light: true,
        light_sampling,
        continuation,
        directions,
        counts_caustics: false,
        min_throughput: 0.0,
        photons,
        shrinking_radii: false,
    }
}
