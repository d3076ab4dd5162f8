//! Forecast: predicts the error of a picture after more passes.

use super::estimate::ErrorEstimate;
use super::fireflies::FireflyHistogram;
use crate::integrate::squared_radius_ratio;

/// Largest number of passes of a forecast.
const MAX_PASSES: u32 = 10_000_000;

/// Number of passes that a forecast sums one by one. It sums later passes in groups
/// ([`GROUP_DIVISOR`]).
const EXACT_PASSES: u32 = 1024;

/// Divisor of the number n of passes summed so far: a forecast adds later passes in groups of
/// n/`GROUP_DIVISOR`.
const GROUP_DIVISOR: u32 = 128;

/// Number of passes needed to reach a given error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PassesNeeded {
    /// Total number of passes, including those made.
    Passes(u32),
    /// No number of passes suffices, because the bias is too large.
    Never {
        /// Relative bias that no number of passes removes.
        floor: f64,
    },
    /// More than ten million passes are necessary.
    TooMany,
}

/// Predicted error as a function of the number of passes n.
///
/// Let aᵢ be the disc area of photon estimates in pass i, divided by that in pass 0. The variance
/// of photon estimates falls as Σ(1/aᵢ)/n², all other variance as 1/n. Blur is proportional to the
/// mean of aᵢ^p, with a measured exponent p. The shared-path error is constant.
#[derive(Clone, Copy, Debug)]
pub struct ErrorForecast {
    /// Exponent α of the radius law; 1 for fixed radii.
    alpha: f64,
    /// Relative variance of one pass, without that of photon estimates and fireflies.
    path_variance: f64,
    /// Relative variance of photon estimates in the first pass.
    photon_variance: f64,
    /// Relative blur of the first pass.
    blur: f64,
    /// Exponent p: the blur of a pass is proportional to its disc area to the power p.
    power: f64,
    shared_paths: f64,
    fireflies: FireflyHistogram,
    /// Number of passes of the error estimate from which the forecast starts.
    passes: f64,
}

impl ErrorForecast {
    /// Creates the forecast from an error estimate.
    ///
    /// `law` holds the exponent α of the radius law and
    /// [`Kernel::nested_difference_variance`](crate::photon::Kernel::nested_difference_variance);
    /// `None` without photon estimates.
    pub(super) fn new(estimate: &ErrorEstimate, law: Option<(f64, f32)>) -> Self {
        let n = f64::from(estimate.passes);
        let (fireflies, shared_paths) = (estimate.fireflies, estimate.shared_paths);
        let variance = (estimate.variance - n * fireflies.squared_error_of_fireflies()).max(0.0);
        let Some((alpha, kernel_difference_variance)) = law else {
            return Self {
                alpha: 1.0,
                path_variance: variance,
                photon_variance: 0.0,
                blur: 0.0,
                power: 1.0,
                shared_paths,
                fireflies,
                passes: n,
            };
        };
        let power = (-libm::log2(estimate.blur_ratio)).max(0.0);
        let mut sums = DiscAreaSums::new(alpha, power);
        (0..estimate.passes).for_each(|_| sums.add_pass());
        let photon_variance = (estimate.difference_variance / f64::from(kernel_difference_variance)).min(variance);
        Self {
            alpha,
            path_variance: variance - photon_variance,
            photon_variance: photon_variance * n / sums.inverse_area,
            blur: estimate.blur * n / sums.blur,
            power,
            shared_paths,
            fireflies,
            passes: n,
        }
    }

    /// Returns the predicted relative error after `passes` ≥ 1 passes.
    #[must_use]
    pub fn error_after_passes(&self, passes: u32) -> f64 {
        let (noise, bias) = self.noise_and_bias_after_passes(passes);
        noise.hypot(bias)
    }

    /// Returns the predicted relative noise and bias after `passes` ≥ 1 passes.
    fn noise_and_bias_after_passes(&self, passes: u32) -> (f64, f64) {
        let mut sums = DiscAreaSums::new(self.alpha, self.power);
        (0..passes).for_each(|_| sums.add_pass());
        self.noise_and_bias_from_area_sums(&sums)
    }

    /// Returns the predicted relative noise and bias after the passes that `sums` holds.
    fn noise_and_bias_from_area_sums(&self, sums: &DiscAreaSums) -> (f64, f64) {
        let n = f64::from(sums.passes);
        let noise2 = (self.path_variance * n + self.photon_variance * sums.inverse_area) / (n * n)
            + self.fireflies.firefly_squared_error_after(n / self.passes);
        let blur = self.blur * sums.blur / n;
        (noise2.sqrt(), (blur * blur + self.shared_paths * self.shared_paths).sqrt())
    }

    /// Predicts the smallest number of passes after which the relative error is at most `target`.
    ///
    /// Above 1024 passes, the number is exact to 1 %.
    #[must_use]
    pub fn passes_to_reach(&self, target: f64) -> PassesNeeded {
        let floor = if self.alpha < 1.0 { self.shared_paths } else { self.blur.hypot(self.shared_paths) };
        if floor >= target {
            return PassesNeeded::Never { floor };
        }
        let passes = self.first_passes(|noise, bias| noise.hypot(bias) <= target);
        passes.map_or(PassesNeeded::TooMany, PassesNeeded::Passes)
    }

    /// Predicts the smallest number of passes after which the relative noise is at most `target`;
    /// `None` above ten million passes.
    ///
    /// Above 1024 passes, the number is exact to 1 %.
    #[must_use]
    pub fn passes_to_reach_noise(&self, target: f64) -> Option<u32> {
        self.first_passes(|noise, _| noise <= target)
    }

    /// Returns the first number of passes after which `holds` is true for the predicted noise and
    /// bias; `None` above [`MAX_PASSES`].
    fn first_passes(&self, holds: impl Fn(f64, f64) -> bool) -> Option<u32> {
        let mut sums = DiscAreaSums::new(self.alpha, self.power);
        while sums.passes < MAX_PASSES {
            if sums.passes < EXACT_PASSES {
                sums.add_pass()
            } else {
                sums.add_group_of_passes()
            }
            let (noise, bias) = self.noise_and_bias_from_area_sums(&sums);
            if holds(noise, bias) {
                return Some(sums.passes);
            }
        }
        None
    }
}

/// Sums over passes of powers of the disc area of photon estimates.
struct DiscAreaSums {
    /// Exponent α of the radius law.
    alpha: f64,
    /// Exponent p: the blur of a pass is proportional to its disc area to the power p.
    power: f64,
    /// Number of summed passes.
    passes: u32,
    /// Disc area of the next pass, divided by that of the first pass.
    area: f64,
    /// Sum over passes of 1/area, with the disc area relative to the first pass.
    inverse_area: f64,
    /// Sum over passes of area^`power`, with the disc area relative to the first pass.
    blur: f64,
}

impl DiscAreaSums {
    fn new(alpha: f64, power: f64) -> Self {
        Self { alpha, power, passes: 0, area: squared_radius_ratio(alpha, 0), inverse_area: 0.0, blur: 0.0 }
    }

    fn add_pass(&mut self) {
        self.inverse_area += 1.0 / self.area;
        self.blur += if self.power == 1.0 { self.area } else { libm::pow(self.area, self.power) };
        self.passes += 1;
        let i = f64::from(self.passes);
        self.area *= (i + self.alpha) / (i + 1.0);
    }

    /// Adds the next n/[`GROUP_DIVISOR`] passes at once by the midpoint rule, where n passes are
    /// summed so far.
    ///
    /// The rule uses area ∝ n^(α − 1), which holds for large n.
    fn add_group_of_passes(&mut self) {
        let (n, count) = (f64::from(self.passes), self.passes / GROUP_DIVISOR);
        let at = |i: f64| self.area * libm::pow(i / n, self.alpha - 1.0);
        let middle = at(n + 0.5 * f64::from(count));
        self.area = at(n + f64::from(count));
        self.inverse_area += f64::from(count) / middle;
        self.blur += f64::from(count) * libm::pow(middle, self.power);
        self.passes += count;
    }
}

#[cfg(test)]
mod tests;
