//! Estimates the error of a picture from its passes, as a sum of four parts.
//!
//! - *Noise*: passes are independent, so the variance of the mean of n passes is s²/n, with the
//!   sample variance s².
//! - *Blur*: the density estimate L(r) with gather radius r has bias L(r) − L(0). The differences
//!   D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2) are the first terms of a series that sums to
//!   the bias. The three estimates share their photons. Squares and products of differences
//!   combine two different passes, so their noise has mean zero.
//! - *Shared-path error*: `ppm` uses the same camera paths in all passes. A few pixels are also
//!   rendered with unshared camera paths. The mean difference of both is the error of the shared
//!   paths.
//! - *Clamping*: a render that clamps the light of camera paths measures the removed light. This
//!   light is the bias, up to the sign.

mod blur;
mod clamping_loss;
mod confidence;
mod disc_area_sums;
mod estimate;
mod estimator;
mod fireflies;
mod forecast;
mod leading_passes;
mod pixel_sums;
mod pixel_variance;
mod schedule;
mod shared_paths;
mod squared_error;
mod stop_forecast;

pub use confidence::Confidence;
pub use estimate::ErrorEstimate;
pub use estimator::{ErrorEstimator, ErrorMaps, MIN_ERROR_ESTIMATE_PASSES};
pub use forecast::{BiasPart, ErrorForecast};
pub use schedule::EstimateSchedule;
pub use stop_forecast::{PassRange, RANGE_PROBABILITY, StopForecast};

#[cfg(test)]
mod tests;
