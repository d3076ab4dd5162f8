//! The estimated error of a picture.

use super::fireflies::Fireflies;
use serde::Serialize;

/// Estimated error of the mean of the passes so far.
///
/// Errors are relative, on the scale of [`RelativeScale`](crate::image::RelativeScale); 0.01 is 1
/// %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorEstimate {
    /// Passes in the mean.
    pub passes: u32,
    /// √(noise² + bias²).
    pub error: f64,
    /// Lower end of the interval that contains the true error with the requested confidence.
    pub low: f64,
    /// Upper end of the interval that contains the true error with the requested confidence.
    pub high: f64,
    /// Standard error of the mean of the passes.
    pub noise: f64,
    /// Error that more passes of the same kind do not average away: √(blur² + shared_paths²).
    pub bias: f64,
    /// Bias from the disc radius of photon estimates.
    pub blur: f64,
    /// Bias from camera paths that all passes share.
    pub shared_paths: f64,
    /// Blur at half the disc area over blur at the full area: ½ in smooth light, larger at edges.
    #[serde(skip)]
    pub(super) blur_ratio: f64,
    /// Extrapolated blur over the measured part |D₀ + D₁|.
    #[serde(skip)]
    pub(super) extrapolation: f64,
    /// Relative variance of one pass.
    #[serde(skip)]
    pub(super) variance: f64,
    /// Relative variance of D₀ in one pass.
    #[serde(skip)]
    pub(super) step_variance: f64,
    /// Share of the noise in pixels whose squared error is clamped.
    #[serde(skip)]
    pub(super) fireflies: Fireflies,
}
