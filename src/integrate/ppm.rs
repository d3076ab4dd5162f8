//! `ppm`: progressive photon mapping (Hachisuka, Ogaki and Jensen 2008).
//!
//! # Algorithm
//! - **Prepare**: as `sppm`, but camera rays are not balanced against photons.
//! - **Each pass**: trace new photons, but the same camera paths as all other passes. The gather
//!   points of the picture therefore stay. Radii follow the law of independent passes (Knaus and
//!   Zwicker 2011) instead of statistics kept at each gather point, so any pass can be computed
//!   alone.
//!
//! More passes do not refine what the camera samples once, such as the edge of an object within a
//! pixel.

use super::policy::{LightSampling, PathPolicy};
use super::settings::Settings;
use super::sppm;
use crate::plan::Effects;

/// Policy of `ppm`.
pub(super) fn policy(effects: Effects, settings: &Settings) -> PathPolicy {
    PathPolicy {
        // No later pass adds camera rays.
        samples: 4,
        shares_paths: true,
        light_sampling: LightSampling::Rays(1),
        ..sppm::policy(effects, settings)
    }
}
