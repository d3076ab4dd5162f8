//! `pm`: photon mapping with two maps of fixed radii (Jensen 2001, chapter 9).
//!
//! - **Prepare**: aim and guide photon emission, find gather radii, guide shadow rays, and balance
//!   camera rays against photons.
//! - **Each pass**: trace new photons into a caustic map and an indirect map. Trace camera paths
//!   with next-event estimation. A path reads the caustic map at the first surface that stores
//!   photons. [`FinalGathering`] sets how it finds indirect light.
//!
//! *Direct visualization*: the path also reads the indirect map at that surface, and ends.
//!
//! *Final gathering*: the path sends a gather ray and reads both maps at its end. This hides the
//! blur of the indirect map. Where a gather ray is too short to hide the blur, the path continues
//! instead.

use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::{FinalGathering, IndirectPhotons, LightTracing, Settings};
use crate::scene::{Effect, Effects};

/// Returns the rules of camera paths for photon mapping with fixed radii.
pub(super) fn path_policy(effects: Effects, settings: &Settings) -> PathPolicy {
    let (samples, light_sampling) = match settings.final_gathering {
        FinalGathering::None => (1, LightSampling::Rays(4)),
        // A camera ray leads to one gather ray, so a pixel needs several camera rays.
        FinalGathering::Bsdf | FinalGathering::Importance => (4, LightSampling::OneRay),
    };
    let gathers = effects.has(Effect::Gathering) && effects.has(Effect::Interreflection);
    let (continuation, directions, lookups) = match settings.final_gathering {
        FinalGathering::Bsdf if gathers => {
            (PathContinuation::GatherRays, DirectionSampling::Bsdf, PhotonLookups::GatherRays)
        }
        FinalGathering::Importance if gathers => {
            (PathContinuation::GatherRays, DirectionSampling::Guided, PhotonLookups::GatherRays)
        }
        FinalGathering::None | FinalGathering::Bsdf | FinalGathering::Importance => {
            (PathContinuation::Never, DirectionSampling::Bsdf, PhotonLookups::FirstReceiver)
        }
    };
    PathPolicy {
        effects,
        default_samples_per_pixel: samples,
        passes_share_paths: false,
        uses_nee: true,
        light_sampling,
        continuation,
        directions,
        adds_caustics: false,
        min_throughput: 0.0,
        lookups,
        shrinking_radii: false,
        light_tracing: LightTracing::Off,
        indirect_photons: IndirectPhotons::Off,
    }
}
