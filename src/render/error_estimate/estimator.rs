//! The error estimator: accumulates passes and estimates the error of their mean.

use super::blur::{BlurEstimate, NestedDifferenceMoments};
use super::confidence::Confidence;
use super::effective_samples::EffectiveSampleCount;
use super::estimate::ErrorEstimate;
use super::fireflies::Fireflies;
use super::forecast::ErrorForecast;
use super::shared_paths::SharedPathErrorSums;
use crate::image::RelativeErrorWeights;
use crate::integrate::{MeanGatherDisc, NestedEstimates, Pass, RadiusLaw};
use crate::render::film::Film;
use glam::{DVec3, Vec3};

/// Least number of passes for an error estimate.
pub const MIN_PASSES: u32 = 4;

/// Accumulates the passes of a render, and estimates the error of their mean.
#[derive(Clone, Debug)]
pub struct ErrorEstimator {
    /// Law by which gather radii shrink from pass to pass; `None` without photon density estimates.
    radius_law: Option<RadiusLaw>,
    /// Number of added passes.
    passes: u32,
    /// Σ (x − mean)² over passes, by pixel and channel, in f64 because squares may overflow f32.
    squared_deviations: Vec<DVec3>,
    photon_estimates: Option<NestedEstimateSums>,
    shared_paths: SharedPathErrorSums,
    samples: EffectiveSampleCount,
    scale: Option<RelativeErrorWeights>,
}

/// Sums over passes of the differences between photon estimates with nested discs, for each pixel.
#[derive(Clone, Debug)]
struct NestedEstimateSums {
    /// Sums over passes of the differences D₀ and D₁ that [`error_estimate`](super) defines, for
    /// each pixel.
    differences: [Vec<Vec3>; 2],
    /// Sums over passes and channels of D₀², D₀·D₁ and D₁², for each pixel.
    /// [`error_estimate`](super) defines D₀ and D₁.
    products: Vec<[f64; 3]>,
    /// Sums over passes of gather radius and photon count of each pixel: from the caustic map, and
    /// from the indirect map.
    discs: Vec<[GatherDiscTotals; 2]>,
    samples: EffectiveSampleCount,
}

#[derive(Clone, Copy, Debug, Default)]
struct GatherDiscTotals {
    radius: f32,
    photons: f32,
    passes: u32,
}

/// Estimated error of each pixel, in rows from the top.
#[derive(Clone, Debug, Default)]
pub struct ErrorMaps {
    /// Standard error of the mean of the passes, by channel \[W/(m² sr)].
    pub noise: Vec<Vec3>,
    /// Signed estimate of the blur of the mean of the passes, by channel \[W/(m² sr)]. It is noisy.
    pub bias: Vec<Vec3>,
    /// Mean radius and photon count of estimates from the caustic map.
    pub caustic: Vec<MeanGatherDisc>,
    /// Mean radius and photon count of estimates from the indirect map.
    pub indirect: Vec<MeanGatherDisc>,
}

impl ErrorEstimator {
    /// Creates an estimator without passes.
    ///
    /// `radius_law` is the law by which gather radii shrink from pass to pass; `None` without
    /// photon density estimates.
    #[must_use]
    pub fn new(radius_law: Option<RadiusLaw>) -> Self {
        Self {
            radius_law,
            passes: 0,
            squared_deviations: Vec::new(),
            photon_estimates: None,
            shared_paths: SharedPathErrorSums::default(),
            samples: EffectiveSampleCount::default(),
            scale: None,
        }
    }

    /// Adds a pass. `film` must hold exactly the passes before `pass`.
    pub fn add(&mut self, film: &Film, pass: &Pass) {
        let n = f64::from(self.passes);
        self.squared_deviations.resize(pass.image.len(), DVec3::ZERO);
        for ((sum, value), before) in self.squared_deviations.iter_mut().zip(&pass.image).zip(film.pixel_means()) {
            if n > 0.0 {
                let delta = value.as_dvec3() - before;
                *sum += delta * delta * (n / (n + 1.0));
            }
        }
        // The scale changes little from pass to pass, so it is updated when the number doubles.
        if self.passes.is_power_of_two() {
            self.scale = Some(RelativeErrorWeights::from_pixels(film.size(), &film.mean()));
        }
        let weights = self.scale.as_ref().map_or(&[][..], RelativeErrorWeights::pixel_weights);
        // The relative squared error of a pixel is clamped to 1 in the mean, so to n in one pass.
        self.samples.add(pass.image.iter().copied(), weights, n + 1.0);
        if !pass.nested.is_empty() {
            let estimates = self.photon_estimates.get_or_insert_with(|| NestedEstimateSums::new(pass.nested.len()));
            estimates.add(&pass.nested);
            estimates.samples.add(pass.nested.iter().map(|pixel| pixel.steps[0]), weights, n + 1.0);
        }
        self.shared_paths.add(pass);
        self.passes += 1;
    }

    /// Estimates the error of the mean of the passes, with an interval of 90 % confidence.
    ///
    /// `film` must hold exactly the passes added so far. The error is infinite before
    /// [`MIN_PASSES`] passes.
    #[must_use]
    pub fn estimate(&self, film: &Film) -> ErrorEstimate {
        self.estimate_with_confidence(film, Confidence::default())
    }

    /// Estimates the error of the mean of the passes, with an interval of the given `confidence`.
    ///
    /// `film` must hold exactly the passes added so far. The error is infinite before
    /// [`MIN_PASSES`] passes.
    #[must_use]
    pub fn estimate_with_confidence(&self, film: &Film, confidence: Confidence) -> ErrorEstimate {
        let passes = self.passes;
        if passes < MIN_PASSES {
            let unknown = f64::INFINITY;
            let (error, low, high, noise, bias) = (unknown, 0.0, unknown, unknown, unknown);
            return ErrorEstimate { passes, error, low, high, noise, bias, ..ErrorEstimate::default() };
        }
        let n = f64::from(passes);
        let scale = RelativeErrorWeights::from_pixels(film.size(), &film.mean());
        let mut fireflies = Fireflies::default();
        let fraction = 1.0 / scale.pixel_weights().len() as f64;
        let noise2 = self.squared_deviations.iter().zip(scale.pixel_weights()).map(|(deviation, weight)| {
            let square = weight * deviation.element_sum() / (n * (n - 1.0));
            if square > 1.0 {
                fireflies.add(square, fraction);
            }
            square.min(1.0)
        });
        let noise2 = noise2.sum::<f64>() * fraction;
        let differences =
            self.photon_estimates.as_ref().map(|estimates| estimates.nested_difference_moments(&scale, n));
        let blur = differences.as_ref().map(BlurEstimate::from_differences).unwrap_or_default();
        let (shared2, shared_variance) = self.shared_paths.shared_path_squared_error(&scale, film.size().0, n);
        let square = noise2 + blur.square + shared2;
        // The true error of this picture scatters about its expectation, which is estimated too.
        let scatter = self.samples.squared_error_variance();
        let realised = noise2 * noise2 * scatter + 2.0 * noise2 * (blur.square + shared2) * scatter;
        let estimated = noise2 * noise2 * self.samples.relative_variance_of_variance().max(scatter / (n - 1.0));
        let deviation = (realised + estimated + blur.variance + shared_variance).sqrt();
        let half_width = confidence.gaussian_half_width() * deviation;
        let error = square.sqrt();
        ErrorEstimate {
            passes,
            error,
            low: (square - half_width).max(0.0).sqrt(),
            high: (square + half_width).sqrt(),
            noise: noise2.sqrt(),
            bias: (blur.square + shared2).sqrt(),
            blur: blur.square.sqrt(),
            shared_paths: shared2.sqrt(),
            blur_ratio: blur.ratio,
            extrapolation: blur.extrapolation,
            variance: noise2 * n,
            difference_variance: differences.map_or(0.0, |differences| differences.variance),
            fireflies,
        }
    }

    /// Returns the forecast of the error after more passes than those of `estimate`; `None` before
    /// [`MIN_PASSES`] passes.
    #[must_use]
    pub fn forecast(&self, estimate: &ErrorEstimate) -> Option<ErrorForecast> {
        let law = self.radius_law.map(|law| (law.alpha, law.kernel.nested_difference_variance()));
        estimate.error.is_finite().then(|| ErrorForecast::new(estimate, law))
    }

    /// Returns the estimated error of each pixel. `film` must hold exactly the passes added so far.
    #[must_use]
    pub fn error_maps(&self, film: &Film) -> ErrorMaps {
        let n = f64::from(self.passes.max(1));
        let over = (n * (n - 1.0)).max(1.0);
        let noise = self.squared_deviations.iter().map(|m2| (*m2 / over).map(f64::sqrt).as_vec3()).collect();
        let Some(estimates) = &self.photon_estimates else { return ErrorMaps { noise, ..ErrorMaps::default() } };
        let factor = (self.estimate(film).extrapolation / n) as f32;
        let [d0, d1] = &estimates.differences;
        let bias = d0.iter().zip(d1).map(|(a, b)| (*a + *b) * factor).collect();
        let discs = |map: usize| estimates.discs.iter().map(|d| d[map].mean()).collect();
        ErrorMaps { noise, bias, caustic: discs(0), indirect: discs(1) }
    }
}

impl NestedEstimateSums {
    fn new(pixels: usize) -> Self {
        Self {
            differences: [vec![Vec3::ZERO; pixels], vec![Vec3::ZERO; pixels]],
            products: vec![[0.0; 3]; pixels],
            discs: vec![[GatherDiscTotals::default(); 2]; pixels],
            samples: EffectiveSampleCount::default(),
        }
    }

    fn add(&mut self, pixels: &[NestedEstimates]) {
        let [d0, d1] = &mut self.differences;
        for (i, pixel) in pixels.iter().enumerate() {
            let [a, b] = pixel.steps;
            d0[i] += a;
            d1[i] += b;
            let (a, b) = (a.as_dvec3(), b.as_dvec3());
            for (sum, product) in self.products[i].iter_mut().zip([a.dot(a), a.dot(b), b.dot(b)]) {
                *sum += product;
            }
            let [caustic, indirect] = &mut self.discs[i];
            caustic.add(pixel.caustic);
            indirect.add(pixel.indirect);
        }
    }

    /// Returns the means over the picture of the squares and the product of D₀ and D₁, for `n`
    /// passes.
    ///
    /// Each product combines two different passes. [`error_estimate`](super) defines D₀ and D₁.
    fn nested_difference_moments(&self, scale: &RelativeErrorWeights, n: f64) -> NestedDifferenceMoments {
        let [d0, d1] = &self.differences;
        let pixels = scale.pixel_weights().len();
        let (mut square, mut variance) = ([0.0; 3], 0.0);
        for i in 0..pixels {
            let (a, b) = (d0[i].as_dvec3(), d1[i].as_dvec3());
            let products = self.products[i];
            for ((sum, all), same_pass) in square.iter_mut().zip([a.dot(a), a.dot(b), b.dot(b)]).zip(products) {
                *sum += scale.clamped_relative_product(i, (all - same_pass) / (n * (n - 1.0)));
            }
            variance += scale.clamped_relative_product(i, (products[0] - a.dot(a) / n) / (n * (n - 1.0)));
        }
        let [d0, d0_d1, d1] = square.map(|sum| sum / pixels as f64);
        let variance = n * variance / pixels as f64;
        // Terms: noise of pairs of passes, and products of noise and expected difference.
        let scatter = self.samples.squared_error_variance();
        let d0_variance = variance * variance * scatter / (n * (n - 1.0)) + 2.0 * d0.max(0.0) * variance * scatter / n;
        NestedDifferenceMoments { d0, d0_d1, d1, variance, d0_variance }
    }
}

impl GatherDiscTotals {
    fn add(&mut self, discs: Option<MeanGatherDisc>) {
        if let Some(MeanGatherDisc { radius, photons }) = discs {
            self.radius += radius;
            self.photons += photons;
            self.passes += 1;
        }
    }

    /// Returns the mean radius and photon count over the passes with an estimate; 0 without such
    /// passes.
    fn mean(self) -> MeanGatherDisc {
        let n = self.passes.max(1) as f32;
        MeanGatherDisc { radius: self.radius / n, photons: self.photons / n }
    }
}
