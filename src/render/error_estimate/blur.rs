//! Blur (bias) of photon density estimates, extrapolated from estimates with smaller gather radii.
//!
//! Let L(r) be the density estimate with gather radius r. The blur is L(r) − L(0). D₀ = L(r) −
//! L(r/√2) and D₁ = L(r/√2) − L(r/2) are the first terms of a series that sums to the blur. ‖D₀‖²,
//! D₀·D₁ and ‖D₁‖² are means over the pixels of the picture.

/// Lower limit of the measured ratio D₀·D₁ / ‖D₀‖², from which the blur is extrapolated. Smaller
/// measured ratios are due to noise.
///
/// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather radius
/// r. D₀·D₁ and ‖D₀‖² are means over the pixels of the picture.
const MIN_PRODUCT_RATIO: f64 = -0.5;

/// Upper limit of the measured ratio D₀·D₁ / ‖D₀‖², from which the blur is extrapolated. It is the
/// ratio at a straight edge of light, for the Epanechnikov kernel.
///
/// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather radius
/// r. D₀·D₁ and ‖D₀‖² are means over the pixels of the picture.
pub(super) const PRODUCT_RATIO_AT_LIGHT_EDGE: f64 = 0.7275;

/// Pairs of ratios for light that is not smooth, with the Epanechnikov kernel. The first, ‖D₁‖² /
/// ‖D₀‖², can be measured. The second, ‖bias‖² / ‖D₀‖², is the squared bias of the same light.
///
/// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather radius
/// r. The three pairs are for a straight edge of light, a band of light half as wide as the gather
/// disc, and a band a fifth as wide.
const NON_SMOOTH_BIAS_RATIOS: [(f64, f64); 3] = [(0.7074, 14.6), (0.957, 16.9), (1.3145, 45.2)];

/// Upper limit of [`BlurEstimate::half_area_blur_ratio`], the blur at half the gather disc area,
/// divided by the blur at full area. The limit is the ratio at a straight edge of light.
const MAX_HALF_AREA_BLUR_RATIO: f64 = 0.841;

/// Relative standard deviation of a part of the blur that is not measured: the part that is
/// extrapolated from gather radius r/2 to 0.
///
/// An edge and a band of light may have similar density estimates L(r), L(r/√2) and L(r/2). Their
/// extrapolated parts L(r/2) − L(0) still differ by this relative amount.
const EXTRAPOLATION_ERROR: f64 = 0.5;

/// Means over the picture of squares and products of two differences, D₀ and D₁.
///
/// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather radius
/// r.
///
/// Each pixel is weighted for relative errors by
/// [`RelativeErrorWeights`](crate::image::RelativeErrorWeights). Products combine two different
/// passes, so noise adds no bias to them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NestedDifferenceMoments {
    /// ‖D₀‖²: mean square over the picture of the difference D₀ of density estimates with the
    /// gather radii r and r/√2.
    pub d0_squared: f64,
    /// D₀·D₁: mean product over the picture of the differences D₀ and D₁ of density estimates. D₀
    /// is for the gather radii r and r/√2, D₁ for r/√2 and r/2.
    pub d0_d1: f64,
    /// ‖D₁‖²: mean square over the picture of the difference D₁ of density estimates with the
    /// gather radii r/√2 and r/2.
    pub d1_squared: f64,
    /// Mean over the picture of the variance of D₀ in a single pass. D₀ is the difference of
    /// density estimates with the gather radii r and r/√2.
    pub d0_variance: f64,
    /// Variance of the estimate `d0_squared`, due to the noise of the passes.
    pub d0_squared_variance: f64,
    /// Relative variance of the squared noise of D₀, the difference of density estimates with the
    /// gather radii r and r/√2.
    ///
    /// The value is 2/N. N is the effective sample count: the squared noise varies like the mean
    /// square of N independent Gaussian values.
    pub squared_noise_relative_variance: f64,
}

impl NestedDifferenceMoments {
    /// Returns the variance of an estimate of ‖D₀‖² from `passes` passes. D₀ = L(r) − L(r/√2), for
    /// the density estimate L(r) with gather radius r.
    ///
    /// `d0_squared` is ‖D₀‖², and `variance` the variance of D₀ in one pass.
    /// `squared_noise_relative_variance` is the relative variance of the squared noise of D₀. ‖D₀‖²
    /// is estimated by products of two passes. The first term of the result is due to the noise of
    /// both passes. The second term is due to the noise of one pass times the expected D₀ of the
    /// other.
    pub fn d0_squared_variance(
        d0_squared: f64,
        variance: f64,
        squared_noise_relative_variance: f64,
        passes: f64,
    ) -> f64 {
        variance * variance * squared_noise_relative_variance / (passes * (passes - 1.0))
            + 2.0 * d0_squared.max(0.0) * variance * squared_noise_relative_variance / passes
    }

    /// Returns the weight in \[0, 1] of the measured ratios ‖D₁‖² / ‖D₀‖² and D₀·D₁ / ‖D₀‖². The
    /// ratios ¼ and ½, which hold in smooth light, get 1 minus this weight.
    ///
    /// The weight is 1 if `d0_squared` is positive and has no noise, and 0 if it is not positive.
    pub fn measurement_weight(&self) -> f64 {
        let measured = self.d0_squared.max(0.0);
        let square = measured * measured;
        if measured > 0.0 { square / (square + 4.0 * self.d0_squared_variance) } else { 0.0 }
    }

    /// Returns the measured ratio D₀·D₁ / ‖D₀‖², clamped to values that are possible without noise.
    /// `d0_squared` must be positive.
    pub fn product_ratio(&self) -> f64 {
        let limit = (self.d1_squared / self.d0_squared).clamp(0.0, NON_SMOOTH_BIAS_RATIOS[2].0).sqrt();
        (self.d0_d1 / self.d0_squared).clamp(MIN_PRODUCT_RATIO, PRODUCT_RATIO_AT_LIGHT_EDGE).clamp(-limit, limit)
    }
}

/// Estimated blur of the picture: the bias of its photon density estimates, as a relative error by
/// [`RelativeErrorWeights`](crate::image::RelativeErrorWeights).
#[derive(Default)]
pub(super) struct BlurEstimate {
    /// Mean squared relative blur.
    pub squared_blur: f64,
    /// Variance of the estimate `squared_blur`.
    pub squared_blur_variance: f64,
    /// Blur at half the gather disc area, divided by the blur at full area: ½ where the light is
    /// smooth, larger at edges of light.
    pub half_area_blur_ratio: f64,
    /// Extrapolated blur L(r) − L(0), divided by the measured difference L(r) − L(r/2), for the
    /// density estimate L(r) with gather radius r.
    pub extrapolation_factor: f64,
}

impl BlurEstimate {
    /// Extrapolates the blur from the measured differences D₀ and D₁ between density estimates with
    /// nested discs.
    ///
    /// The differences D₀ and D₁ ([`NestedDifferenceMoments`]) are the first terms of a series Dᵢ
    /// whose sum is the blur. In smooth light, each term is half of the previous one, so ‖bias‖² =
    /// 4‖D₀‖². At edges, the model is Dᵢ·Dⱼ = ‖D₀‖² q^(i+j) c^|i−j|, with ratio q and correlation
    /// c. Its sum is ‖Σ Dᵢ‖² = ‖D₀‖² (1 + qc)/((1 − qc)(1 − q²)). q² and qc are measured. If they
    /// are noisy, they are shrunk towards ¼ and ½, their values in smooth light.
    pub(super) fn from_differences(differences: &NestedDifferenceMoments) -> Self {
        let d0_squared = differences.d0_squared.max(0.0);
        if d0_squared <= 0.0 {
            return Self {
                squared_blur: 0.0,
                squared_blur_variance: 16.0 * differences.d0_squared_variance,
                half_area_blur_ratio: 0.5,
                extrapolation_factor: 0.0,
            };
        }
        let trust = differences.measurement_weight();
        let squared_ratio =
            0.25 + trust * ((differences.d1_squared / d0_squared).clamp(0.0, NON_SMOOTH_BIAS_RATIOS[2].0) - 0.25);
        let correlation = 0.5 + trust * (differences.product_ratio() - 0.5);
        let bias_ratio = squared_bias_ratio(correlation, squared_ratio);
        let measured_ratio = 1.0 + 2.0 * correlation + squared_ratio;
        let squared_blur = d0_squared * bias_ratio;
        let extrapolated = squared_blur.sqrt() - (d0_squared * measured_ratio).sqrt();
        let deviation = 2.0 * squared_blur.sqrt() * EXTRAPOLATION_ERROR * extrapolated;
        Self {
            squared_blur,
            squared_blur_variance: bias_ratio * bias_ratio * differences.d0_squared_variance + deviation * deviation,
            half_area_blur_ratio: squared_ratio.sqrt().clamp(0.5, MAX_HALF_AREA_BLUR_RATIO),
            extrapolation_factor: (bias_ratio / measured_ratio).sqrt(),
        }
    }
}

/// Returns ‖bias‖² / ‖D₀‖²: the squared blur, divided by the squared difference D₀ of density
/// estimates with the gather radii r and r/√2.
///
/// `correlation` is D₀·D₁ / ‖D₀‖² = qc and `squared_ratio` is ‖D₁‖² / ‖D₀‖² = q² in the model of
/// [`BlurEstimate::from_differences`]. [`NON_SMOOTH_BIAS_RATIOS`] limits the result.
fn squared_bias_ratio(correlation: f64, squared_ratio: f64) -> f64 {
    let law = (1.0 + correlation) / ((1.0 - correlation) * (1.0 - squared_ratio.min(NON_SMOOTH_BIAS_RATIOS[0].0)));
    let rough = NON_SMOOTH_BIAS_RATIOS.windows(2).find(|pair| squared_ratio <= pair[1].0).map_or(
        NON_SMOOTH_BIAS_RATIOS[2].1,
        |pair| {
            let [(q, s), (next_q, next_s)] = [pair[0], pair[1]];
            s + (next_s - s) * ((squared_ratio - q) / (next_q - q)).max(0.0)
        },
    );
    law.min(rough)
}
