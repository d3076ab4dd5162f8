//! Prefix rays: extra camera paths that end at the first *receiver*, a surface that stores photons.
//! Scenes with media that store photons have no prefix rays.

use super::lamp_images::LampImages;
use crate::stats::Counters;
use std::sync::Arc;

/// Weights of the light that a camera path or *prefix ray* finds up to its first *receiver*, the
/// first surface or medium that stores photons. A prefix ray is an extra camera path that ends
/// there.
///
/// A pixel's camera paths and prefix rays find the same emission, so the weights keep it from
/// counting twice. Only a few of these rays evaluate the photon estimate at the first receiver: one
/// camera path, and some of the prefix rays. If the pass has slices of the shutter interval, one
/// camera path of each slice evaluates it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrefixWeights {
    /// Weight n/(n + m) of light that camera paths and prefix rays both find: emission, environment
    /// light, and direct light at glossy casters such as rough glass.
    ///
    /// The pixel has n camera paths and m prefix rays. If some prefix rays are aimed at lamp images
    /// (film regions where camera rays meet a small lamp), [`LampImageRayCounts`] gives each ray a
    /// weight of its own.
    pub up_to_receiver: f32,
    /// Number of rays with these weights that evaluate photon estimates, among a pixel's camera
    /// paths or among its prefix rays. The rays with the lowest sample indices do so.
    pub lookup_count: u32,
    /// Weight of a photon estimate: 1/(k + l) for camera paths and n/(m·(k + l)) for prefix rays.
    ///
    /// The pixel has n camera paths, and k of them read photon maps. It also has m prefix rays, and
    /// l of them read photon maps. The factor `lookup_scale` on an estimate is this weight times n
    /// for camera paths, and this weight times m for prefix rays.
    pub lookup_weight: f32,
    /// True for prefix rays, which end at their first receiver (surface that stores photons); false
    /// for camera paths.
    pub ends_at_receiver: bool,
}

/// Numbers of prefix rays of a pixel: extra camera paths that end at the first surface that stores
/// photons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PixelPrefixRayCounts {
    /// Number of unaimed prefix rays (extra camera rays that stop at the first surface that stores
    /// photons). The pixel filter distributes their film points.
    pub unaimed: u8,
    /// Number of the `unaimed` prefix rays that also evaluate a photon estimate at their end.
    pub lookups: u8,
    /// Number of prefix rays that are aimed at lamp images, the parts of the film at which camera
    /// rays meet a small lamp. `unaimed` does not include them.
    pub aimed: u8,
}

impl Default for PrefixWeights {
    /// Returns the weights of camera paths in a pixel without prefix rays (extra camera rays that
    /// stop at the first surface that stores photons).
    fn default() -> Self {
        Self { up_to_receiver: 1.0, lookup_count: 1, lookup_weight: 1.0, ends_at_receiver: false }
    }
}

impl PrefixWeights {
    /// Returns the weights of the light that each of a pixel's `samples` camera paths finds.
    /// `prefix` counts the pixel's prefix rays: extra camera rays that stop at the first surface
    /// that stores photons.
    ///
    /// The first `lookups` camera paths read photon maps.
    pub fn of_camera_paths(samples: u32, lookups: u32, prefix: PixelPrefixRayCounts) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.unaimed));
        let lookup = 1.0 / (lookups as f32 + f32::from(prefix.lookups));
        Self { up_to_receiver: n / (n + m), lookup_count: lookups, lookup_weight: lookup, ends_at_receiver: false }
    }

    /// Returns the weights of the light that each prefix ray (extra camera ray that stops at the
    /// first surface that stores photons) of a pixel finds. `prefix` counts these rays, at least
    /// one.
    ///
    /// The pixel has `samples` camera paths; the first `lookups` of them read photon maps.
    pub fn of_prefix_rays(samples: u32, lookups: u32, prefix: PixelPrefixRayCounts) -> Self {
        let (n, m) = (samples as f32, f32::from(prefix.unaimed));
        let weights = Self::of_camera_paths(samples, lookups, prefix);
        let lookup = weights.lookup_weight * n / m;
        Self { lookup_count: prefix.lookups.into(), lookup_weight: lookup, ends_at_receiver: true, ..weights }
    }

    /// Returns the weights of prefix rays that are aimed at lamp images, the film regions where
    /// camera rays meet a small lamp. `up_to_receiver` is only a placeholder (1): the caller
    /// replaces it by [`LampImageRayCounts::up_to_receiver_weight`] for each ray.
    pub fn of_aimed_rays() -> Self {
        Self { lookup_count: 0, lookup_weight: 0.0, ends_at_receiver: true, ..Self::default() }
    }
}

/// Numbers of a pixel's rays that can find lamp images, the film regions where camera rays meet a
/// small lamp. These rays are camera paths, unaimed prefix rays, and prefix rays aimed at lamp
/// images. From the numbers, the balance heuristic computes the weights of the light that the rays
/// find.
#[derive(Clone, Copy, Debug)]
pub(super) struct LampImageRayCounts {
    /// Number of camera paths.
    camera_paths: f32,
    /// Number of rays whose film points the pixel filter distributes: camera paths and unaimed
    /// prefix rays.
    filtered_rays: f32,
    /// Number of prefix rays that are aimed at lamp images, the film regions where camera rays meet
    /// a small lamp.
    aimed_rays: f32,
}

impl LampImageRayCounts {
    /// Counts the rays of a pixel that has `samples` camera paths and the prefix rays `prefix`:
    /// extra camera rays that stop at the first surface that stores photons.
    pub fn new(samples: u32, prefix: PixelPrefixRayCounts) -> Self {
        let camera_paths = samples as f32;
        let filtered_rays = camera_paths + f32::from(prefix.unaimed);
        Self { camera_paths, filtered_rays, aimed_rays: prefix.aimed.into() }
    }

    /// Returns the MIS weight (balance heuristic) of the light that a ray finds up to its first
    /// receiver, the surface or medium that stores photons.
    ///
    /// `filter_pdf` and `aimed_pdf` are the pdfs \[1/pixel²] with which the pixel filter and aiming
    /// sample the film point of the ray. The weight is 0 if both are 0.
    pub fn up_to_receiver_weight(&self, filter_pdf: f32, aimed_pdf: f32) -> f32 {
        let filtered = self.filtered_rays * filter_pdf;
        let total = filtered + self.aimed_rays * aimed_pdf;
        if total > 0.0 { self.camera_paths * filter_pdf / total } else { 0.0 }
    }
}

/// Result of the pilot (small simulation before the first pass) for prefix rays: the number of
/// prefix rays of each pixel, the lamp images (film regions where camera rays meet a small lamp) at
/// which some of these rays are aimed, and the expected work of all prefix rays. Prefix rays are
/// extra camera paths that end at the first surface that stores photons.
#[derive(Clone, Debug)]
pub(super) struct PrefixRayAllocation {
    /// Number of prefix rays (extra camera rays that stop at the first surface that stores photons)
    /// of each pixel, and the number of them that read photon maps, by rows from the top.
    pub counts: Arc<[PixelPrefixRayCounts]>,
    /// Lamp images (film regions where camera rays meet a small lamp), for the pixels with prefix
    /// rays aimed at them.
    pub lamp_images: LampImages,
    /// Expected counts of the rays and gathered photons of all prefix rays of a pass.
    pub expected_work: Counters,
}

impl PrefixRayAllocation {
    /// Returns the number of prefix rays (extra camera rays that stop at the first surface that
    /// stores photons) per pixel, as a mean over the picture.
    pub fn mean_rays_per_pixel(&self) -> f64 {
        self.counts.iter().map(|n| f64::from(n.unaimed) + f64::from(n.aimed)).sum::<f64>()
            / self.counts.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All rays of a pixel together count the light at a film point once. In a formula: (sum of the
    /// rays' densities at the point)·weight/(number of camera paths) = pdf of the pixel filter.
    #[test]
    fn aimed_and_other_rays_count_light_once() {
        let prefix = PixelPrefixRayCounts { unaimed: 3, lookups: 0, aimed: 5 };
        let weights = LampImageRayCounts::new(8, prefix);
        for (filter_pdf, aimed_pdf) in [(0.7f32, 0.0), (0.7, 1e-3), (0.2, 400.0), (0.0, 2.0)] {
            let density = 11.0 * filter_pdf + 5.0 * aimed_pdf;
            let weight = weights.up_to_receiver_weight(filter_pdf, aimed_pdf);
            let counted = density * weight / 8.0;
            assert!((counted - filter_pdf).abs() <= 1e-6, "{filter_pdf} {aimed_pdf}: {counted}");
        }
    }
}
