//! Prefix rays: camera rays that end at their first receiver, beside whole camera paths.

use crate::color::Rgb;
use crate::stats::Counters;
use std::sync::Arc;

/// Weights and sums of the light that the camera paths of a pixel find up to their first receiver.
///
/// The *prefix* of a camera path is its part up to the first receiver. A pixel's n camera paths and
/// its m prefix rays, which trace nothing but prefixes, share the emission that they find. One
/// camera path and l of the prefix rays share the photon estimate at the first receiver. If the
/// pass has slices of the shutter interval, k of the camera paths read maps: one for each slice.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrefixLight {
    /// Weight n/(n + m) of emission, environment light and direct light at casters.
    pub found_weight: f32,
    /// Number of the rays that read photon maps: the first ones by sample index.
    pub lookups: u32,
    /// Factor of the photon estimate, relative to the number of stratified samples: 1/(k + l) for
    /// camera paths, n/(m·(k + l)) for prefix rays, where k is 1 without slices.
    pub lookup_weight: f32,
    /// True for prefix rays: they end at their first receiver.
    pub ends_at_receiver: bool,
    /// Sum of the weighted light found \[W/(m² sr)].
    pub found: Rgb,
    /// Sum of the weighted photon estimates \[W/(m² sr)].
    pub photons: Rgb,
}

/// Number of prefix rays of a pixel, and the number of those that read photon maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PrefixRayCount {
    pub rays: u8,
    pub lookups: u8,
}

impl Default for PrefixLight {
    /// Returns the weights of a pixel without prefix rays.
    fn default() -> Self {
        Self {
            found_weight: 1.0,
            lookups: 1,
            lookup_weight: 1.0,
            ends_at_receiver: false,
            found: Rgb::ZERO,
            photons: Rgb::ZERO,
        }
    }
}

impl PrefixLight {
    /// Returns the weights of `samples` camera paths beside `prefix` prefix rays. The first
    /// `lookups` camera paths read photon maps.
    pub fn of_camera_paths(samples: u32, lookups: u32, prefix: PrefixRayCount) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.rays));
        let lookup_weight = 1.0 / (lookups as f32 + f32::from(prefix.lookups));
        Self { found_weight: n / (n + m), lookups, lookup_weight, ..Self::default() }
    }

    /// Returns the weights of `prefix` prefix rays, at least one, beside `samples` camera paths.
    /// The first `lookups` of these paths read photon maps.
    pub fn of_prefix_rays(samples: u32, lookups: u32, prefix: PrefixRayCount) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.rays));
        let weights = Self::of_camera_paths(samples, lookups, prefix);
        let lookup_weight = weights.lookup_weight * n / m;
        Self { lookups: prefix.lookups.into(), lookup_weight, ends_at_receiver: true, ..weights }
    }
}

/// Numbers of prefix rays that a pilot found.
#[derive(Clone, Debug)]
pub(super) struct PrefixRayCounts {
    /// Numbers of prefix rays of each pixel, by rows from the top.
    pub counts: Arc<[PrefixRayCount]>,
    /// Rays and gathered photons of all prefix rays of a pass.
    pub expected_work: Counters,
}

impl PrefixRayCounts {
    /// Returns the mean number of prefix rays per pixel.
    pub fn mean(&self) -> f64 {
        self.counts.iter().map(|n| f64::from(n.rays)).sum::<f64>() / self.counts.len().max(1) as f64
    }
}
