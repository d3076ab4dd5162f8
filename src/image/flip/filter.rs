//! Filters of ꟻLIP: contrast sensitivity functions, and detectors of edges and points.

use super::color::ycxcz_y_to_luminance;
use glam::DVec3;
use std::f64::consts::PI;

/// Parameters (a, b) of the contrast sensitivity filter of channel Y, luminance.
///
/// At x degrees from its center, the filter is a·√(π/b)·exp(−π²x²/b) (Andersson et al. 2020, table
/// 1).
const LUMINANCE_CSF: (f64, f64) = (1.0, 0.0047);
/// Parameters (a, b) of the filter of channel Cx, red-green; see [`LUMINANCE_CSF`] for the formula.
const RED_GREEN_CSF: (f64, f64) = (1.0, 0.0053);
/// Parameters (a, b) of two Gaussians. The sum of both is the filter of channel Cz, blue-yellow;
/// see [`LUMINANCE_CSF`] for the formula.
const BLUE_YELLOW_CSF: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Width of the edge detector from peak to trough \[degrees] (Andersson et al. 2020, section 4.2).
const DETECTOR_WIDTH_DEGREES: f64 = 0.082;

/// Weights of a one-dimensional filter with an odd number of taps, from left to right.
type FilterWeights = Vec<f32>;

/// All filters of ꟻLIP for a given number of pixels per degree. The filters are separable, so each
/// is stored as one-dimensional weights.
pub(super) struct FlipMetricFilters {
    luminance: FilterWeights,
    red_green: FilterWeights,
    /// Two Gaussians for channel Cz, each with its weight. The weighted sum of both results is the
    /// filtered channel.
    blue_yellow: [(f32, FilterWeights); 2],
    /// One-dimensional filters of the feature detectors: a Gaussian, its first and its second
    /// derivative.
    detector: [FilterWeights; 3],
}

impl FlipMetricFilters {
    pub fn new(pixels_per_degree: f64) -> Self {
        // All blurs have the radius of the widest blur, three standard deviations, as in the paper.
        let radius = (3.0 * (BLUE_YELLOW_CSF[0].1 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let gaussian = |b: f64| {
            sample_at_integers(radius, |x| {
                let degrees = x / pixels_per_degree;
                libm::exp(-PI * PI * degrees * degrees / b)
            })
        };
        let blur = |b: f64| {
            let raw = gaussian(b);
            let sum: f64 = raw.iter().sum();
            (sum, to_single_precision(raw.iter().map(|w| w / sum)))
        };
        let blue_yellow = BLUE_YELLOW_CSF.map(|(a, b)| {
            let (sum, kernel) = blur(b);
            (a * (PI / b).sqrt() * sum * sum, kernel)
        });
        let total = blue_yellow[0].0 + blue_yellow[1].0;
        Self {
            luminance: blur(LUMINANCE_CSF.1).1,
            red_green: blur(RED_GREEN_CSF.1).1,
            blue_yellow: blue_yellow.map(|(weight, kernel)| ((weight / total) as f32, kernel)),
            detector: feature_detectors(pixels_per_degree),
        }
    }

    /// Radius of the widest filter \[pixels].
    fn max_radius(&self) -> usize {
        self.luminance.len().max(self.detector[0].len()) / 2
    }
}

/// Returns the detector filters: a Gaussian, its first derivative (edges) and its second derivative
/// (points).
///
/// The weights of the Gaussian sum to 1. The positive weights of each derivative sum to 1, the
/// negative ones to −1.
fn feature_detectors(pixels_per_degree: f64) -> [FilterWeights; 3] {
    let deviation = 0.5 * DETECTOR_WIDTH_DEGREES * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i32;
    let gaussian = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
    let raw = sample_at_integers(radius, gaussian);
    let sum: f64 = raw.iter().sum();
    let first = sample_at_integers(radius, |x| -x * gaussian(x));
    let second = sample_at_integers(radius, |x| (x * x / (deviation * deviation) - 1.0) * gaussian(x));
    [
        to_single_precision(raw.iter().map(|w| w / sum)),
        normalize_signed_weights(&first),
        normalize_signed_weights(&second),
    ]
}

/// Scales the positive weights to a sum of 1, and the negative weights to a sum of −1.
fn normalize_signed_weights(raw: &[f64]) -> FilterWeights {
    let positive: f64 = raw.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -raw.iter().filter(|w| **w < 0.0).sum::<f64>();
    to_single_precision(raw.iter().map(|w| if *w < 0.0 { w / negative } else { w / positive }))
}

/// Returns the values of the function `value` at the integers from −`radius` to `radius`.
fn sample_at_integers(radius: i32, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (-radius..=radius).map(|x| value(f64::from(x))).collect()
}

/// Rounds filter weights to single precision.
fn to_single_precision(weights: impl Iterator<Item = f64>) -> FilterWeights {
    weights.map(|w| w as f32).collect()
}

/// Results of all filters for one row of a picture, with working memory to compute them.
pub(super) struct FlipRowFilter {
    /// Working memory: one row, filtered vertically but not yet horizontally. Its end pixels are
    /// repeated to the left and right, for the horizontal filter.
    padded: Vec<f32>,
    /// Blurred channels Y, Cx and Cz, one row each. The fourth row is working memory: it holds Cz,
    /// blurred by the second Gaussian of the filter of Cz.
    blurred: [Vec<f32>; 4],
    /// Responses of the edge detector along x and along y, then of the point detector along x and
    /// along y.
    features: [Vec<f32>; 4],
}

impl FlipRowFilter {
    pub fn new(width: usize, filters: &FlipMetricFilters) -> Self {
        let row = || vec![0.0; width];
        Self {
            padded: vec![0.0; width + 2 * filters.max_radius()],
            blurred: std::array::from_fn(|_| row()),
            features: std::array::from_fn(|_| row()),
        }
    }

    /// Applies all filters to row `row` of the `planes` Y, Cx and Cz, and stores the results in
    /// `self`.
    pub fn filter_image_row(&mut self, planes: &[Vec<f32>; 3], row: usize, filters: &FlipMetricFilters) {
        let [(share, kernel), (other_share, other)] = &filters.blue_yellow;
        let padded = &mut self.padded;
        let [y, cx, cz, rest] = &mut self.blurred;
        filter_row(&planes[0], row, &filters.luminance, &filters.luminance, padded, y);
        filter_row(&planes[1], row, &filters.red_green, &filters.red_green, padded, cx);
        filter_row(&planes[2], row, kernel, kernel, padded, cz);
        filter_row(&planes[2], row, other, other, padded, rest);
        cz.iter_mut().zip(rest).for_each(|(a, b)| *a = *a * share + *b * other_share);

        let [gaussian, first, second] = &filters.detector;
        let [across, down, point_across, point_down] = &mut self.features;
        filter_row(&planes[0], row, gaussian, first, padded, across);
        filter_row(&planes[0], row, first, gaussian, padded, down);
        filter_row(&planes[0], row, gaussian, second, padded, point_across);
        filter_row(&planes[0], row, second, gaussian, padded, point_down);
    }

    /// Blurred YCxCz color at column `x` of the filtered row.
    pub fn filtered_color(&self, x: usize) -> DVec3 {
        let [y, cx, cz, _] = &self.blurred;
        DVec3::new(y[x].into(), cx[x].into(), cz[x].into())
    }

    /// Strength of the edge that the detector finds at column `x` of the filtered row: a difference
    /// of luminance relative to white.
    pub fn edge_strength(&self, x: usize) -> f64 {
        feature_magnitude(self.features[0][x], self.features[1][x])
    }

    /// Strength of an isolated point, such as a firefly, at column `x` of the filtered row: a
    /// difference of luminance relative to white.
    pub fn point_strength(&self, x: usize) -> f64 {
        feature_magnitude(self.features[2][x], self.features[3][x])
    }
}

/// Returns the strength of an edge or a point as a difference of luminance relative to white. The
/// arguments are the detector's responses along x (`across`) and along y (`down`).
///
/// Channel Y of YCxCz is 116 times luminance minus 16. Detector weights sum to 0, so the offset 16
/// has no effect.
fn feature_magnitude(across: f32, down: f32) -> f64 {
    let scale = ycxcz_y_to_luminance(1.0) - ycxcz_y_to_luminance(0.0);
    let (a, d) = (f64::from(across), f64::from(down));
    scale * (a * a + d * d).sqrt()
}

/// Filters row `row` of `plane` with the vertical weights `down` and the horizontal weights
/// `across`. The result is stored in `out`.
///
/// Border pixels are repeated outside the picture. `padded` is working memory.
fn filter_row(plane: &[f32], row: usize, down: &[f32], across: &[f32], padded: &mut [f32], out: &mut [f32]) {
    let width = out.len();
    let height = plane.len() / width;
    let (up, side) = (down.len() / 2, across.len() / 2);
    let (left, rest) = padded[..width + 2 * side].split_at_mut(side);
    let (middle, right) = rest.split_at_mut(width);
    middle.fill(0.0);
    for (j, weight) in down.iter().enumerate() {
        let from = (row + j).saturating_sub(up).min(height - 1);
        add_weighted(middle, *weight, &plane[from * width..][..width]);
    }
    left.fill(middle[0]);
    right.fill(middle[width - 1]);
    out.fill(0.0);
    for (j, weight) in across.iter().enumerate() {
        add_weighted(out, *weight, &padded[j..][..width]);
    }
}

/// Adds `weight` times `values` to `sum`.
fn add_weighted(sum: &mut [f32], weight: f32, values: &[f32]) {
    for (s, v) in sum.iter_mut().zip(values) {
        *s += weight * v;
    }
}
