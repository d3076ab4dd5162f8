//! Search for the numbers of prefix rays that make a pass most efficient.

use super::variances::RelativePixelVariances;
use crate::integrate::prefix_rays::PixelPrefixRayCounts;
use rayon::prelude::*;

/// Number of iterations of each search for the numbers of prefix rays (extra camera rays that stop
/// at the first surface that stores photons) that minimize variance times work.
const SEARCH_STEPS: u32 = 20;

/// Largest work of all prefix rays (extra camera rays that stop at the first surface that stores
/// photons) of a pass, divided by the work of the rest of the pass.
///
/// The bound limits wasted work where the pilot met a rare bright ray by chance.
pub(super) const MAX_RELATIVE_WORK: f64 = 0.3;

/// Mean number of prefix rays (extra camera rays that stop at the first surface that stores
/// photons) per pixel below which a pass traces none at all.
const MIN_MEAN_COUNT: f64 = 1e-3;

/// Largest number of extra camera rays of one pixel that are aimed at lamp images, the film regions
/// where camera rays meet a small lamp.
const MAX_AIMED_RAYS: f64 = 64.0;

/// Relative standard deviations of the light of one ray: the square roots of
/// [`RelativePixelVariances`]. For least noise, numbers of rays are chosen in proportion to these
/// values.
struct PixelStandardDeviations {
    up_to_receiver: f64,
    photons: f64,
    lamp_images_aimed: f64,
    lamp_images_unaimed: f64,
}

/// Work of the parts of a pass, in units of tracing one photon ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct PassWork {
    /// Work of all camera paths of a pixel in a pass, in units of tracing one photon ray.
    pub camera_work_per_pixel: f64,
    /// Work of tracing, indexing and gathering the photons of a pass, divided by the number of
    /// pixels, in units of tracing one photon ray.
    pub photon_work_per_pixel: f64,
    /// Work of one prefix ray (extra camera ray that stops at the first surface that stores
    /// photons), without its photon estimate, in units of tracing one photon ray.
    pub work_per_prefix_ray: f64,
    /// Work of the photon estimates of one prefix ray (extra camera ray that stops at the first
    /// surface that stores photons), in units of tracing one photon ray.
    pub work_per_lookup: f64,
}

/// Returns the numbers of prefix rays of each pixel (extra camera rays that stop at the first
/// surface that stores photons) that minimize variance times work of a pass, within
/// [`MAX_RELATIVE_WORK`]. Returns `None` if almost no pixel needs prefix rays.
///
/// The noise of photons is not measured here. Another pilot has balanced rays and photons. So
/// photons are assumed to have the same ratio of variance to work as camera paths.
pub(super) fn efficient_ray_counts(
    variances: &[RelativePixelVariances],
    samples: u32,
    work: &PassWork,
) -> Option<Vec<PixelPrefixRayCounts>> {
    let n = f64::from(samples);
    let (ray_scale, lookup_scale) =
        (1.0 / work.work_per_prefix_ray.sqrt(), 1.0 / (work.work_per_prefix_ray + work.work_per_lookup).sqrt());
    // Compute the numbers of prefix rays, of photon lookups and of aimed rays in a pixel. They give
    // all pixels the same derivative of variance by work: −1/scale².
    let count = |deviations: &PixelStandardDeviations, scale: f64| {
        // `max` ignores NaN, so a NaN variance gives no ray.
        let whole = |n: f64| n.max(0.0).floor().min(f64::from(u8::MAX));
        let lookups = whole(deviations.photons * scale * lookup_scale - 1.0);
        let rays = whole(deviations.up_to_receiver * scale * ray_scale - n).max(lookups);
        let pays = deviations.lamp_images_unaimed * scale * ray_scale > n.sqrt();
        let aimed =
            if pays { whole(deviations.lamp_images_aimed * scale * ray_scale).clamp(1.0, MAX_AIMED_RAYS) } else { 0.0 };
        (rays, lookups, aimed)
    };
    let deviations = |v: &RelativePixelVariances| PixelStandardDeviations {
        up_to_receiver: v.up_to_receiver.sqrt(),
        photons: v.photon_estimate.sqrt(),
        lamp_images_aimed: v.lamp_images_aimed.sqrt(),
        lamp_images_unaimed: v.lamp_images_unaimed.sqrt(),
    };
    let deviations: Vec<PixelStandardDeviations> = variances.par_iter().map(deviations).collect();
    let pixels = variances.len() as f64;
    // The sum is serial: its rounding depends on the order.
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / pixels;
    let prefix_work = |scale: f64| {
        let pixel_work = |deviations: &PixelStandardDeviations| {
            let (rays, lookups, aimed) = count(deviations, scale);
            work.work_per_prefix_ray * (rays + aimed) + work.work_per_lookup * lookups
        };
        mean(deviations.par_iter().map(pixel_work).collect())
    };
    let rest_work = work.camera_work_per_pixel + work.photon_work_per_pixel;
    let photon_variance_factor = rest_work / work.camera_work_per_pixel.max(f64::MIN_POSITIVE);
    let variance = |scale: f64| {
        let pixel_variance = |(v, deviations): (&RelativePixelVariances, &PixelStandardDeviations)| {
            let (rays, lookups, aimed) = count(deviations, scale);
            let images = if aimed > 0.0 { v.lamp_images_aimed / aimed } else { v.lamp_images_unaimed / n };
            photon_variance_factor * v.from_receiver / n
                + v.up_to_receiver / (n + rays)
                + v.photon_estimate / (1.0 + lookups)
                + images
        };
        mean(variances.par_iter().zip(&deviations).map(pixel_variance).collect())
    };

    // At the least product of variance and work, 1/scale² is the variance over the work of a pass.
    let mut scale = 0.0;
    for _ in 0..SEARCH_STEPS {
        let next = ((rest_work + prefix_work(scale)) / variance(scale)).sqrt();
        if !next.is_finite() {
            return None;
        }
        scale = next;
    }

    // If the work of prefix rays is above the limit, bisect for fewer rays.
    if prefix_work(scale) > MAX_RELATIVE_WORK * rest_work {
        let (mut low, mut high) = (0.0, scale);
        for _ in 0..SEARCH_STEPS {
            let middle = 0.5 * (low + high);
            if prefix_work(middle) > MAX_RELATIVE_WORK * rest_work { high = middle } else { low = middle }
        }
        scale = low;
    }
    let whole = |deviations: &PixelStandardDeviations| {
        let (rays, lookups, aimed) = count(deviations, scale);
        PixelPrefixRayCounts { unaimed: rays as u8, lookups: lookups as u8, aimed: aimed as u8 }
    };
    let counts: Vec<PixelPrefixRayCounts> = deviations.par_iter().map(whole).collect();
    let mean_count = counts.iter().map(|n| f64::from(n.unaimed) + f64::from(n.aimed)).sum::<f64>() / pixels;
    (mean_count >= MIN_MEAN_COUNT).then_some(counts)
}
