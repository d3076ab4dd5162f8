//! What the eye resolves: blurs by contrast sensitivity, detectors of edges and points.

use super::color::luminance;
use glam::DVec3;
use std::f64::consts::PI;

/// Gaussians of the contrast sensitivity functions, as amplitude and b in a·√(π/b)·exp(−π²x²/b), x in degrees (table 1).
const LUMINANCE: (f64, f64) = (1.0, 0.0047);
const RED_GREEN: (f64, f64) = (1.0, 0.0053);
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// Width of the eye's detector of edges, from its peak to its trough, in degrees (section 4.2).
const DETECTOR: f64 = 0.082;

/// One row of a filter, from its left end; as long to both sides of its middle.
type Kernel = Vec<f32>;

/// The filters for some number of pixels per degree. All are products of a row and a column.
pub(super) struct Filters {
    luminance: Kernel,
    red_green: Kernel,
    /// Each with its part of the whole.
    blue_yellow: [(f32, Kernel); 2],
    /// A Gaussian, its first and its second derivative.
    detector: [Kernel; 3],
}

impl Filters {
    pub fn new(pixels_per_degree: f64) -> Self {
        // Three standard deviations of the widest, for all, as the paper.
        let radius = (3.0 * (BLUE_YELLOW[0].1 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let gaussian = |b: f64| {
            sampled(radius, |x| {
                let degrees = x / pixels_per_degree;
                libm::exp(-PI * PI * degrees * degrees / b)
            })
        };
        let blur = |b: f64| {
            let raw = gaussian(b);
            let sum: f64 = raw.iter().sum();
            (sum, single(raw.iter().map(|w| w / sum)))
        };
        let blue_yellow = BLUE_YELLOW.map(|(a, b)| {
            let (sum, kernel) = blur(b);
            (a * (PI / b).sqrt() * sum * sum, kernel)
        });
        let total = blue_yellow[0].0 + blue_yellow[1].0;
        Self {
            luminance: blur(LUMINANCE.1).1,
            red_green: blur(RED_GREEN.1).1,
            blue_yellow: blue_yellow.map(|(weight, kernel)| ((weight / total) as f32, kernel)),
            detector: detector(pixels_per_degree),
        }
    }

    /// The most that any filter reaches to one side.
    fn reach(&self) -> usize {
        self.luminance.len().max(self.detector[0].len()) / 2
    }
}

/// Gaussian of sum 1, and its derivatives with positive parts of sum 1 and negative ones of sum −1.
fn detector(pixels_per_degree: f64) -> [Kernel; 3] {
    let deviation = 0.5 * DETECTOR * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i32;
    let gaussian = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
    let raw = sampled(radius, gaussian);
    let sum: f64 = raw.iter().sum();
    let first = sampled(radius, |x| -x * gaussian(x));
    let second = sampled(radius, |x| (x * x / (deviation * deviation) - 1.0) * gaussian(x));
    [single(raw.iter().map(|w| w / sum)), balanced(&first), balanced(&second)]
}

fn balanced(raw: &[f64]) -> Kernel {
    let positive: f64 = raw.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -raw.iter().filter(|w| **w < 0.0).sum::<f64>();
    single(raw.iter().map(|w| if *w < 0.0 { w / negative } else { w / positive }))
}

fn sampled(radius: i32, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (-radius..=radius).map(|x| value(f64::from(x))).collect()
}

fn single(weights: impl Iterator<Item = f64>) -> Kernel {
    weights.map(|w| w as f32).collect()
}

/// One row of a picture as the eye sees it, and the room to find it.
pub(super) struct Scratch {
    /// The row between two columns of filters, with its ends repeated beyond both.
    padded: Vec<f32>,
    /// Y, Cx, Cz, and the second part of Cz.
    blurred: [Vec<f32>; 4],
    /// Edges and then points, each across and down.
    features: [Vec<f32>; 4],
}

impl Scratch {
    pub fn new(width: usize, filters: &Filters) -> Self {
        let row = || vec![0.0; width];
        Self {
            padded: vec![0.0; width + 2 * filters.reach()],
            blurred: std::array::from_fn(|_| row()),
            features: std::array::from_fn(|_| row()),
        }
    }

    /// Filters a row of the planes Y, Cx, Cz.
    pub fn see(&mut self, planes: &[Vec<f32>; 3], row: usize, filters: &Filters) {
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

    /// YCxCz of column `x`, blurred.
    pub fn color(&self, x: usize) -> DVec3 {
        let [y, cx, cz, _] = &self.blurred;
        DVec3::new(y[x].into(), cx[x].into(), cz[x].into())
    }

    /// How much of an edge column `x` is, in luminance.
    pub fn edge(&self, x: usize) -> f64 {
        magnitude(self.features[0][x], self.features[1][x])
    }

    /// How much of a point column `x` is, in luminance.
    pub fn point(&self, x: usize) -> f64 {
        magnitude(self.features[2][x], self.features[3][x])
    }
}

/// Detectors have the sum zero, so that of luminance only the scale matters.
fn magnitude(across: f32, down: f32) -> f64 {
    let scale = luminance(1.0) - luminance(0.0);
    let (a, d) = (f64::from(across), f64::from(down));
    scale * (a * a + d * d).sqrt()
}

/// One row of a plane under a column and a row of weights; pixels of the border go on beyond it.
fn filter_row(plane: &[f32], row: usize, down: &[f32], across: &[f32], padded: &mut [f32], out: &mut [f32]) {
    let width = out.len();
    let height = plane.len() / width;
    let (up, side) = (down.len() / 2, across.len() / 2);
    let (left, rest) = padded[..width + 2 * side].split_at_mut(side);
    let (middle, right) = rest.split_at_mut(width);
    middle.fill(0.0);
    for (j, weight) in down.iter().enumerate() {
        let from = (row + j).saturating_sub(up).min(height - 1);
        add(middle, *weight, &plane[from * width..][..width]);
    }
    left.fill(middle[0]);
    right.fill(middle[width - 1]);
    out.fill(0.0);
    for (j, weight) in across.iter().enumerate() {
        add(out, *weight, &padded[j..][..width]);
    }
}

fn add(sum: &mut [f32], weight: f32, values: &[f32]) {
    for (s, v) in sum.iter_mut().zip(values) {
        *s += weight * v;
    }
}
