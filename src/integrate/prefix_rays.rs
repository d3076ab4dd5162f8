//! Prefix rays: extra camera paths that end at the first receiver.

use super::lamp_images::LampImages;
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
    /// The pixel has n camera paths and m prefix rays. If prefix rays are aimed at images of lamps,
    /// [`FilmPointRayCounts`] gives each ray a weight of its own.
    pub up_to_receiver: f32,
    /// Number of camera paths of the pixel, or of its prefix rays, that read photon maps: those
    /// with the lowest sample indices.
    pub lookup_count: u32,
    /// Weight of a photon estimate: 1/(k + l) for camera paths and n/(m·(k + l)) for prefix rays.
    ///
    /// Of the pixel's n camera paths, k read photon maps. Of its m prefix rays, l read photon maps.
    /// The `lookup_scale` of an estimate is this weight times n, or times m for prefix rays.
    pub lookup_weight: f32,
    /// True for prefix rays, which end at their first receiver; false for camera paths.
    pub ends_at_receiver: bool,
}

/// Numbers of prefix rays of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PixelPrefixRayCounts {
    /// Number of prefix rays that the pixel filter distributes.
    pub unaimed: u8,
    /// Number of the unaimed prefix rays that read photon maps.
    pub lookups: u8,
    /// Number of prefix rays that are aimed at images of lamps; `unaimed` does not include them.
    pub aimed: u8,
}

impl Default for PrefixWeights {
    /// Returns the weights of camera paths in a pixel without prefix rays.
    fn default() -> Self {
        Self { up_to_receiver: 1.0, lookup_count: 1, lookup_weight: 1.0, ends_at_receiver: false }
    }
}

impl PrefixWeights {
    /// Returns the weights of the light that each of a pixel's `samples` camera paths finds.
    /// `prefix` counts the prefix rays of the pixel.
    ///
    /// The first `lookups` camera paths read photon maps.
    pub fn of_camera_paths(samples: u32, lookups: u32, prefix: PixelPrefixRayCounts) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.unaimed));
        let lookup = 1.0 / (lookups as f32 + f32::from(prefix.lookups));
        Self { up_to_receiver: n / (n + m), lookup_count: lookups, lookup_weight: lookup, ends_at_receiver: false }
    }

    /// Returns the weights of the light that each prefix ray of a pixel finds. `prefix` counts the
    /// pixel's prefix rays, at least one.
    ///
    /// The pixel has `samples` camera paths; the first `lookups` of them read photon maps.
    pub fn of_prefix_rays(samples: u32, lookups: u32, prefix: PixelPrefixRayCounts) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.unaimed));
        let weights = Self::of_camera_paths(samples, lookups, prefix);
        let lookup = weights.lookup_weight * n / m;
        Self { lookup_count: prefix.lookups.into(), lookup_weight: lookup, ends_at_receiver: true, ..weights }
    }

    /// Returns the weights of prefix rays that are aimed at images of lamps. `up_to_receiver` is 1
    /// here; the caller replaces it by [`FilmPointRayCounts::up_to_receiver_weight`] for each ray.
    pub fn of_aimed_rays() -> Self {
        Self { lookup_count: 0, lookup_weight: 0.0, ends_at_receiver: true, ..Self::default() }
    }
}

/// Numbers of rays of a pixel that find images of lamps, from which the weights of their light
/// follow by the balance heuristic.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilmPointRayCounts {
    /// Number of camera paths.
    camera_paths: f32,
    /// Number of camera paths, plus the number of prefix rays that the pixel filter distributes.
    filtered_rays: f32,
    /// Number of prefix rays that are aimed at images of lamps.
    aimed_rays: f32,
}

impl FilmPointRayCounts {
    /// Returns the weights of a pixel with `samples` camera paths and the prefix rays `prefix`.
    pub fn new(samples: u32, prefix: PixelPrefixRayCounts) -> Self {
        let camera_paths = samples as f32;
        let filtered_rays = camera_paths + f32::from(prefix.unaimed);
        Self { camera_paths, filtered_rays, aimed_rays: prefix.aimed.into() }
    }

    /// Returns the weight of light that a ray finds up to its first receiver.
    ///
    /// `filter_pdf` and `aimed_pdf` are the pdfs \[1/pixel²] with which the pixel filter and aiming
    /// sample the film point of the ray. The weight is 0 if both are 0.
    pub fn up_to_receiver_weight(&self, filter_pdf: f32, aimed_pdf: f32) -> f32 {
        let filtered = self.filtered_rays * filter_pdf;
        let total = filtered + self.aimed_rays * aimed_pdf;
        if total > 0.0 { self.camera_paths * filter_pdf / total } else { 0.0 }
    }
}

/// Numbers of prefix rays of each pixel, which a pilot chose, the images of lamps at which some are
/// aimed, and the expected work of all.
#[derive(Clone, Debug)]
pub(super) struct PrefixRayAllocation {
    /// Number of prefix rays of each pixel, and how many of them read photon maps, by rows from the
    /// top.
    pub counts: Arc<[PixelPrefixRayCounts]>,
    /// Images of lamps in the pixels that have aimed rays.
    pub lamp_images: LampImages,
    /// Expected counts of the rays and gathered photons of all prefix rays of a pass.
    pub expected_work: Counters,
}

impl PrefixRayAllocation {
    /// Returns the number of prefix rays per pixel, as a mean over the picture.
    pub fn mean_rays_per_pixel(&self) -> f64 {
        self.counts.iter().map(|n| f64::from(n.unaimed) + f64::from(n.aimed)).sum::<f64>()
            / self.counts.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays of all kinds together count light at a film point once: their densities times the
    /// weight, divided by the number of camera paths, add up to the pdf of the filter.
    #[test]
    fn aimed_rays_share_light_with_other_rays() {
        let prefix = PixelPrefixRayCounts { unaimed: 3, lookups: 0, aimed: 5 };
        let weights = FilmPointRayCounts::new(8, prefix);
        for (filter_pdf, aimed_pdf) in [(0.7f32, 0.0), (0.7, 1e-3), (0.2, 400.0), (0.0, 2.0)] {
            let density = 11.0 * filter_pdf + 5.0 * aimed_pdf;
            let weight = weights.up_to_receiver_weight(filter_pdf, aimed_pdf);
            let counted = density * weight / 8.0;
            assert!((counted - filter_pdf).abs() <= 1e-6, "{filter_pdf} {aimed_pdf}: {counted}");
        }
    }
}
