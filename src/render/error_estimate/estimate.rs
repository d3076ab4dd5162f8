//! The estimated error of a picture.

use super::blur::NestedDifferenceMoments;
use super::fireflies::FireflyHistogram;
use super::squared_error::SquaredErrorParts;
use serde::Serialize;

/// Estimated error of a picture. The picture is the mean of the passes so far.
///
/// Errors are relative root mean square errors, see
/// [`RelativeErrorWeights`](crate::image::RelativeErrorWeights) for the formula; 0.01 means 1 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorEstimate {
    /// Number of passes whose mean is the picture.
    pub passes: u32,
    /// Total relative error √(noise² + bias²) of the picture; infinite after too few passes.
    pub error: f64,
    /// Lower end of the interval that contains the true error with the requested confidence; 0
    /// after too few passes.
    pub low: f64,
    /// Upper end of the interval that contains the true error with the requested confidence;
    /// infinite after too few passes.
    pub high: f64,
    /// Noise of the picture: relative standard error of the mean of the passes. The squared
    /// relative noise of each pixel is clamped to 1. Infinite after too few passes.
    pub noise: f64,
    /// Relative bias, the error that is not noise: √(blur² + shared_paths² + clamping²). Infinite
    /// after too few passes.
    pub bias: f64,
    /// Relative bias of photon density estimates, which blur light over their gather discs.
    pub blur: f64,
    /// Relative error due to camera paths that are the same in all passes, as in the integrator
    /// `ppm`. More passes do not reduce this error. It is 0 if each pass has its own paths.
    pub shared_paths: f64,
    /// Relative bias due to the light that clamping removes from camera paths; 0 without clamping.
    pub clamping: f64,
    /// Blur at half the gather disc area, divided by the blur at full area: ½ where the light is
    /// smooth, larger at edges of light.
    #[serde(skip)]
    pub(super) half_area_blur_ratio: f64,
    /// Extrapolated blur L(r) − L(0), divided by the measured difference L(r) − L(r/2), for the
    /// density estimate L(r) with gather radius r.
    #[serde(skip)]
    pub(super) blur_extrapolation_factor: f64,
    /// Parts of the squared error (noise, blur, shared camera paths and clamping), with their
    /// variances.
    #[serde(skip)]
    pub(super) parts: SquaredErrorParts,
    /// Moments of the differences between density estimates with gather discs of full, half and
    /// quarter area; all 0 without photon estimates.
    #[serde(skip)]
    pub(super) difference_moments: NestedDifferenceMoments,
    /// Histogram of fireflies: pixels whose relative squared noise exceeds 1.
    #[serde(skip)]
    pub(super) fireflies: FireflyHistogram,
}
