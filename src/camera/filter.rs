//! Pixel reconstruction filters.
//!
//! Sample offsets from the pixel center have a pdf proportional to the absolute filter value
//! (Pharr, Jakob, Humphreys 2023, section 8.8). So all samples of a filter have the same weight, up
//! to its sign.

use glam::Vec2;
use std::str::FromStr;

/// The kind of a pixel reconstruction filter. Radii are in pixels, along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FilterKind {
    /// Box filter of radius ½.
    Box,
    /// Tent filter of radius 1.
    Tent,
    /// Gaussian with standard deviation ½, minus a constant, so that the filter reaches 0 at the
    /// radius 1½.
    Gaussian,
    /// Four-term Blackman–Harris window of radius 1½ (Harris 1978).
    #[default]
    BlackmanHarris,
    /// Cubic filter of Mitchell and Netravali 1988 with B = C = ⅓ and radius 2. It has negative
    /// values.
    Mitchell,
}

/// Error: a text is not the name of a filter. The field is the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown filter `{0}`: use box, tent, gaussian, blackman-harris or mitchell")]
pub struct UnknownFilter(String);

impl FromStr for FilterKind {
    type Err = UnknownFilter;

    fn from_str(name: &str) -> Result<Self, UnknownFilter> {
        Ok(match name {
            "box" => Self::Box,
            "tent" => Self::Tent,
            "gaussian" => Self::Gaussian,
            "blackman-harris" => Self::BlackmanHarris,
            "mitchell" => Self::Mitchell,
            _ => return Err(UnknownFilter(name.to_owned())),
        })
    }
}

impl FilterKind {
    /// Distance from the pixel center beyond which the filter vanishes, along each axis \[pixels].
    fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
        }
    }

    /// Unnormalized filter value at distance `x` from the pixel center along one axis \[pixels].
    /// `x` must be within the radius.
    #[must_use]
    pub fn unnormalized_axis_value(self, x: f64) -> f64 {
        match self {
            Self::Box => 1.0,
            Self::Tent => 1.0 - x.abs(),
            Self::Gaussian => libm::exp(-2.0 * x * x) - libm::exp(-2.0 * 1.5 * 1.5),
            Self::BlackmanHarris => {
                let phase = std::f64::consts::TAU * (x / 3.0 + 0.5);
                0.35875 - 0.48829 * libm::cos(phase) + 0.14128 * libm::cos(2.0 * phase)
                    - 0.01168 * libm::cos(3.0 * phase)
            }
            Self::Mitchell => {
                let x = x.abs();
                if x < 1.0 {
                    (7.0 * x - 12.0) * x * x + 16.0 / 3.0
                } else {
                    ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0
                }
            }
        }
    }
}

/// Number of equal intervals into which the table [`Filter::quantiles`] divides the range \[0, 1]
/// of u.
const QUANTILE_CELL_COUNT: usize = 1024;

/// Number of intervals of the table [`Filter::normalized_axis_values`], from the center to the
/// radius.
const VALUE_CELL_COUNT: usize = 256;

/// A separable reconstruction filter, with tables for importance sampling and for evaluation.
#[derive(Clone, Debug)]
pub struct Filter {
    /// Inverse CDF of sample offsets along one axis \[pixels], at equal steps of u in \[0, 1].
    ///
    /// The pdf of the offsets is proportional to the absolute filter value.
    quantiles: [f32; QUANTILE_CELL_COUNT + 1],
    /// Distance \[pixels] from the pixel center along one axis beyond which the filter is negative;
    /// infinite for a filter without negative values.
    negative_beyond: f32,
    /// Ratio ∫|f| / ∫f for the filter f along one axis. A sample's weight along this axis is the
    /// ratio, with the sign of f, because offsets are sampled with a pdf proportional to |f|.
    absolute_over_signed_integral: f32,
    /// Distance from the pixel center beyond which the filter vanishes, along each axis \[pixels].
    radius: f32,
    /// Results of [`Filter::normalized_axis_value`] at equal steps from the center to the radius
    /// \[1/pixel].
    normalized_axis_values: [f32; VALUE_CELL_COUNT + 1],
}

/// A sampled offset from the pixel center, with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// Sampled offset from the pixel center, right and down \[pixels].
    pub offset: Vec2,
    /// Factor on the radiance of the sample: 1 for a non-negative filter. A partly negative filter
    /// has weights of both signs, with mean 1.
    pub weight: f32,
}

impl Filter {
    /// Creates the filter of the given kind, with its tables.
    #[must_use]
    pub fn new(kind: FilterKind) -> Self {
        const STEPS: usize = 4096;
        let radius = kind.radius();
        let at = |i: usize| radius * (2.0 * (i as f64) / STEPS as f64 - 1.0);
        let mut cumulative = vec![0.0; STEPS + 1];
        let (mut signed, mut negative_beyond) = (0.0, f64::INFINITY);
        for i in 0..STEPS {
            let center = 0.5 * (at(i) + at(i + 1));
            let weight = kind.unnormalized_axis_value(center);
            signed += weight;
            cumulative[i + 1] = cumulative[i] + weight.abs();
            // All filters are positive in the middle and change sign at most once on each side.
            if weight < 0.0 && center > 0.0 {
                negative_beyond = negative_beyond.min(at(i));
            }
        }
        let total = cumulative[STEPS];
        let absolute_over_signed = if negative_beyond.is_finite() { (total / signed) as f32 } else { 1.0 };
        let quantiles = std::array::from_fn(|q| {
            let target = total * q as f64 / QUANTILE_CELL_COUNT as f64;
            let i = cumulative.partition_point(|c| *c < target).clamp(1, STEPS);
            let (lo, hi) = (cumulative[i - 1], cumulative[i]);
            let part = if hi > lo { (target - lo) / (hi - lo) } else { 0.0 };
            (at(i - 1) + (at(i) - at(i - 1)) * part) as f32
        });
        let integral = signed * 2.0 * radius / STEPS as f64;
        let normalized_value =
            |i: usize| (kind.unnormalized_axis_value(radius * i as f64 / VALUE_CELL_COUNT as f64) / integral) as f32;
        Self {
            quantiles,
            negative_beyond: negative_beyond as f32,
            absolute_over_signed_integral: absolute_over_signed,
            radius: radius as f32,
            normalized_axis_values: std::array::from_fn(normalized_value),
        }
    }

    /// Distance from the pixel center beyond which the filter vanishes, along each axis \[pixels].
    #[inline]
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Filter value along one axis at distance `x` from the pixel center \[1/pixel], normalized to
    /// integral 1. It may be negative.
    #[inline]
    #[must_use]
    pub fn normalized_axis_value(&self, x: f32) -> f32 {
        let x = x.abs();
        if x >= self.radius {
            return 0.0;
        }
        let x = x / self.radius * VALUE_CELL_COUNT as f32;
        let i = (x as usize).min(VALUE_CELL_COUNT - 1);
        let (lo, hi) = (self.normalized_axis_values[i], self.normalized_axis_values[i + 1]);
        lo + (hi - lo) * (x - i as f32)
    }

    /// True if the filter is negative somewhere.
    #[must_use]
    pub fn has_negative_values(&self) -> bool {
        self.negative_beyond.is_finite()
    }

    /// Samples an offset from the pixel center, from random numbers `u` in \[0, 1)².
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> FilterSample {
        let offset = Vec2::new(self.sample_axis_offset(u.x), self.sample_axis_offset(u.y));
        FilterSample { offset, weight: self.sample_weight(offset) }
    }

    /// Pdf \[1/pixel²] with which [`Filter::sample`] samples `offset`.
    #[must_use]
    pub fn sample_pdf(&self, offset: Vec2) -> f32 {
        self.axis_offset_pdf(offset.x) * self.axis_offset_pdf(offset.y)
    }

    /// Weight that [`Filter::sample`] returns with `offset`.
    #[must_use]
    pub fn sample_weight(&self, offset: Vec2) -> f32 {
        let sign = |x: f32| {
            if x.abs() < self.negative_beyond {
                self.absolute_over_signed_integral
            } else {
                -self.absolute_over_signed_integral
            }
        };
        if self.has_negative_values() { sign(offset.x) * sign(offset.y) } else { 1.0 }
    }

    /// Pdf \[1/pixel] with which [`Filter::sample`] samples the offset `x` along one axis; 0
    /// outside the radius.
    ///
    /// The pdf is constant between two neighboring entries of [`Filter::quantiles`].
    fn axis_offset_pdf(&self, x: f32) -> f32 {
        let above = self.quantiles.partition_point(|quantile| *quantile <= x);
        if above == 0 || above > QUANTILE_CELL_COUNT {
            return 0.0;
        }
        1.0 / (QUANTILE_CELL_COUNT as f32 * (self.quantiles[above] - self.quantiles[above - 1]))
    }

    /// Samples an offset along one axis \[pixels], from a random number `u` in \[0, 1).
    #[inline]
    fn sample_axis_offset(&self, u: f32) -> f32 {
        let x = u * QUANTILE_CELL_COUNT as f32;
        let i = (x as usize).min(QUANTILE_CELL_COUNT - 1);
        let (lo, hi) = (self.quantiles[i], self.quantiles[i + 1]);
        lo + (hi - lo) * (x - i as f32)
    }
}

#[cfg(test)]
mod tests;
