//! The error estimator: accumulates passes and estimates the error of their mean.

use super::blur::{BlurEstimate, NestedDifferenceMoments};
use super::clamping_loss::ClampingLossSums;
use super::confidence::Confidence;
use super::estimate::ErrorEstimate;
use super::fireflies::FireflyHistogram;
use super::forecast::ErrorForecast;
use super::leading_passes::LeadingPassPictures;
use super::pixel_sums::{MIN_PIXELS_PER_TASK, sum_over_pixels, sums_of_values};
use super::pixel_variance::PixelVarianceSums;
use super::shared_paths::SharedPathErrorSums;
use super::squared_error::SquaredErrorParts;
use crate::image::RelativeErrorWeights;
use crate::integrate::{MeanGatherDisc, NestedDifferences, PassResult, RadiusLaw};
use crate::math::BinnedSums;
use crate::render::MergeError;
use crate::render::film::{Film, total_pass_count};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Smallest number of passes for which the error is estimated.
pub const MIN_ERROR_ESTIMATE_PASSES: u32 = 4;

/// Number of leading passes (those with the lowest pass numbers) whose pictures are stored.
/// [`LeadingPassPictures`] measures the effective sample count of the noise from them.
const LEADING_PASSES: usize = 8;

/// Number of leading passes (those with the lowest pass numbers) whose difference D₀ is stored.
/// [`LeadingPassPictures`] measures the effective sample count of the noise of D₀ from them. D₀ =
/// L(r) − L(r/√2), for the density estimate L(r) with gather radius r.
const LEADING_PASSES_OF_DIFFERENCES: usize = 6;

/// Sums over pixels, from which the noise of a picture is estimated.
#[derive(Default)]
struct PictureNoiseSums {
    /// Sum over pixels of c, the squared relative noise of one pixel, clamped to 1 in each pixel.
    squared_noise: f64,
    /// Sum over pixels of c², with c as in `squared_noise`.
    fourth_power_noise: f64,
    /// Sum over pixels of c²·(kurtosis − 1), with c as in `squared_noise`. The kurtosis describes
    /// the distribution of the pixel's values in the passes.
    kurtosis_weighted_noise: f64,
    /// Histogram of the pixels whose squared relative noise exceeds 1 before it is clamped.
    fireflies: FireflyHistogram,
}

/// Accumulates the passes of a render, and estimates the error of their mean.
///
/// An error estimate depends only on the set of passes, bit for bit. Neither their order nor the
/// merging of estimators changes it. Only the mean gather discs of [`ErrorMaps`] depend on the
/// order, by rounding.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct ErrorEstimator {
    /// Law by which gather radii shrink from pass to pass; `None` if the integrator makes no photon
    /// density estimates.
    radius_law: Option<RadiusLaw>,
    /// Number of added passes.
    passes: u32,
    variances: PixelVarianceSums,
    nested_differences: Option<NestedDifferenceSums>,
    shared_paths: SharedPathErrorSums,
    /// Sums of the radiance that clamping removed from the passes; `None` if no pass was clamped.
    clamping_loss: Option<ClampingLossSums>,
    leading_pictures: LeadingPassPictures,
}

/// Sums over passes of the differences between photon density estimates with nested discs, for each
/// pixel.
///
/// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather radius
/// r.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
struct NestedDifferenceSums {
    /// Sums over passes of D₀ and of D₁, for each pixel and channel.
    differences: [BinnedSums<3>; 2],
    /// Sums over passes and channels of D₀², D₀·D₁ and D₁², for each pixel.
    products: BinnedSums<3>,
    /// Sums over passes of gather radius and photon count, as two entries for each pixel. The first
    /// entry is for the caustic map. The second is for the indirect map, and in the integrator
    /// `hybrid` also for the interreflection map.
    discs: Vec<[GatherDiscTotals; 2]>,
    /// D₀ of each pixel in the passes with the lowest numbers. The effective sample count of the
    /// noise of D₀ is measured from these pictures.
    leading_pictures: LeadingPassPictures,
}

/// Gather discs of one pixel in one photon map: sums over passes of the mean gather radius and the
/// mean photon count of a pass.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
struct GatherDiscTotals {
    /// Sum over passes of the mean gather radius in a pass \[length].
    radius_sum: f32,
    /// Sum over passes of the mean number of photons in a gather disc of a pass.
    mean_count_sum: f32,
    passes: u32,
}

/// Maps of the estimated error of each pixel, in rows from the top. Without photon density
/// estimates, all maps except `noise` are empty.
#[derive(Clone, Debug, Default)]
pub struct ErrorMaps {
    /// Standard error of the mean of the passes, by channel \[W/(m² sr)].
    pub noise: Vec<Vec3>,
    /// Estimated blur of the mean of the passes, by channel \[W/(m² sr)]; positive where the
    /// picture is too bright. The estimate is noisy.
    pub blur: Vec<Vec3>,
    /// Mean gather radius and mean photon count of each pixel's density estimates from the caustic
    /// map, over all passes.
    pub caustic_discs: Vec<MeanGatherDisc>,
    /// Mean gather radius and mean photon count of each pixel's density estimates from the indirect
    /// map, over all passes. In the integrator `hybrid`, the mean includes estimates from the
    /// interreflection map.
    pub indirect_discs: Vec<MeanGatherDisc>,
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
            variances: PixelVarianceSums::default(),
            nested_differences: None,
            shared_paths: SharedPathErrorSums::default(),
            clamping_loss: None,
            leading_pictures: LeadingPassPictures::default(),
        }
    }

    /// Adds `pass`, whose pass number is `number`. Each number may be added only once.
    pub fn add(&mut self, number: u32, pass: &PassResult) {
        self.variances.add(&pass.image);
        self.leading_pictures.add(number, LEADING_PASSES, pass.image.par_iter().copied());
        if !pass.nested.is_empty() {
            let sums = self.nested_differences.get_or_insert_with(|| NestedDifferenceSums::new(pass.nested.len()));
            sums.add(number, &pass.nested);
        }
        self.shared_paths.add(pass);
        if !pass.removed_by_clamp.is_empty() {
            let sums = self.clamping_loss.get_or_insert_with(|| ClampingLossSums::new(pass.removed_by_clamp.len()));
            sums.add(&pass.removed_by_clamp);
        }
        self.passes += 1;
    }

    /// Adds the passes of `other`. The caller ensures that no pass is in both estimators.
    ///
    /// # Errors
    /// [`MergeError`] if the estimators are for different pictures or integrators, or have too many
    /// passes together. This estimator then stays as it is.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        let passes = total_pass_count(self.passes, other.passes)?;
        if self.radius_law != other.radius_law {
            return Err(MergeError::EstimatorMismatch);
        }
        if self.passes == 0 {
            self.clone_from(other);
        } else if other.passes > 0 {
            if !self.has_same_pixels(other) {
                return Err(MergeError::EstimatorMismatch);
            }
            if let (Some(own), Some(other)) = (&mut self.nested_differences, &other.nested_differences) {
                own.merge(other);
            }
            if let (Some(own), Some(other)) = (&mut self.clamping_loss, &other.clamping_loss) {
                own.merge(other);
            }
            self.shared_paths.merge(&other.shared_paths);
            self.variances.merge(&other.variances);
            self.leading_pictures.merge(&other.leading_pictures, LEADING_PASSES);
            self.passes = passes;
        }
        Ok(())
    }

    /// True if the estimator holds `passes` passes of pictures of `pixels` pixels.
    ///
    /// False for some estimators that were read from damaged files.
    pub(in crate::render) fn is_consistent(&self, passes: u32, pixels: usize) -> bool {
        let fits = |count: usize| count == pixels;
        let nested_differences = self.nested_differences.as_ref();
        self.passes == passes
            && (passes == 0
                || self.variances.is_consistent(pixels) && self.leading_pictures.is_consistent(pixels, LEADING_PASSES))
            && self.shared_paths.is_consistent(pixels)
            && self.clamping_loss.as_ref().is_none_or(|sums| sums.pixel_count() == Some(pixels))
            && nested_differences.is_none_or(|sums| {
                sums.differences.iter().all(|sums| fits(sums.pixel_count()))
                    && fits(sums.products.pixel_count())
                    && fits(sums.discs.len())
                    && sums.leading_pictures.is_consistent(pixels, LEADING_PASSES_OF_DIFFERENCES)
            })
    }

    /// True if both estimators have the same number of pixels, the same pixels with unshared camera
    /// paths, and the same optional parts (density estimates, clamped light).
    fn has_same_pixels(&self, other: &Self) -> bool {
        let photon_pixels = |estimator: &Self| estimator.nested_differences.as_ref().map(|sums| sums.discs.len());
        self.variances.pixel_count() == other.variances.pixel_count()
            && photon_pixels(self) == photon_pixels(other)
            && self.shared_paths.pixel_indices() == other.shared_paths.pixel_indices()
            && self.clamping_loss.as_ref().map(ClampingLossSums::pixel_count)
                == other.clamping_loss.as_ref().map(ClampingLossSums::pixel_count)
    }

    /// Estimates the error of the mean of the passes, with an interval of 90 % confidence.
    ///
    /// `film` must hold exactly the passes added so far. The error is infinite before
    /// [`MIN_ERROR_ESTIMATE_PASSES`] passes.
    #[must_use]
    pub fn estimate(&self, film: &Film) -> ErrorEstimate {
        self.estimate_with_confidence(film, Confidence::default())
    }

    /// Estimates the error of the mean of the passes, with an interval of the given `confidence`.
    ///
    /// `film` must hold exactly the passes added so far. The error is infinite before
    /// [`MIN_ERROR_ESTIMATE_PASSES`] passes.
    #[must_use]
    pub fn estimate_with_confidence(&self, film: &Film, confidence: Confidence) -> ErrorEstimate {
        let passes = self.passes;
        if passes < MIN_ERROR_ESTIMATE_PASSES {
            let unknown = f64::INFINITY;
            let (error, low, high, noise, bias) = (unknown, 0.0, unknown, unknown, unknown);
            return ErrorEstimate { passes, error, low, high, noise, bias, ..ErrorEstimate::default() };
        }
        let n = f64::from(passes);
        let error_weights = self.error_weights(film);
        let pixels = self.variances.pixel_count();
        let fraction = 1.0 / error_weights.pixel_weights().len() as f64;
        let add_pixel = |sums: &mut PictureNoiseSums, i: usize| {
            let spread = self.variances.spread(film, i);
            let square = error_weights.pixel_weights()[i] * spread.squared_deviations.element_sum() / (n * (n - 1.0));
            if square > 1.0 {
                sums.fireflies.add(square, fraction);
            }
            let square = square.min(1.0);
            sums.squared_noise += square;
            sums.fourth_power_noise += square * square;
            sums.kurtosis_weighted_noise += square * square * (spread.kurtosis.min(n) - 1.0);
        };
        let sums = sum_over_pixels(pixels, add_pixel, PictureNoiseSums::add_sums);
        let PictureNoiseSums {
            squared_noise: noise2,
            fourth_power_noise: fourth,
            kurtosis_weighted_noise: tails,
            fireflies,
        } = sums;
        // Relative variance of the estimated noise variance, if pixels are independent.
        let independent = if noise2 > 0.0 { tails / (n * noise2 * noise2) } else { 0.0 };
        let noise2 = noise2 * fraction;
        let differences =
            self.nested_differences.as_ref().map(|sums| sums.nested_difference_moments(&error_weights, n));
        let blur = differences.as_ref().map(BlurEstimate::from_differences).unwrap_or_default();
        let (shared2, shared_variance) = self.shared_paths.shared_path_squared_error(&error_weights, film.size().0, n);
        let clamping = self.clamping_loss.as_ref().map(|sums| sums.squared_bias(&error_weights, n));
        let (clamping2, clamping_variance) = clamping.unwrap_or_default();
        // Noise makes both the squared error of this picture and the estimate of that error vary
        // about the expected squared error.
        let relative_variance = self.leading_pictures.squared_error_relative_variance(error_weights.pixel_weights(), n);
        // With outliers, the variance of a variance estimate is (kurtosis − 1) / 2 times its value
        // for Gaussian noise.
        let tail_factor = if fourth > 0.0 { 0.5 * tails / fourth } else { 1.0 };
        let parts = SquaredErrorParts {
            noise: noise2,
            realised_noise_relative_variance: relative_variance,
            noise_estimate_relative_variance: independent.max(tail_factor * relative_variance / (n - 1.0)),
            blur: blur.squared_blur,
            blur_variance: blur.squared_blur_variance,
            shared_paths: shared2,
            shared_paths_variance: shared_variance,
            clamping: clamping2,
            clamping_variance,
        };
        let (low, high) = parts.error_interval(confidence.gaussian_half_width());
        ErrorEstimate {
            passes,
            error: parts.total().sqrt(),
            low,
            high,
            noise: noise2.sqrt(),
            bias: (blur.squared_blur + shared2 + clamping2).sqrt(),
            blur: blur.squared_blur.sqrt(),
            shared_paths: shared2.sqrt(),
            clamping: clamping2.sqrt(),
            half_area_blur_ratio: blur.half_area_blur_ratio,
            blur_extrapolation_factor: blur.extrapolation_factor,
            parts,
            difference_moments: differences.unwrap_or_default(),
            fireflies,
        }
    }

    /// Returns the weights for relative errors. Errors are relative to the mean picture minus its
    /// estimated blur.
    ///
    /// Blur brightens the surroundings of a caustic, so errors relative to the blurred picture
    /// would be too small there. `film` must hold exactly the passes added so far.
    fn error_weights(&self, film: &Film) -> RelativeErrorWeights {
        let n = f64::from(self.passes.max(1));
        let mut pixels = film.mean_picture();
        let weights = RelativeErrorWeights::from_pixels(film.size(), &pixels);
        let Some(sums) = &self.nested_differences else { return weights };
        let moments = sums.nested_difference_moments(&weights, n);
        // The factor is small if noise hides the differences in most of the picture.
        let factor = moments.measurement_weight() * BlurEstimate::from_differences(&moments).extrapolation_factor;
        if factor <= 0.0 {
            return weights;
        }
        // Free the memory: two lists of weights would exceed the memory that `render::memory`
        // expects.
        drop(weights);
        pixels.par_iter_mut().enumerate().with_min_len(MIN_PIXELS_PER_TASK).for_each(|(i, pixel)| {
            // Pixels that are not finite stay so, and do not count in their neighborhoods.
            if pixel.is_finite() {
                let darkest = pixel.min(Vec3::ZERO);
                *pixel = (*pixel - sums.scaled_difference_sum(i, factor / n)).max(darkest);
            }
        });
        RelativeErrorWeights::from_pixels(film.size(), &pixels)
    }

    /// Returns a forecast of the error after more passes, starting from `estimate`; `None` before
    /// [`MIN_ERROR_ESTIMATE_PASSES`] passes.
    #[must_use]
    pub fn forecast(&self, estimate: &ErrorEstimate) -> Option<ErrorForecast> {
        let law = self.radius_law.map(|law| (law.alpha, law.kernel.nested_difference_variance_ratio()));
        estimate.error.is_finite().then(|| ErrorForecast::new(*estimate, law))
    }

    /// Returns the estimated error of each pixel. `film` must hold exactly the passes added so far.
    #[must_use]
    pub fn error_maps(&self, film: &Film) -> ErrorMaps {
        let n = f64::from(self.passes.max(1));
        let over = (n * (n - 1.0)).max(1.0);
        let pixels = (0..self.variances.pixel_count()).into_par_iter().with_min_len(MIN_PIXELS_PER_TASK);
        let spreads = pixels.map(|i| self.variances.spread(film, i));
        let noise = spreads.map(|pixel| (pixel.squared_deviations / over).map(f64::sqrt).as_vec3()).collect();
        let Some(sums) = &self.nested_differences else { return ErrorMaps { noise, ..ErrorMaps::default() } };
        let factor = self.estimate(film).blur_extrapolation_factor / n;
        let bias = (0..sums.discs.len()).map(|i| sums.scaled_difference_sum(i, factor)).collect();
        let discs = |map: usize| sums.discs.iter().map(|d| d[map].mean()).collect();
        ErrorMaps { noise, blur: bias, caustic_discs: discs(0), indirect_discs: discs(1) }
    }
}

impl PictureNoiseSums {
    /// Adds `other`, the sums over other pixels.
    fn add_sums(&mut self, other: Self) {
        self.squared_noise += other.squared_noise;
        self.fourth_power_noise += other.fourth_power_noise;
        self.kurtosis_weighted_noise += other.kurtosis_weighted_noise;
        self.fireflies.merge(&other.fireflies);
    }
}

impl NestedDifferenceSums {
    fn new(pixels: usize) -> Self {
        Self {
            differences: [BinnedSums::new(pixels), BinnedSums::new(pixels)],
            products: BinnedSums::new(pixels),
            discs: vec![[GatherDiscTotals::default(); 2]; pixels],
            leading_pictures: LeadingPassPictures::default(),
        }
    }

    fn add(&mut self, number: u32, pixels: &[NestedDifferences]) {
        for (step, sums) in self.differences.iter_mut().enumerate() {
            sums.add_to_all_pixels(|i| pixels[i].differences[step].as_dvec3().to_array());
        }
        self.products.add_to_all_pixels(|i| {
            let [a, b] = pixels[i].differences.map(|difference| difference.as_dvec3());
            [a.dot(a), a.dot(b), b.dot(b)]
        });
        let discs = self.discs.par_iter_mut().zip(pixels).with_min_len(MIN_PIXELS_PER_TASK);
        discs.for_each(|([caustic, indirect], pixel)| {
            caustic.add(pixel.caustic_disc);
            indirect.add(pixel.indirect_disc);
        });
        let differences = pixels.par_iter().map(|pixel| pixel.differences[0]);
        self.leading_pictures.add(number, LEADING_PASSES_OF_DIFFERENCES, differences);
    }

    /// Adds the passes of `other`, which must have the same number of pixels.
    fn merge(&mut self, other: &Self) {
        for (sums, other) in self.differences.iter_mut().zip(&other.differences) {
            sums.merge(other);
        }
        self.products.merge(&other.products);
        let discs = self.discs.par_iter_mut().zip(&other.discs).with_min_len(MIN_PIXELS_PER_TASK);
        discs.for_each(|(discs, others)| discs.iter_mut().zip(others).for_each(|(disc, other)| disc.merge(*other)));
        self.leading_pictures.merge(&other.leading_pictures, LEADING_PASSES_OF_DIFFERENCES);
    }

    /// Returns two sums over passes at pixel `i`: of D₀ = L(r) − L(r/√2), and of D₁ = L(r/√2) −
    /// L(r/2). L(r) is the density estimate with gather radius r.
    fn difference_sums(&self, i: usize) -> [DVec3; 2] {
        self.differences.each_ref().map(|sums| DVec3::from_array(sums.pixel_sums(i)))
    }

    /// Returns `factor` times the sum over passes of L(r) − L(r/2) at pixel `i`. L(r) is the
    /// density estimate with gather radius r.
    fn scaled_difference_sum(&self, i: usize, factor: f64) -> Vec3 {
        let [d0, d1] = self.difference_sums(i);
        ((d0 + d1) * factor).as_vec3()
    }

    /// Returns the means over the picture of D₀², D₀·D₁ and D₁² after `n` passes. Also returns the
    /// variance of D₀ in one pass, and the variance of the mean of D₀². All values are relative, by
    /// `error_weights`.
    ///
    /// D₀ = L(r) − L(r/√2) and D₁ = L(r/√2) − L(r/2), for the density estimate L(r) with gather
    /// radius r. Each product combines two different passes, so its noise has mean zero.
    fn nested_difference_moments(&self, error_weights: &RelativeErrorWeights, n: f64) -> NestedDifferenceMoments {
        let pixels = error_weights.pixel_weights().len();
        let sums = sums_of_values(pixels, |i| {
            let [a, b] = self.difference_sums(i);
            let same_pass = self.products.pixel_sums(i);
            let product = |all: f64, same_pass: f64| {
                error_weights.clamped_relative_squared_error(i, (all - same_pass) / (n * (n - 1.0)))
            };
            let variance =
                error_weights.clamped_relative_squared_error(i, (same_pass[0] - a.dot(a) / n) / (n * (n - 1.0)));
            let [d0_d0, d0_d1, d1_d1] = same_pass;
            [product(a.dot(a), d0_d0), product(a.dot(b), d0_d1), product(b.dot(b), d1_d1), variance]
        });
        let [d0_squared, d0_d1, d1_squared, variance] = sums.map(|sum| sum / pixels as f64);
        let variance = n * variance;
        let squared_noise_relative_variance =
            self.leading_pictures.squared_error_relative_variance(error_weights.pixel_weights(), n);
        let d0_squared_variance =
            NestedDifferenceMoments::d0_squared_variance(d0_squared, variance, squared_noise_relative_variance, n);
        NestedDifferenceMoments {
            d0_squared,
            d0_d1,
            d1_squared,
            d0_variance: variance,
            d0_squared_variance,
            squared_noise_relative_variance,
        }
    }
}

impl GatherDiscTotals {
    fn add(&mut self, discs: Option<MeanGatherDisc>) {
        if let Some(MeanGatherDisc { radius, mean_count }) = discs {
            self.radius_sum += radius;
            self.mean_count_sum += mean_count;
            self.passes += 1;
        }
    }

    /// Adds the totals of `other`, which are from other passes of the same pixel.
    fn merge(&mut self, other: Self) {
        self.radius_sum += other.radius_sum;
        self.mean_count_sum += other.mean_count_sum;
        self.passes += other.passes;
    }

    /// Returns the mean gather radius and the mean photon count of a disc. The means are over the
    /// passes that made a density estimate; 0 without such passes.
    fn mean(self) -> MeanGatherDisc {
        let n = self.passes.max(1) as f32;
        MeanGatherDisc { radius: self.radius_sum / n, mean_count: self.mean_count_sum / n }
    }
}
