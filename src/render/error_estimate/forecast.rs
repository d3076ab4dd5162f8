//! Forecast of the error of a picture after more passes.

use super::disc_area_sums::DiscAreaSums;
use super::estimate::ErrorEstimate;

/// Largest number of passes that a forecast considers.
pub(super) const MAX_FORECAST_PASSES: u32 = 10_000_000;

/// Part of the bias of a picture, by its cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BiasPart {
    /// Blur of photon density estimates.
    Blur,
    /// Error of camera paths that all passes share, as in `ppm`.
    SharedPaths,
    /// Light that clamping removes from camera paths.
    Clamping,
}

/// Predicted error of a picture as a function of the number of passes n.
///
/// Let aᵢ be the gather disc area in pass i, relative to the first pass. The variance of photon
/// estimates falls as Σ(1/aᵢ)/n². All other variance falls as 1/n, except that the contribution of
/// fireflies is predicted from their histogram. Blur is proportional to the mean of aᵢ^p, with a
/// measured exponent p. The shared-path error and the bias of clamping are constant.
///
/// Errors are relative, see [`RelativeErrorWeights`](crate::image::RelativeErrorWeights).
#[derive(Clone, Copy, Debug)]
pub struct ErrorForecast {
    /// Error estimate from which the forecast starts.
    pub(super) estimate: ErrorEstimate,
    /// Parameter α of the radius law r²ᵢ₊₁ = r²ᵢ·(i + α)/(i + 1), for the gather radius rᵢ of pass
    /// i = 1, 2, …; 1 for fixed radii.
    pub(super) alpha: f64,
    /// Relative variance of the picture of one pass. The variances of photon estimates and of
    /// fireflies are left out, because they are predicted separately.
    path_variance: f64,
    /// Relative variance that photon estimates cause in the picture of the first pass.
    first_pass_photon_variance: f64,
    /// Relative blur (bias of photon density estimates) of the picture of the first pass.
    first_pass_blur: f64,
    /// Exponent p: the blur of a pass is proportional to the p-th power of its gather disc area.
    blur_exponent: f64,
}

impl ErrorForecast {
    /// Creates the forecast from an error estimate.
    ///
    /// `law` is a pair: the parameter α of the radius law, and
    /// [`Kernel::nested_difference_variance_ratio`](crate::photon::Kernel) of the density kernel.
    /// `law` is `None` without photon estimates.
    pub(super) fn new(estimate: ErrorEstimate, law: Option<(f64, f32)>) -> Self {
        let n = f64::from(estimate.passes);
        let fireflies = n * estimate.fireflies.squared_error_of_fireflies();
        let variance = (estimate.parts.noise * n - fireflies).max(0.0);
        let Some((alpha, kernel_difference_variance)) = law else {
            let (alpha, blur_exponent) = (1.0, 1.0);
            return Self {
                estimate,
                alpha,
                path_variance: variance,
                first_pass_photon_variance: 0.0,
                first_pass_blur: 0.0,
                blur_exponent,
            };
        };
        let blur_exponent = (-libm::log2(estimate.half_area_blur_ratio)).max(0.0);
        let sums = DiscAreaSums::of_passes(alpha, blur_exponent, estimate.passes);
        let photon_variance = estimate.difference_moments.d0_variance / f64::from(kernel_difference_variance);
        let photon_variance = photon_variance.min(variance);
        Self {
            estimate,
            alpha,
            path_variance: variance - photon_variance,
            first_pass_photon_variance: photon_variance * n / sums.inverse_area_sum,
            first_pass_blur: estimate.blur * n / sums.area_power_sum,
            blur_exponent,
        }
    }

    /// Returns the predicted relative error of the picture after `passes` ≥ 1 passes.
    #[must_use]
    pub fn error_after_passes(&self, passes: u32) -> f64 {
        let (noise, bias) = self.noise_and_bias(&DiscAreaSums::of_passes(self.alpha, self.blur_exponent, passes));
        noise.hypot(bias)
    }

    /// Returns the relative bias of the picture that remains after any number of passes; `None` if
    /// it is 0.
    ///
    /// The error of shared camera paths and the bias of clamping remain. Blur remains only if
    /// gather radii do not shrink from pass to pass.
    #[must_use]
    pub fn bias_floor(&self) -> Option<f64> {
        let floor = self.remaining_blur().hypot(self.constant_bias());
        (floor > 0.0).then_some(floor)
    }

    /// Returns the largest part of [`bias_floor`](Self::bias_floor), the bias that remains after
    /// any number of passes; `None` if no bias remains.
    #[must_use]
    pub fn largest_remaining_bias(&self) -> Option<BiasPart> {
        let ErrorEstimate { shared_paths, clamping, .. } = self.estimate;
        let parts = [
            (BiasPart::Blur, self.remaining_blur()),
            (BiasPart::SharedPaths, shared_paths),
            (BiasPart::Clamping, clamping),
        ];
        let (part, bias) = parts.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (bias > 0.0).then_some(part)
    }

    /// Returns the relative blur that remains after any number of passes; 0 if gather radii shrink.
    fn remaining_blur(&self) -> f64 {
        if self.alpha < 1.0 { 0.0 } else { self.first_pass_blur }
    }

    /// Returns the relative bias of shared camera paths and of clamping, which no number of passes
    /// changes.
    fn constant_bias(&self) -> f64 {
        self.estimate.shared_paths.hypot(self.estimate.clamping)
    }

    /// Predicts the squared noise of the picture after `sums.passes` passes. It is the square of
    /// [`ErrorEstimate::noise`].
    ///
    /// `sums` supplies the gather disc areas of these passes.
    pub(super) fn squared_noise(&self, sums: &DiscAreaSums) -> f64 {
        let n = f64::from(sums.passes);
        let fireflies = self.estimate.fireflies.firefly_squared_error_after(n / f64::from(self.estimate.passes));
        (self.path_variance * n + self.first_pass_photon_variance * sums.inverse_area_sum) / (n * n) + fireflies
    }

    /// Predicts [`ErrorEstimate::noise`] and [`ErrorEstimate::bias`] of the picture after
    /// `sums.passes` passes.
    ///
    /// `sums` supplies the gather disc areas of these passes. Its blur exponent must equal the
    /// exponent of this forecast.
    fn noise_and_bias(&self, sums: &DiscAreaSums) -> (f64, f64) {
        let blur = self.first_pass_blur * sums.area_power_sum / f64::from(sums.passes);
        (self.squared_noise(sums).sqrt(), blur.hypot(self.constant_bias()))
    }

    /// Predicts the smallest number of passes after which the relative noise of the picture is at
    /// most `target`; `None` if ten million passes do not suffice.
    ///
    /// Above 1024 passes, the number is exact to 1 %.
    #[must_use]
    pub fn passes_to_reach_noise(&self, target: f64) -> Option<u32> {
        let mut sums = DiscAreaSums::new(self.alpha, self.blur_exponent);
        while sums.passes < MAX_FORECAST_PASSES {
            sums.add_group();
            if self.noise_and_bias(&sums).0 <= target {
                return Some(sums.passes);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests;
