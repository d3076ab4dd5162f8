//! What a gauge tells of the picture so far.

use super::specks::Specks;
use super::{ErrorEstimator, Estimates, Frozen};
use crate::image::RelativeScale;
use crate::render::Film;
use serde::Serialize;

/// How sure an interval is to hold the true error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Confidence(f64);

impl Confidence {
    /// Of an interval that is a point.
    pub const LEAST: Self = Self(1e-9);

    /// `None` where `part` is not between 0 and 1.
    #[must_use]
    pub fn new(part: f64) -> Option<Self> {
        (part > 0.0 && part < 1.0).then_some(Self(part))
    }

    /// As given.
    #[must_use]
    pub fn part(self) -> f64 {
        self.0
    }

    /// Standard deviations of a Gaussian within which so large a part of it lies, on both sides.
    #[must_use]
    pub fn deviations(self) -> f64 {
        // Sixty halvings leave nothing of the interval; beyond forty deviations is less than the least number.
        let (mut low, mut high) = (0.0, 40.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if libm::erf(middle * std::f64::consts::FRAC_1_SQRT_2) < self.0 { low = middle } else { high = middle }
        }
        high
    }
}

impl Default for Confidence {
    /// 90 %.
    fn default() -> Self {
        Self(0.9)
    }
}

/// The error of a picture as far as its own passes show it. All errors are relative, on the scale of
/// [`RelativeScale`](crate::image::RelativeScale).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorEstimate {
    /// Passes made.
    pub passes: u32,
    /// Root of noise² + bias².
    pub error: f64,
    /// Between this and `high` the error lies with the confidence that was asked for.
    pub low: f64,
    /// See `low`.
    pub high: f64,
    /// Standard error of the mean of the passes.
    pub noise: f64,
    /// What more passes of the same kind would not average away: root of blur² + frozen².
    pub bias: f64,
    /// Of that, the part that goes with the radii of estimates.
    pub blur: f64,
    /// Of that, the part of camera walks that all passes share.
    pub frozen: f64,
    /// Blur at half the area over that at the whole: ½ in smooth light, more at edges.
    #[serde(skip)]
    pub(super) ratio: f64,
    /// Blur over |D₀ + D₁|, the part of it that is seen.
    #[serde(skip)]
    pub(super) extrapolation: f64,
    /// Relative variance of a pass.
    #[serde(skip)]
    pub(super) variance: f64,
    /// Relative variance of D₀ of a pass.
    #[serde(skip)]
    pub(super) step_variance: f64,
    /// The part of the variance that is of single bright finds.
    #[serde(skip)]
    pub(super) specks: Specks,
}

/// The fewest passes that an error can be told from.
pub const FEWEST: u32 = 4;

/// The least D₀·D₁ over ‖D₀‖²: steps that undo each other more than this are noise.
const UNDOING: f64 = -0.5;

/// D₀·D₁ over ‖D₀‖² about the edge of light, of Epanechnikov's kernel: more is not taken into the law, whose sum would have no end.
const EDGE: f64 = 0.7275;

/// ‖D₁‖² over ‖D₀‖² and what the whole blur is, by that kernel, of an edge and of bands of light that are a half and a fifth as wide as
/// the disc. What is finer still cannot be told by its own photons.
const ROUGH: [(f64, f64); 3] = [(0.7074, 14.6), (0.957, 16.9), (1.3145, 45.2)];

/// A blur whose steps hardly shrink is taken to go away as that of an edge.
const MOST_RATIO: f64 = 0.841;

/// The part of the blur that is not seen but extrapolated is uncertain by half of itself: edges and bands, which show alike, differ by
/// as much.
const UNSEEN: f64 = 0.5;

/// Edge of the tiles in which pixels are walked anew, or more: neighbours are alike.
const TILE: u32 = 16;

/// Sums of squares and products of what finer discs tell, without noise in the mean.
struct Steps {
    /// ‖D₀‖², D₀·D₁, ‖D₁‖².
    zero: f64,
    both: f64,
    one: f64,
    /// Relative variance of D₀ of a pass.
    variance: f64,
    /// Variance of `zero`.
    doubt: f64,
}

impl ErrorEstimator {
    /// The error of the mean of the passes so far, with an interval of the usual confidence. With fewer than four passes nothing is
    /// known: every number is infinite.
    #[must_use]
    pub fn read(&self, film: &Film) -> ErrorEstimate {
        self.read_with(film, Confidence::default())
    }

    /// The same with an interval of the given confidence.
    #[must_use]
    pub fn read_with(&self, film: &Film, confidence: Confidence) -> ErrorEstimate {
        let passes = self.passes;
        if passes < FEWEST {
            let unknown = f64::INFINITY;
            let (error, low, high, noise, bias) = (unknown, 0.0, unknown, unknown, unknown);
            return ErrorEstimate { passes, error, low, high, noise, bias, ..ErrorEstimate::default() };
        }
        let n = f64::from(passes);
        let scale = RelativeScale::of_pixels(film.size(), &film.mean());
        let mut specks = Specks::default();
        let part = 1.0 / scale.weights().len() as f64;
        let noise2 = self.deviations.iter().zip(scale.weights()).map(|(deviation, weight)| {
            let square = weight * deviation.element_sum() / (n * (n - 1.0));
            if square > 1.0 {
                specks.add(square, part);
            }
            square.min(1.0)
        });
        let noise2 = noise2.sum::<f64>() * part;
        let steps = self.estimates.as_ref().map(|estimates| estimates.steps(&scale, n));
        let blur = steps.as_ref().map(extrapolated).unwrap_or_default();
        let (frozen2, frozen_doubt) = self.frozen.square(&scale, film.size().0, n);
        let square = noise2 + blur.square + frozen2;
        // The error of this one picture scatters about what is expected, and what is expected is only estimated.
        let scatter = self.spread.scatter();
        let realised = noise2 * noise2 * scatter + 2.0 * noise2 * (blur.square + frozen2) * scatter;
        let estimated = noise2 * noise2 * self.spread.doubt().max(scatter / (n - 1.0));
        let deviation = (realised + estimated + blur.doubt + frozen_doubt).sqrt();
        let reach = confidence.deviations() * deviation;
        let error = square.sqrt();
        ErrorEstimate {
            passes,
            error,
            low: (square - reach).max(0.0).sqrt(),
            high: (square + reach).sqrt(),
            noise: noise2.sqrt(),
            bias: (blur.square + frozen2).sqrt(),
            blur: blur.square.sqrt(),
            frozen: frozen2.sqrt(),
            ratio: blur.ratio,
            extrapolation: blur.extrapolation,
            variance: noise2 * n,
            step_variance: steps.map_or(0.0, |steps| steps.variance),
            specks,
        }
    }
}

impl Estimates {
    fn steps(&self, scale: &RelativeScale, n: f64) -> Steps {
        let [zero, one] = &self.steps;
        let pixels = scale.weights().len();
        let (mut square, mut variance) = ([0.0; 3], 0.0);
        for i in 0..pixels {
            let (a, b) = (zero[i].as_dvec3(), one[i].as_dvec3());
            let products = self.products[i];
            for ((sum, whole), same) in square.iter_mut().zip([a.dot(a), a.dot(b), b.dot(b)]).zip(products) {
                *sum += scale.counts(i, (whole - same) / (n * (n - 1.0)));
            }
            variance += scale.counts(i, (products[0] - a.dot(a) / n) / (n * (n - 1.0)));
        }
        let [zero, both, one] = square.map(|sum| sum / pixels as f64);
        let variance = n * variance / pixels as f64;
        // Of a sum over pairs of passes, and of its product with what it looks for.
        let scatter = self.spread.scatter();
        let doubt = variance * variance * scatter / (n * (n - 1.0)) + 2.0 * zero.max(0.0) * variance * scatter / n;
        Steps { zero, both, one, variance, doubt }
    }
}

/// Squared blur, as far as two steps show it.
#[derive(Default)]
struct Blur {
    square: f64,
    /// Variance of that.
    doubt: f64,
    ratio: f64,
    extrapolation: f64,
}

/// What D₀, D₁ and all that would follow add up to.
///
/// In smooth light each step is half of the last; about edges and foci, which look alike at all scales, steps shrink by another ratio q, and
/// point less and less the same way, or against each other where features of all sizes lie side by side: Dᵢ·Dⱼ = ‖D₀‖² q^(i+j) c^|i−j|. So
/// ‖Σ Dᵢ‖² = ‖D₀‖² (1 + qc)/((1 − qc)(1 − q²)), which is 4‖D₀‖² in smooth light. q² and qc are what is measured, as far as they stand out
/// from noise.
fn extrapolated(steps: &Steps) -> Blur {
    let zero = steps.zero.max(0.0);
    if zero <= 0.0 {
        return Blur { square: 0.0, doubt: 16.0 * steps.doubt, ratio: 0.5, extrapolation: 0.0 };
    }
    // What stands out from its own doubt, and matters beside the noise, has a say in the law; else light is taken to be smooth.
    let trust = zero * zero / (zero * zero + 4.0 * steps.doubt);
    let squared = (steps.one / zero).clamp(0.0, ROUGH[2].0);
    let together = (steps.both / zero).clamp(UNDOING, EDGE).clamp(-squared.sqrt(), squared.sqrt());
    let squared = 0.25 + trust * (squared - 0.25);
    let together = 0.5 + trust * (together - 0.5);
    let whole = all_steps(together, squared);
    let seen = 1.0 + 2.0 * together + squared;
    let square = zero * whole;
    let unseen = square.sqrt() - (zero * seen).sqrt();
    let of_law = 2.0 * square.sqrt() * UNSEEN * unseen;
    Blur {
        square,
        doubt: whole * whole * steps.doubt + of_law * of_law,
        // The law of areas by which the blur shrinks is that of light between smooth and rough.
        ratio: squared.sqrt().clamp(0.5, MOST_RATIO),
        extrapolation: (whole / seen).sqrt(),
    }
}

/// ‖Σ Dᵢ‖² over ‖D₀‖²: by the law of [`extrapolated`], but no more than edges and bands of light show.
fn all_steps(together: f64, squared: f64) -> f64 {
    let law = (1.0 + together) / ((1.0 - together) * (1.0 - squared.min(ROUGH[0].0)));
    let rough = ROUGH.windows(2).find(|pair| squared <= pair[1].0).map_or(ROUGH[2].1, |pair| {
        let [(q, s), (next_q, next_s)] = [pair[0], pair[1]];
        s + (next_s - s) * ((squared - q) / (next_q - q)).max(0.0)
    });
    law.min(rough)
}

impl Frozen {
    /// Mean relative square of what shared walks do in a picture of so many columns, and the variance of that, by what tells its tiles apart.
    fn square(&self, scale: &RelativeScale, columns: u32, n: f64) -> (f64, f64) {
        if self.places.is_empty() {
            return (0.0, 0.0);
        }
        let tile = |at: u32| (at % columns / TILE, at / columns / TILE);
        let one = |((at, sum), square): ((&u32, &glam::DVec3), &f64)| {
            (tile(*at), scale.counts(*at as usize, (sum.length_squared() - square) / (n * (n - 1.0))))
        };
        let values: Vec<_> = self.places.iter().zip(&self.sums).zip(&self.squares).map(one).collect();
        let mean = values.iter().map(|(_, value)| value).sum::<f64>() / values.len() as f64;
        // Of sums of deviations: tiles at the border are smaller than others.
        let tiles = values.chunk_by(|a, b| a.0 == b.0);
        let sums: Vec<f64> = tiles.map(|tile| tile.iter().map(|(_, value)| value - mean).sum()).collect();
        let count = sums.len() as f64;
        let variance = sums.iter().map(|sum| sum * sum).sum::<f64>() / (values.len() as f64 * values.len() as f64);
        let one_tile = mean * mean;
        (mean.max(0.0), if sums.len() > 1 { variance * count / (count - 1.0) } else { one_tile })
    }
}
