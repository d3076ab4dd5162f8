//! Prefix rays: extra camera paths that end at the first receiver.

use crate::stats::Counters;
use std::sync::Arc;

/// Weights of the light that a camera path or prefix ray finds up to its first receiver.
///
/// The *prefix* of a camera path is its part up to the first receiver. *Prefix rays* trace only
/// prefixes. A pixel's n camera paths and m prefix rays find the same emission, so they share it by
/// weights. One camera path and l prefix rays share the photon estimate at the first receiver. If
/// the pass has slices of the shutter interval, one camera path of each slice reads photon maps.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrefixWeights {
    /// Weight n/(n + m) of light that camera paths and prefix rays both find: emission, environment
    /// light, and direct light at casters.
    ///
    /// The pixel has n camera paths and m prefix rays.
    pub up_to_receiver: f32,
    /// Number of camera paths of the pixel, or of its prefix rays, that read photon maps: those
    /// with the lowest sample indices.
    pub lookups: u32,
    /// Weight of a photon estimate: 1/(k + l) for camera paths and n/(m·(k + l)) for prefix rays.
    ///
    /// Of the pixel's n camera paths, k read photon maps. Of its m prefix rays, l read photon maps.
    /// The `lookup_scale` of an estimate is this weight times n, or times m for prefix rays.
    pub lookup: f32,
    /// True for prefix rays, which end at their first receiver; false for camera paths.
    pub ends_at_receiver: bool,
}

/// Number of prefix rays of a pixel, and the number of those that read photon maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PrefixRayCount {
    pub rays: u8,
    pub lookups: u8,
}

impl Default for PrefixWeights {
    /// Returns the weights of camera paths in a pixel without prefix rays.
    fn default() -> Self {
        Self { up_to_receiver: 1.0, lookups: 1, lookup: 1.0, ends_at_receiver: false }
    }
}

impl PrefixWeights {
    /// Returns the weights of the light that each of a pixel's `samples` camera paths finds.
    /// `prefix` counts the prefix rays of the pixel.
    ///
    /// The first `lookups` camera paths read photon maps.
    pub fn of_camera_paths(samples: u32, lookups: u32, prefix: PrefixRayCount) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.rays));
        let lookup = 1.0 / (lookups as f32 + f32::from(prefix.lookups));
        Self { up_to_receiver: n / (n + m), lookups, lookup, ends_at_receiver: false }
    }

    /// Returns the weights of the light that each prefix ray of a pixel finds. `prefix` counts the
    /// pixel's prefix rays, at least one.
    ///
    /// The pixel has `samples` camera paths; the first `lookups` of them read photon maps.
    pub fn of_prefix_rays(samples: u32, lookups: u32, prefix: PrefixRayCount) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.rays));
        let weights = Self::of_camera_paths(samples, lookups, prefix);
        let lookup = weights.lookup * n / m;
        Self { lookups: prefix.lookups.into(), lookup, ends_at_receiver: true, ..weights }
    }
}

/// Number of prefix rays of each pixel, which a pilot chose, and their work.
#[derive(Clone, Debug)]
pub(super) struct PrefixRayCounts {
    /// Number of prefix rays of each pixel, and how many of them read photon maps, by rows from the
    /// top.
    pub counts: Arc<[PrefixRayCount]>,
    /// Rays and gathered photons of all prefix rays of a pass.
    pub expected_work: Counters,
}

impl PrefixRayCounts {
    /// Returns the number of prefix rays per pixel, as a mean over the picture.
    pub fn mean_rays_per_pixel(&self) -> f64 {
        self.counts.iter().map(|n| f64::from(n.rays)).sum::<f64>() / self.counts.len().max(1) as f64
    }
}
