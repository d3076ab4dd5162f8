//! ꟻLIP: a perceptual metric of the difference seen when two pictures alternate.
//!
//! LDR-ꟻLIP: Andersson et al. 2020, "ꟻLIP: A Difference Evaluator for Alternating Images", HPG.
//! HDR-ꟻLIP: Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images",
//! Eurographics. Equation numbers are those of the first paper.

mod color;
mod filter;
mod tone;

use super::buffer::Image;
use super::metrics::{MetricError, check_comparable};
use super::tone::MAX_EXPOSURE_STOPS;
use color::{color_error, hunt_lab_from_ycxcz, rgb_to_ycxcz};
use filter::{FlipMetricFilters, FlipRowFilter};
use glam::Vec3;
use rayon::prelude::*;
use tone::{film_curve, hdr_flip_exposures};

/// Default number of pixels per degree of visual angle: a 0.7 m wide screen of 3840 pixels, seen
/// from 0.7 m.
pub const DEFAULT_PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Accepted numbers of pixels per degree of visual angle.
///
/// Below this range, filters would be narrower than a pixel. Above this range, filters would be
/// wider than most pictures.
pub const PIXELS_PER_DEGREE_RANGE: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// Variant of ꟻLIP: the tone mapping of the pictures before they are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlipMetricMode {
    /// LDR-ꟻLIP at one exposure \[stops], within ±[`MAX_EXPOSURE_STOPS`].
    ///
    /// Radiance is multiplied by 2 to the power of the exposure, and clamped to \[0, 1].
    Ldr(f32),
    /// HDR-ꟻLIP: the error of a pixel is its largest LDR error over exposures about one stop apart.
    ///
    /// The first exposure maps the brightest pixel of the reference close to white. The last
    /// exposure maps a typical pixel close to white: the median of all pixels of the reference that
    /// are not black.
    Hdr,
}

/// Options of [`flip_metric`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlipMetricOptions {
    /// Pixels per degree of visual angle, within [`PIXELS_PER_DEGREE_RANGE`].
    pub pixels_per_degree: f64,
    /// Variant of ꟻLIP: LDR at one exposure, or HDR.
    pub mode: FlipMetricMode,
}

impl Default for FlipMetricOptions {
    fn default() -> Self {
        Self { pixels_per_degree: DEFAULT_PIXELS_PER_DEGREE, mode: FlipMetricMode::Ldr(0.0) }
    }
}

/// ꟻLIP errors of a picture compared with a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMetricResult {
    /// Error of each pixel in \[0, 1], in rows from the top; 0 means equal.
    pub error_map: Vec<f32>,
    /// Mean of `error_map` over all pixels.
    pub mean: f64,
}

/// Computes the ꟻLIP error of `test` against `reference`, per pixel and as a mean. Negative
/// radiance counts as black.
///
/// The result for [`FlipMetricMode::Ldr`] does not change if the pictures are exchanged.
/// [`FlipMetricMode::Hdr`] derives its exposures from the reference.
///
/// # Errors
/// [`MetricError`] if the sizes differ, a pixel is not finite, or an option is out of range.
pub fn flip_metric(
    reference: &Image,
    test: &Image,
    options: &FlipMetricOptions,
) -> Result<FlipMetricResult, MetricError> {
    check_comparable(reference, test)?;
    let value = options.pixels_per_degree;
    if !PIXELS_PER_DEGREE_RANGE.contains(&value) {
        return Err(MetricError::OptionOutOfRange { name: "pixels per degree", value });
    }
    let filters = FlipMetricFilters::new(value);
    let mut map = vec![0.0; reference.pixels().len()];
    match options.mode {
        FlipMetricMode::Ldr(stops) => {
            if !(-MAX_EXPOSURE_STOPS..=MAX_EXPOSURE_STOPS).contains(&stops) {
                return Err(MetricError::OptionOutOfRange { name: "exposure", value: stops.into() });
            }
            let scale = libm::exp2f(stops);
            let shown = |p: Vec3| (p * scale).clamp(Vec3::ZERO, Vec3::ONE);
            accumulate_max_error(
                &OpponentColorImage::from_image(reference, shown),
                &OpponentColorImage::from_image(test, shown),
                &filters,
                &mut map,
            );
        }
        FlipMetricMode::Hdr => {
            for stops in hdr_flip_exposures(reference) {
                let scale = libm::exp2(stops);
                let shown = |p: Vec3| film_curve(p, scale);
                accumulate_max_error(
                    &OpponentColorImage::from_image(reference, shown),
                    &OpponentColorImage::from_image(test, shown),
                    &filters,
                    &mut map,
                );
            }
        }
    }
    let mean = map.iter().map(|&e| f64::from(e)).sum::<f64>() / map.len() as f64;
    Ok(FlipMetricResult { error_map: map, mean })
}

/// A picture in the opponent color space YCxCz: luminance, red-green, blue-yellow.
struct OpponentColorImage {
    width: usize,
    /// Planes of the channels Y, Cx and Cz, each in rows from the top.
    planes: [Vec<f32>; 3],
}

impl OpponentColorImage {
    /// Converts `image` to YCxCz. The callback `shown` maps radiance to linear display values in
    /// \[0, 1].
    fn from_image(image: &Image, shown: impl Fn(Vec3) -> Vec3 + Sync) -> Self {
        let triples: Vec<Vec3> = image.pixels().par_iter().map(|&p| rgb_to_ycxcz(shown(p))).collect();
        let plane = |channel: usize| triples.iter().map(|t| t[channel]).collect();
        Self { width: image.width() as usize, planes: [plane(0), plane(1), plane(2)] }
    }
}

/// Computes the ꟻLIP error of each pixel between `reference` and `test`. `map` holds the largest
/// error of each pixel so far, and is updated.
fn accumulate_max_error(
    reference: &OpponentColorImage,
    test: &OpponentColorImage,
    filters: &FlipMetricFilters,
    map: &mut [f32],
) {
    let width = reference.width;
    let scratch = || (FlipRowFilter::new(width, filters), FlipRowFilter::new(width, filters));
    map.par_chunks_mut(width).enumerate().for_each_init(scratch, |(a, b), (row, errors)| {
        a.filter_image_row(&reference.planes, row, filters);
        b.filter_image_row(&test.planes, row, filters);
        for (x, error) in errors.iter_mut().enumerate() {
            let color = color_error(hunt_lab_from_ycxcz(a.filtered_color(x)), hunt_lab_from_ycxcz(b.filtered_color(x)));
            // Combine color and feature errors by equations 13 and 14 of Andersson et al. 2020.
            let feature =
                (a.edge_strength(x) - b.edge_strength(x)).abs().max((a.point_strength(x) - b.point_strength(x)).abs());
            let feature = (feature * std::f64::consts::FRAC_1_SQRT_2).sqrt().min(1.0);
            *error = error.max(libm::pow(color, 1.0 - feature) as f32);
        }
    });
}

#[cfg(test)]
mod tests;
