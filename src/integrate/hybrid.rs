//! `hybrid`: path tracing with next-event estimation, and photon mapping for caustics.
//!
//! # Algorithm
//! - **Prepare**: aim photon emission at caustic casters, guide it to what the camera sees, find
//!   gather radii, balance camera rays against photons, and find the weights of light tracing.
//! - **Each pass**: trace the aimed photons. At their first receiver, connect them to the camera
//!   and store them in the caustic map. Store them in a second map at later receivers. Then trace
//!   camera paths. All paths do next-event estimation and continue at receivers. One path of each
//!   pixel reads both maps at its first receiver.
//!
//! A *receiver* is a surface that stores photons. A *caster* is any other surface that is not
//! black. A light path over casters to a receiver is a caustic. Only photons carry it, so a camera
//! path that hits a light by such a path ignores the emission. Gather radii shrink from pass to
//! pass, so the mean converges.

use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::Settings;
use crate::plan::{Effect, Effects};

/// Returns the rules of camera paths for `hybrid`.
pub(super) fn policy(effects: Effects, settings: &Settings) -> PathPolicy {
    let interreflection = effects.has(Effect::Interreflection);
    PathPolicy {
        effects,
        samples: 8,
        shares_paths: false,
        direct_light: true,
        light_sampling: LightSampling::OneRay,
        continuation: if interreflection { PathContinuation::Always } else { PathContinuation::Never },
        directions: DirectionSampling::Bsdf,
        counts_caustics: false,
        min_throughput: 0.0,
        photons: PhotonLookups::OncePerPixel,
        shrinking_radii: true,
        light_tracing: settings.light_tracing,
    }
}
