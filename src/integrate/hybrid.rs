//! `hybrid`: path tracing with next-event estimation, and photon mapping for caustics.
//!
//! # Algorithm
//! - **Prepare**: aim photon emission at caustic casters, guide it to what the camera sees, find
//!   gather radii, divide indirect light between camera paths and photons, balance camera rays
//!   against photons, and find the weights of light tracing and the numbers of prefix rays.
//! - **Each pass**: trace the aimed photons. At their first receiver, connect them to the camera
//!   and store them in the caustic map. At later receivers, store them in the indirect map. Trace
//!   unaimed photons, and store those that receivers reflected in the interreflection map. Then
//!   trace camera paths. All paths do next-event estimation. At first receivers, some of each
//!   pixel's paths continue, with the weight of camera paths, and one reads the maps. Then trace
//!   prefix rays, which end at their first receiver, in the pixels that need them.
//!
//! [`PhotonKind`](crate::photon::PhotonKind) defines casters and receivers. A light path over
//! casters to a receiver is a caustic. Only photons carry caustics, so a camera path ignores the
//! emission of a light that it reaches from a receiver over casters. Gather radii shrink from pass
//! to pass, so the mean of the passes converges.

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
        indirect_photons: settings.indirect_photons,
    }
}
