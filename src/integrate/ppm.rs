//! `ppm`: progressive photon mapping (Hachisuka, Ogaki and Jensen 2008).
//!
//! # Algorithm
//! - **Prepare**: aim and guide photon emission, find gather radii, and guide shadow rays.
//! - **Each pass**: trace new photons. All passes trace the same camera paths, so the gather points
//!   stay fixed. Gather radii shrink by the law of independent passes (Knaus and Zwicker 2011), not
//!   by statistics of each gather point. So any pass can be computed alone.
//!
//! More passes reduce the noise of photons, but not the noise of camera paths.

use super::policy::{LightSampling, PathPolicy};
use super::settings::Settings;
use super::sppm;
use crate::scene::Effects;

/// Returns the rules of camera paths for progressive photon mapping.
pub(super) fn path_policy(effects: Effects, settings: &Settings) -> PathPolicy {
    PathPolicy {
        // Later passes trace the same camera rays, so the first pass must have enough of them.
        default_samples_per_pixel: 4,
        passes_share_paths: true,
        light_sampling: LightSampling::Rays(1),
        ..sppm::path_policy(effects, settings)
    }
}
