//! Balance of camera rays against photon paths in a pass, for least noise at constant work.
//!
//! The variance of a pass is a sum over sources of noise: camera rays, photon paths that start in
//! all directions, and photon paths aimed at casters such as glass. With nᵢ samples, source i has
//! variance σᵢ²/nᵢ and work cᵢ·nᵢ. For constant work, the variance is least if nᵢ ∝ σᵢ/√cᵢ.
//!
//! The ray-photon balance does not change gather radii, and so keeps the bias of photon estimates.
//! Radii change with the number of photon paths only if the setting `gather_k` limits the photons
//! of an estimate.

use crate::color::{self, Rgb};
use crate::math::positive_median;
use crate::stats::Counters;

/// Numbers of camera rays and photon paths per pass, chosen by a pilot (small simulation before the
/// first pass) for least noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct RayPhotonBalance {
    /// Number of camera rays per pixel.
    #[serde(rename = "samples")]
    pub samples_per_pixel: u32,
    /// Number of unaimed photon paths, which start in all directions: a value for
    /// [`Settings::unaimed_paths`](super::Settings::unaimed_paths). `None` without such paths.
    #[serde(rename = "photons")]
    pub unaimed_paths: Option<u32>,
    /// Number of photon paths aimed at casters, such as mirrors and glass: a value for
    /// [`Settings::aimed_paths`](super::Settings::aimed_paths). `None` without such paths.
    #[serde(rename = "caustic_photons")]
    pub aimed_paths: Option<u32>,
}

/// Largest factor by which the ray-photon-balance pilot may raise or lower the number of camera
/// rays or photon paths. The bound limits the harm of a noisy pilot.
const MAX_CHANGE: f64 = 4.0;

// All work is in units of tracing one photon ray, about 0.1 µs. The values come from
// docs/measurements/.

/// Estimated time to trace and shade one ray of a camera path (camera ray, later segment or shadow
/// ray), divided by the time to trace one photon ray.
const CAMERA_RAY_WORK: f64 = 2.0;

/// Estimated time to store and index one photon, divided by the time to trace one photon ray.
const STORED_PHOTON_WORK: f64 = 1.5;

/// Estimated time that a density estimate takes for each photon that it uses, divided by the time
/// to trace one photon ray.
pub(super) const GATHERED_PHOTON_WORK: f64 = 0.2;

/// Estimated time that a density estimate takes without its photons, divided by the time to trace
/// one photon ray. Each photon that the estimate uses adds [`GATHERED_PHOTON_WORK`].
pub(super) const LOOKUP_WORK: f64 = 20.0;

/// One source of noise in a pass: the camera rays, the photon paths that start in all directions,
/// or the photon paths aimed at casters such as glass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NoiseSource {
    /// Relative variance that this source would cause in the picture of a pass with a single
    /// sample: one camera ray per pixel, or one photon path. With n samples, the variance is 1/n of
    /// this value.
    pub single_sample_variance: f64,
    /// Estimated time of one sample (one camera ray per pixel, or one photon path), divided by the
    /// time to trace one photon ray.
    pub work_per_sample: f64,
    /// Number of samples (camera rays per pixel, or photon paths) before the ray-photon balance
    /// changes it.
    pub sample_count: f64,
}

impl NoiseSource {
    /// True if the source has noise that more or fewer samples can change: a finite positive
    /// variance, and positive numbers of samples and work.
    fn has_noise(&self) -> bool {
        self.single_sample_variance > 0.0
            && self.work_per_sample > 0.0
            && self.sample_count > 0.0
            && self.single_sample_variance.is_finite()
    }
}

/// Returns the sample counts of all sources that give a pass the least noise at the same total
/// work.
///
/// A sample is one camera ray per pixel, or one photon path. Each count is multiplied or divided by
/// at most [`MAX_CHANGE`]. A source without noise keeps its count, and its work is ignored.
pub(super) fn balance_sample_counts(sources: &[NoiseSource; 3]) -> [f64; 3] {
    let work = |numbers: &[f64; 3]| -> f64 {
        let active = sources.iter().zip(numbers).filter(|(p, _)| p.has_noise());
        active.map(|(p, n)| p.work_per_sample * n).sum()
    };
    let numbers = |scale: f64| {
        sources.map(|p| {
            let best = scale * (p.single_sample_variance / p.work_per_sample).sqrt();
            if p.has_noise() {
                best.clamp(p.sample_count / MAX_CHANGE, p.sample_count * MAX_CHANGE)
            } else {
                p.sample_count
            }
        })
    };
    let initial_work = work(&sources.map(|p| p.sample_count));
    let (mut low, mut high) = (0.0, 0.0f64);
    for p in sources.iter().filter(|p| p.has_noise()) {
        high = high.max(MAX_CHANGE * p.sample_count / (p.single_sample_variance / p.work_per_sample).sqrt());
    }
    // Bisect for the scale: the work grows with it. Sixty steps exhaust double precision.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if work(&numbers(middle)) > initial_work { high = middle } else { low = middle }
    }
    numbers(low)
}

/// Returns the work of tracing camera paths, in units of tracing one photon ray. `counters` holds
/// the numbers of rays of these paths.
pub(super) fn camera_path_work(counters: &Counters) -> f64 {
    CAMERA_RAY_WORK * (counters.camera_rays + counters.continuation_rays + counters.shadow_rays) as f64
}

/// Returns the work of fetching photons for density estimates, in units of tracing one photon ray.
/// `counters` holds the number of fetched photons. The fixed work of each estimate,
/// [`LOOKUP_WORK`], is not included.
pub(super) fn gathering_work(counters: &Counters) -> f64 {
    GATHERED_PHOTON_WORK * counters.gathered_photons as f64
}

/// Returns the work of storing and indexing `photons` photons, in units of tracing one photon ray.
pub(super) fn photon_storage_work(photons: u64) -> f64 {
    STORED_PHOTON_WORK * photons as f64
}

/// Returns the relative variance of a radiance estimate, as a mean over points of the film; 0 if
/// all points are black.
///
/// `one` and `other` are two independent estimates at the same points. `light` is the mean radiance
/// L at each point. M is the median of all positive L. The relative variance at a point is (`one` −
/// `other`)²/2 / (L² + M²). A point at which this value is not finite counts as 0.
pub(super) fn relative_variance(one: &[Rgb], other: &[Rgb], light: &[f64]) -> f64 {
    let Some(median) = positive_median(light.iter().copied()) else { return 0.0 };
    let square = |((a, b), light): ((&Rgb, &Rgb), &f64)| {
        let difference = f64::from(color::channel_mean(*a)) - f64::from(color::channel_mean(*b));
        0.5 * difference * difference / (light * light + median * median)
    };
    let sum: f64 = one.iter().zip(other).zip(light).map(square).filter(|s| s.is_finite()).sum();
    sum / one.len().max(1) as f64
}

#[cfg(test)]
mod tests;
