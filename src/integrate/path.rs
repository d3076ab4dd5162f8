//! `path`: path tracing, unbiased (Veach 1997, chapters 9 and 10).
//!
//! # Algorithm
//! - **Prepare**: nothing.
//! - **Each pass**: trace camera paths. At each receiver a path does next-event estimation and
//!   continues in a direction sampled by the BSDF. Light that both could find is weighted by the
//!   balance heuristic.

use super::policy::{Continuation, DirectionSampling, LightSampling, PathPolicy, PhotonLookups};
use super::settings::Settings;
use crate::plan::{Effect, Effects};

/// Policy of `path`.
pub(super) fn policy(effects: Effects, _: &Settings) -> PathPolicy {
    let interreflection = effects.has(Effect::Interreflection);
    PathPolicy {
        effects,
        samples: 4,
        shares_paths: false,
        direct_light: true,
        light_sampling: LightSampling::OneRay,
        continuation: if interreflection { Continuation::Always } else { Continuation::Never },
        directions: DirectionSampling::Bsdf,
        counts_caustics: effects.has(Effect::Caustics),
        min_throughput: 0.0,
        photons: PhotonLookups::Never,
        shrinking_radii: true,
    }
}
