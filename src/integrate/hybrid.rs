//! `hybrid`: path tracing with next-event estimation, and photon mapping for caustics.
//!
//! A *receiver* is a surface or medium that stores photons, such as a diffuse wall. A *caster*
//! passes photons on, such as a mirror or glass. [`PhotonKind`](crate::photon::PhotonKind) has the
//! exact definitions.
//!
//! - **Prepare**: aim photon emission at casters. Then run pilots, small simulations before the
//!   first pass. They guide photon emission towards points that the camera sees, and find gather
//!   radii. They guide shadow rays to the environment light, and guide scattering points, the
//!   points in media from which shadow rays start. They divide indirect light between camera paths
//!   and photons, and balance camera rays against photons. They divide caustics between photon
//!   estimates and light tracing. They find the numbers of prefix rays, extra camera paths that end
//!   at their first receiver.
//! - **Each pass, photons**: trace photon paths aimed at casters. Where they reach a receiver via
//!   casters, connect them to the camera (light tracing) and store photons in the caustic map. At
//!   later receivers, store photons in the indirect map. Trace unaimed photon paths, which start in
//!   all directions. Store their photons in the interreflection map once a receiver has reflected
//!   them.
//! - **Each pass, camera paths**: trace camera paths with next-event estimation. One path of each
//!   pixel, in each slice of the shutter interval, reads the photon maps at its first receiver.
//!   Some paths continue there. Then trace prefix rays in the pixels that need them.
//!
//! Photons carry caustics and the light that receivers reflect after a caustic. Camera paths ignore
//! emission that they hit after a receiver and one or more casters. Photons also carry a share of
//! the other indirect light, which a pilot finds. The share may be 0; camera paths carry the rest.
//! Gather radii shrink from pass to pass, so the mean of the passes converges.

use super::policy::{DirectionSampling, LightSampling, PathContinuation, PathPolicy, PhotonLookups};
use super::settings::Settings;
use crate::scene::{Effect, Effects};

/// Returns the rules of camera paths for `hybrid`.
pub(super) fn path_policy(effects: Effects, settings: &Settings) -> PathPolicy {
    let interreflection = effects.has(Effect::Interreflection);
    PathPolicy {
        effects,
        default_samples_per_pixel: 8,
        passes_share_paths: false,
        uses_nee: true,
        light_sampling: LightSampling::OneRay,
        continuation: if interreflection { PathContinuation::Always } else { PathContinuation::Never },
        directions: DirectionSampling::Bsdf,
        adds_caustics: false,
        min_throughput: 0.0,
        lookups: PhotonLookups::FewPerPixel,
        shrinking_radii: true,
        light_tracing: settings.light_tracing,
        indirect_photons: settings.indirect_photons,
    }
}
