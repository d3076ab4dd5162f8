//! ꟻLIP: how different two pictures look when they take turns at the same place.
//!
//! LDR-ꟻLIP is of Andersson et al. 2020 ("ꟻLIP: A Difference Evaluator for Alternating Images", HPG), HDR-ꟻLIP of Andersson et al.
//! 2021 ("Visualizing Errors in Rendered High Dynamic Range Images", Eurographics). Equations are named by the first.

mod color;
mod filter;
mod tone;

use super::buffer::Image;
use super::metrics::{MetricError, check_pair};
use super::tone::MAX_EXPOSURE_STOPS;
use color::{color_error, hunt_lab, opponent};
use filter::{Filters, Scratch};
use glam::Vec3;
use rayon::prelude::*;
use tone::{exposures, film};

/// Pixels per degree of a screen 0.7 m wide, of 3840 pixels, seen from 0.7 m: the papers' viewer.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// The range of pixels per degree: below it, filters are narrower than a pixel; above it, wider than pictures.
pub const PIXELS_PER_DEGREE_RANGE: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// What becomes of radiance before it is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlipMode {
    /// As a PNG of the sRGB curve shows it: radiance is multiplied by 2 to this power and clamped to [0, 1]. At most
    /// ±[`MAX_EXPOSURE_STOPS`].
    Ldr(f32),
    /// By a film curve at each of a range of exposures, about a stop apart, from where the brightest pixel of the reference is
    /// about to burn out to where the median is; each pixel keeps its largest error. The median is over pixels that are not black.
    Hdr,
}

/// How two pictures are looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlipOptions {
    /// Pixels of the picture in a degree of the viewer's field, within [`PIXELS_PER_DEGREE_RANGE`].
    pub pixels_per_degree: f64,
    /// Tone mapping.
    pub mode: FlipMode,
}

impl Default for FlipOptions {
    fn default() -> Self {
        Self { pixels_per_degree: PIXELS_PER_DEGREE, mode: FlipMode::Ldr(0.0) }
    }
}

/// How different two pictures look.
#[derive(Clone, Debug, PartialEq)]
pub struct Flip {
    /// Of each pixel, from 0 (the same) to 1, by rows from the top.
    pub map: Vec<f32>,
    /// The mean over pixels.
    pub mean: f64,
}

/// ꟻLIP of `test` against `reference`. `FlipMode::Ldr` treats both alike; `FlipMode::Hdr` takes its exposures from the reference.
/// Radiance below zero is black.
///
/// # Errors
/// [`MetricError`] where sizes differ, a pixel is not finite, or an option is out of range.
pub fn flip(reference: &Image, test: &Image, options: &FlipOptions) -> Result<Flip, MetricError> {
    check_pair(reference, test)?;
    let value = options.pixels_per_degree;
    if !PIXELS_PER_DEGREE_RANGE.contains(&value) {
        return Err(MetricError::Parameter { name: "pixels per degree", value });
    }
    let filters = Filters::new(value);
    let mut map = vec![0.0; reference.pixels().len()];
    match options.mode {
        FlipMode::Ldr(stops) => {
            if !(-MAX_EXPOSURE_STOPS..=MAX_EXPOSURE_STOPS).contains(&stops) {
                return Err(MetricError::Parameter { name: "exposure", value: stops.into() });
            }
            let scale = libm::exp2f(stops);
            let shown = |p: Vec3| (p * scale).clamp(Vec3::ZERO, Vec3::ONE);
            compare(&Opponent::of(reference, shown), &Opponent::of(test, shown), &filters, &mut map);
        }
        FlipMode::Hdr => {
            for stops in exposures(reference) {
                let scale = libm::exp2(stops);
                let shown = |p: Vec3| film(p, scale);
                compare(&Opponent::of(reference, shown), &Opponent::of(test, shown), &filters, &mut map);
            }
        }
    }
    let mean = map.iter().map(|&e| f64::from(e)).sum::<f64>() / map.len() as f64;
    Ok(Flip { map, mean })
}

/// A picture as the eye's channels: luminance, red against green, blue against yellow.
struct Opponent {
    width: usize,
    /// Y, Cx, Cz, each by rows.
    planes: [Vec<f32>; 3],
}

impl Opponent {
    /// `shown` turns radiance into linear light of the screen, in [0, 1].
    fn of(image: &Image, shown: impl Fn(Vec3) -> Vec3 + Sync) -> Self {
        let triples: Vec<Vec3> = image.pixels().par_iter().map(|&p| opponent(shown(p))).collect();
        let plane = |channel: usize| triples.iter().map(|t| t[channel]).collect();
        Self { width: image.width() as usize, planes: [plane(0), plane(1), plane(2)] }
    }
}

/// Raises each pixel of `map` to the error of the pair. Rows are independent, so threads change nothing.
fn compare(reference: &Opponent, test: &Opponent, filters: &Filters, map: &mut [f32]) {
    let width = reference.width;
    let scratch = || (Scratch::new(width, filters), Scratch::new(width, filters));
    map.par_chunks_mut(width).enumerate().for_each_init(scratch, |(a, b), (row, errors)| {
        a.see(&reference.planes, row, filters);
        b.see(&test.planes, row, filters);
        for (x, error) in errors.iter_mut().enumerate() {
            let color = color_error(hunt_lab(a.color(x)), hunt_lab(b.color(x)));
            // Equations 13 and 14.
            let feature = (a.edge(x) - b.edge(x)).abs().max((a.point(x) - b.point(x)).abs());
            let feature = (feature * std::f64::consts::FRAC_1_SQRT_2).sqrt().min(1.0);
            *error = error.max(libm::pow(color, 1.0 - feature) as f32);
        }
    });
}

#[cfg(test)]
mod tests;
