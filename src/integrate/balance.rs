//! Division of the work of a pass between camera rays and photons.
//!
//! The noise of a pass is a sum of parts. NoiseSource i has variance σᵢ²/nᵢ and work cᵢ·nᵢ for n samples.
//! For constant work the variance is least if nᵢ ∝ σᵢ/√cᵢ. Gather radii stay, so the bias stays.

use crate::color::{self, Rgb};
use crate::stats::Counters;

/// Numbers of samples of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Balance {
    /// Camera rays per pixel.
    pub samples: u32,
    /// Photon paths of the global map; `None` without that map.
    pub photons: Option<u32>,
    /// Photon paths aimed at caustic casters; `None` without such paths.
    pub caustic_photons: Option<u32>,
}

/// Greatest factor by which a number may change: a pilot is uncertain.
const MAX_CHANGE: f64 = 4.0;

// Work is counted in rays of photons, of 0.1 µs each; the other costs follow from
// docs/measurements/.

/// Work of a ray of a camera path with its shading, in rays of photons.
const CAMERA_RAY_WORK: f64 = 2.0;

/// Work of storing and indexing a photon, in rays of photons.
const STORED_PHOTON_WORK: f64 = 1.5;

/// Work of a photon in an estimate, in rays of photons.
const GATHERED_PHOTON_WORK: f64 = 0.2;

/// One source of noise in a pass: camera rays, or the photon paths of one map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NoiseSource {
    /// Variance of one sample: of a camera ray in every pixel, or of a photon path.
    pub variance: f64,
    /// Work of one sample, in rays of photons.
    pub cost: f64,
    /// Default number of samples.
    pub count: f64,
}

impl NoiseSource {
    fn is_active(&self) -> bool {
        self.variance > 0.0 && self.cost > 0.0 && self.count > 0.0 && self.variance.is_finite()
    }
}

/// Numbers of samples of each part that do the default work with the least noise, within
/// [`MAX_CHANGE`].
///
/// A part without noise keeps its number; its work is not counted.
pub(super) fn divide_work(parts: &[NoiseSource; 3]) -> [f64; 3] {
    let work = |numbers: &[f64; 3]| -> f64 {
        let active = parts.iter().zip(numbers).filter(|(p, _)| p.is_active());
        active.map(|(p, n)| p.cost * n).sum()
    };
    let numbers = |scale: f64| {
        parts.map(|p| {
            let best = scale * (p.variance / p.cost).sqrt();
            if p.is_active() { best.clamp(p.count / MAX_CHANGE, p.count * MAX_CHANGE) } else { p.count }
        })
    };
    let given = work(&parts.map(|p| p.count));
    let (mut low, mut high) = (0.0, 0.0f64);
    for p in parts.iter().filter(|p| p.is_active()) {
        high = high.max(MAX_CHANGE * p.count / (p.variance / p.cost).sqrt());
    }
    // The work grows with the scale; sixty bisections exhaust double precision.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if work(&numbers(middle)) > given { high = middle } else { low = middle }
    }
    numbers(low)
}

/// Work of camera paths, in rays of photons.
pub(super) fn camera_path_work(counters: &Counters) -> f64 {
    CAMERA_RAY_WORK * (counters.camera_rays + counters.continuation_rays + counters.shadow_rays) as f64
}

/// Work of photon estimates, in rays of photons.
pub(super) fn gathering_work(counters: &Counters) -> f64 {
    GATHERED_PHOTON_WORK * counters.gathered_photons as f64
}

/// Work of storing and indexing photons, in rays of photons.
pub(super) fn photon_storage_work(photons: u64) -> f64 {
    STORED_PHOTON_WORK * photons as f64
}

/// Variance of two independent estimates of the same points, relative to the mean radiance `light`
/// there.
pub(super) fn relative_variance(one: &[Rgb], other: &[Rgb], light: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = light.iter().copied().filter(|l| *l > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(median) = sorted.get(sorted.len() / 2) else { return 0.0 };
    let square = |((a, b), light): ((&Rgb, &Rgb), &f64)| {
        let difference = f64::from(color::channel_mean(*a)) - f64::from(color::channel_mean(*b));
        0.5 * difference * difference / (light * light + median * median)
    };
    let sum: f64 = one.iter().zip(other).zip(light).map(square).filter(|s| s.is_finite()).sum();
    sum / one.len().max(1) as f64
}

#[cfg(test)]
mod tests;
