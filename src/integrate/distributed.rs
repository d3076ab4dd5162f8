//! `distributed`: distributed ray tracing (Cook, Porter and Carpenter 1984).
//!
//! # Algorithm
//! - **Prepare**: nothing.
//! - **Each pass**: trace camera paths. Lights with an extent, glossy lobes and the pixel's area
//!   are sampled by chance. A path continues at receivers only if the lobe chosen there is not
//!   diffuse. Diffuse surfaces do not light others.

use super::policy::{Continuation, DirectionSampling, LightSampling, PathPolicy, PhotonLookups};
use super::settings::Settings;
use crate::plan::Effects;

/// Policy of `distributed`.
pub(super) fn policy(effects: Effects, _: &Settings) -> PathPolicy {
    PathPolicy {
        effects,
        samples: 4,
        shares_paths: false,
        direct_light: true,
        light_sampling: LightSampling::OneRay,
        continuation: Continuation::Glossy,
        directions: DirectionSampling::OneLobe,
        counts_caustics: true,
        min_throughput: 0.0,
        photons: PhotonLookups::Never,
        shrinking_radii: true,
    }
}
