//! Blur (bias) of photon density estimates, extrapolated from estimates with two smaller discs.
//!
//! D₀ and D₁ are the differences defined in [`error_estimate`](super).

/// Lower bound of the ratio D₀·D₁ / ‖D₀‖². Noise alone explains smaller values.
const MIN_CORRELATION: f64 = -0.5;

/// Upper bound of the ratio D₀·D₁ / ‖D₀‖²: its value at a straight edge of light, for the
/// Epanechnikov kernel.
const EDGE_CORRELATION: f64 = 0.7275;

/// Pairs (‖D₁‖² / ‖D₀‖², ‖bias‖² / ‖D₀‖²) of features that are not smooth, for the Epanechnikov
/// kernel.
///
/// The features are a straight edge of light, and bands of light with a half and a fifth of the
/// disc's diameter. The photons in a disc cannot resolve finer features.
const ROUGH: [(f64, f64); 3] = [(0.7074, 14.6), (0.957, 16.9), (1.3145, 45.2)];

/// Largest ratio of blur with discs of half the area to blur with full discs: the ratio at an edge
/// of light.
const MAX_RATIO: f64 = 0.841;

/// Relative standard deviation of the extrapolated part of the blur.
///
/// Edges and bands of light may have similar differences D₀ and D₁, although their blur differs by
/// this fraction.
const EXTRAPOLATION_ERROR: f64 = 0.5;

/// Unbiased estimates of the mean squares and products of the differences D₀ and D₁ over the
/// picture.
pub(super) struct BlurDifferences {
    /// ‖D₀‖².
    pub d0: f64,
    /// D₀·D₁.
    pub d0_d1: f64,
    /// ‖D₁‖².
    pub d1: f64,
    /// Relative variance of the difference D₀ in one pass.
    pub variance: f64,
    /// Variance of `d0`.
    pub d0_variance: f64,
}

/// Estimated blur of the picture, relative to
/// [`RelativeErrorWeights`](crate::image::RelativeErrorWeights).
#[derive(Default)]
pub(super) struct BlurEstimate {
    /// Mean squared relative blur.
    pub square: f64,
    /// Variance of `square`.
    pub variance: f64,
    /// Blur with discs of half the area, divided by blur with full discs.
    pub ratio: f64,
    /// Blur divided by its measured part |D₀ + D₁|.
    pub extrapolation: f64,
}

impl BlurEstimate {
    /// Extrapolates the blur, the sum of all differences Dᵢ, from D₀ and D₁.
    ///
    /// In smooth light, each difference is half of the previous one, so ‖bias‖² = 4‖D₀‖². At edges,
    /// the model is Dᵢ·Dⱼ = ‖D₀‖² q^(i+j) c^|i−j|, with ratio q and correlation c. Then ‖Σ Dᵢ‖² =
    /// ‖D₀‖² (1 + qc)/((1 − qc)(1 − q²)). q² and qc are measured, and shrunk towards ¼ and ½ if
    /// they are noisy.
    pub(super) fn from_differences(differences: &BlurDifferences) -> Self {
        let d0 = differences.d0.max(0.0);
        if d0 <= 0.0 {
            return Self { square: 0.0, variance: 16.0 * differences.d0_variance, ratio: 0.5, extrapolation: 0.0 };
        }
        let trust = d0 * d0 / (d0 * d0 + 4.0 * differences.d0_variance);
        let squared = (differences.d1 / d0).clamp(0.0, ROUGH[2].0);
        let correlation =
            (differences.d0_d1 / d0).clamp(MIN_CORRELATION, EDGE_CORRELATION).clamp(-squared.sqrt(), squared.sqrt());
        let squared = 0.25 + trust * (squared - 0.25);
        let correlation = 0.5 + trust * (correlation - 0.5);
        let whole = squared_bias_ratio(correlation, squared);
        let measured = 1.0 + 2.0 * correlation + squared;
        let square = d0 * whole;
        let extrapolated = square.sqrt() - (d0 * measured).sqrt();
        let deviation = 2.0 * square.sqrt() * EXTRAPOLATION_ERROR * extrapolated;
        Self {
            square,
            variance: whole * whole * differences.d0_variance + deviation * deviation,
            ratio: squared.sqrt().clamp(0.5, MAX_RATIO),
            extrapolation: (whole / measured).sqrt(),
        }
    }
}

/// ‖Σ Dᵢ‖² / ‖D₀‖² by the model of [`BlurEstimate::from_differences`], limited by [`ROUGH`].
fn squared_bias_ratio(correlation: f64, squared: f64) -> f64 {
    let law = (1.0 + correlation) / ((1.0 - correlation) * (1.0 - squared.min(ROUGH[0].0)));
    let rough = ROUGH.windows(2).find(|pair| squared <= pair[1].0).map_or(ROUGH[2].1, |pair| {
        let [(q, s), (next_q, next_s)] = [pair[0], pair[1]];
        s + (next_s - s) * ((squared - q) / (next_q - q)).max(0.0)
    });
    law.min(rough)
}
