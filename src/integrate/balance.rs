//! How a pass divides its work between photons and camera walks: as a pilot finds it useful.
//!
//! The noise of a pass is a sum of parts, each of which falls as 1 over what is spent on it: σᵢ²/nᵢ at a cost of cᵢ apiece. For the
//! same work the sum is least where nᵢ ∝ σᵢ/√cᵢ. Radii stay as they are, so bias does too.

use crate::color::{self, Rgb};
use crate::stats::Counters;

/// What a pass is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Balance {
    /// Camera rays a pixel.
    pub samples: u32,
    /// Photon paths of the global map; `None` where there is none.
    pub photons: Option<u32>,
    /// Photon paths aimed at casters; `None` where there are none.
    pub caustic_photons: Option<u32>,
}

/// Nothing becomes more than so many times what it was, or less than one over this: a pilot is no oracle.
const FARTHEST: f64 = 4.0;

// A tenth of a microsecond is a ray of a photon, by the tables of docs/measurements/; the others follow from them.

/// Work of a ray of a camera walk with its shading, in rays of photons.
const CAMERA_RAY: f64 = 2.0;

/// Work of storing and indexing a photon, in rays of photons.
const STORED: f64 = 1.5;

/// Work of a photon in an estimate, in rays of photons.
const GATHERED: f64 = 0.2;

/// A part of the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Part {
    /// Noise of one: a camera ray in every pixel, or a path.
    pub variance: f64,
    /// Work of one, in rays of photons.
    pub cost: f64,
    /// How many there are by default.
    pub count: f64,
}

impl Part {
    fn is_alive(&self) -> bool {
        self.variance > 0.0 && self.cost > 0.0 && self.count > 0.0 && self.variance.is_finite()
    }
}

/// Numbers of each part that do the same work with the least noise, within bounds; what makes no noise keeps its number, and is no
/// part of the bargain.
pub(super) fn divide(parts: &[Part; 3]) -> [f64; 3] {
    let work = |numbers: &[f64; 3]| -> f64 {
        let alive = parts.iter().zip(numbers).filter(|(p, _)| p.is_alive());
        alive.map(|(p, n)| p.cost * n).sum()
    };
    let at = |scale: f64| {
        parts.map(|p| {
            let best = scale * (p.variance / p.cost).sqrt();
            if p.is_alive() { best.clamp(p.count / FARTHEST, p.count * FARTHEST) } else { p.count }
        })
    };
    let given = work(&parts.map(|p| p.count));
    let (mut low, mut high) = (0.0, 0.0f64);
    for p in parts.iter().filter(|p| p.is_alive()) {
        high = high.max(FARTHEST * p.count / (p.variance / p.cost).sqrt());
    }
    // The work grows with the scale; sixty halvings leave nothing of the interval.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if work(&at(middle)) > given { high = middle } else { low = middle }
    }
    at(low)
}

/// Work of camera walks in rays of photons.
pub(super) fn walking(counters: &Counters) -> f64 {
    CAMERA_RAY * (counters.camera_rays + counters.continuation_rays + counters.shadow_rays) as f64
}

/// Work of estimates in rays of photons.
pub(super) fn gathering(counters: &Counters) -> f64 {
    GATHERED * counters.gathered_photons as f64
}

/// Work of storing and indexing photons in rays of photons.
pub(super) fn storing(photons: u64) -> f64 {
    STORED * photons as f64
}

/// Mean over points of half the squared differences of two estimates of the same, relative to the light there: their variance.
pub(super) fn noise(one: &[Rgb], other: &[Rgb], light: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = light.iter().copied().filter(|l| *l > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(median) = sorted.get(sorted.len() / 2) else { return 0.0 };
    let square = |((a, b), light): ((&Rgb, &Rgb), &f64)| {
        let difference = f64::from(color::mean(*a)) - f64::from(color::mean(*b));
        0.5 * difference * difference / (light * light + median * median)
    };
    let sum: f64 = one.iter().zip(other).zip(light).map(square).filter(|s| s.is_finite()).sum();
    sum / one.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(variance: f64, cost: f64, count: f64) -> Part {
        Part { variance, cost, count }
    }

    fn sums(parts: &[Part; 3], numbers: &[f64; 3]) -> (f64, f64) {
        let noise = parts.iter().zip(numbers).filter(|(p, _)| p.variance > 0.0).map(|(p, n)| p.variance / n).sum();
        (noise, parts.iter().zip(numbers).filter(|(p, _)| p.variance > 0.0).map(|(p, n)| p.cost * n).sum())
    }

    /// For two parts of equal cost the optimum is n ∝ σ, by hand.
    #[test]
    fn numbers_follow_the_root_of_noise_over_cost() {
        let parts = [part(4.0, 1.0, 10.0), part(1.0, 1.0, 10.0), part(0.0, 5.0, 7.0)];
        let [a, b, c] = divide(&parts);
        assert!((a - 40.0 / 3.0).abs() < 1e-9 && (b - 20.0 / 3.0).abs() < 1e-9 && c == 7.0, "{a} {b} {c}");
    }

    /// No other division of the same work within the bounds is less noisy.
    #[test]
    fn no_neighbour_is_better() {
        for parts in [
            [part(1.0, 3.0, 8.0), part(50.0, 0.01, 1000.0), part(3.0, 0.02, 500.0)],
            [part(1e-6, 3.0, 8.0), part(50.0, 0.01, 1000.0), part(3000.0, 0.02, 500.0)],
        ] {
            let best = divide(&parts);
            let (noise, work) = sums(&parts, &best);
            let (before, given) = sums(&parts, &parts.map(|p| p.count));
            assert!(noise <= before && (work / given - 1.0).abs() < 1e-9);
            for (i, j) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                let mut other = best;
                let moved = 1e-3 * parts[i].cost * best[i];
                other[i] -= moved / parts[i].cost;
                other[j] += moved / parts[j].cost;
                let within = |k: usize| (parts[k].count / FARTHEST..=parts[k].count * FARTHEST).contains(&other[k]);
                assert!(!within(i) || !within(j) || sums(&parts, &other).0 >= noise, "{i} to {j}");
            }
        }
    }

    #[test]
    fn what_makes_no_noise_changes_nothing_for_the_rest() {
        let two = [part(4.0, 1.0, 10.0), part(1.0, 2.0, 10.0), Part::default()];
        let [a, b, _] = divide(&two);
        let three = [two[0], two[1], part(0.0, 9.0, 1000.0)];
        assert_eq!(divide(&three), [a, b, 1000.0]);
        assert_eq!(divide(&[Part::default(); 3]), [0.0; 3]);
    }
}
