//! Error estimate of a picture from its own passes: noise, blur of photon estimates, shared-path
//! error.
//!
//! - *Noise.* Passes are independent. The variance of their mean is s²/n (Welford).
//! - *Blur.* A photon estimate L(r) is biased by its disc of radius r. Two differences measure the
//!   bias: D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), from one set of photons. The whole series
//!   sums to L(r) − L(0), which is the bias. Squares and products are taken between different
//!   passes, so their noise has mean zero.
//! - *Shared-path error.* `ppm` uses one set of camera paths in all passes. A few pixels are also
//!   rendered with fresh paths; the mean difference is the error of the shared ones.

mod blur;
mod confidence;
mod effective_samples;
mod estimate;
mod estimator;
mod fireflies;
mod forecast;
mod shared_paths;

pub use confidence::Confidence;
pub use estimate::ErrorEstimate;
pub use estimator::{ErrorEstimator, ErrorMaps, MIN_PASSES};
pub use forecast::{ErrorForecast, PassesNeeded};

#[cfg(test)]
mod tests;
