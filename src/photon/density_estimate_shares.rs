//! Shares of density estimates: the fraction of the flux of caustic photons that density estimates
//! use, for each pixel of the film. Light tracing splats the rest.
//!
//! A density estimate blurs a caustic over its disc. Splats do not blur, but are noisy where few
//! photons fall in a pixel. Each caustic photon therefore divides its flux: a fraction, the
//! *share*, goes to density estimates, and the rest to its splat. The share depends only on film
//! position, so all light is counted exactly once.
//!
//! Let n be the number of photons that fall in a pixel per pass, k the number of photons in a
//! density estimate, and b² its squared relative error by blur. The mean of N passes has the
//! relative variance 1/(N·n) for splats, and the relative squared error 1/(N·k) + b² for density
//! estimates. Their weighted mean has the least squared error if splats and density estimates carry
//! flux in the ratio n/k + N·n·b². Both terms grow from pass to pass: k shrinks with the gather
//! disc, about as N^-⅓, and b² shrinks more slowly than 1/N.

mod blur_map;
mod splat_image;

use super::deposits::Splat;
use super::surface_photon::SHARE_STEPS;
use crate::math::SummedAreaTable;
use blur_map::BlurMap;
use glam::Vec2;
use rayon::prelude::*;
use splat_image::SplatImage;

/// Weight of the squared blur of density estimates in the [`FluxRatio`] of the first pass: the
/// ratio of splat flux to density-estimate flux.
///
/// For N passes, the best weight is N, which is not known in advance. The first passes blur most,
/// and their blur stays in the mean. So already their weight suits a render of several passes.
/// docs/decisions/048-light-tracing.md compares values.
const BLUR_WEIGHT: f64 = 10.0;

/// Number n₀ of photons per pixel and pass at which the term (n/n₀)² of a [`FluxRatio`] is 1. A
/// `FluxRatio` is the ratio of splat flux to density-estimate flux.
///
/// The term is there because blur within a pixel is invisible to the pilot. At a focus smaller than
/// a pixel, few camera rays meet the focus, and each density estimate there has a large error. Many
/// photons fall in such a pixel.
const FOCUS_PHOTONS: f64 = 10.0;

/// Largest half width \[pixels] of the square that stands for the disc of a density estimate.
const MAX_DISC_HALF_WIDTH: u32 = 12;

/// Fraction of a caustic photon's flux that density estimates use, for each pixel of the film. The
/// rest of the flux goes to a splat, which adds it directly to the film (light tracing).
///
/// The fraction falls from pass to pass, because the noise of splats falls faster with the number
/// of passes than the blur of density estimates.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityEstimateShares {
    width: u32,
    height: u32,
    /// Ratio of splat flux to density-estimate flux in the first pass, for each pixel, by rows from
    /// the top.
    first_pass_ratios: Vec<FluxRatio>,
}

/// Ratio of the caustic flux that splats carry to the flux that density estimates use. The ratio is
/// the sum of two terms, which grow differently from pass to pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct FluxRatio {
    /// Term for the noise of density estimates in the first pass: n/k for n photons per pixel and k
    /// photons in a density estimate.
    noise: f32,
    /// Term for the blur of density estimates in the first pass; infinite where splats carry all
    /// flux.
    blur: f32,
}

/// Fraction of a caustic photon's flux that density estimates use, for each pixel of the film, in
/// one given pass. [`DensityEstimateShares`] holds the data for all passes.
#[derive(Clone, Copy, Debug)]
pub struct PassDensityEstimateShares<'a> {
    shares: &'a DensityEstimateShares,
    /// Factor on the noise term of a [`FluxRatio`] (ratio of splat flux to density-estimate flux),
    /// relative to the first pass: (i + 1)^⅓ in pass i, counted from 0.
    noise_growth: f32,
    /// Factor on the blur term of a [`FluxRatio`] (ratio of splat flux to density-estimate flux),
    /// relative to the first pass: (i + 1)^⅔ in pass i, counted from 0.
    blur_growth: f32,
}

impl DensityEstimateShares {
    /// Computes, for each pixel, the fraction of caustic flux that density estimates use. In pass
    /// i, counted from 0, this fraction is 1/(1 + (i + 1)^⅓·n/k + (i + 1)^⅔·(10·n·b² + (n/10)²)).
    /// Here n is the estimated number of caustic photons per pixel and pass, and b² the estimated
    /// squared relative error of a density estimate by blur.
    ///
    /// Both n and b² are estimated from the `splats` of a small simulation before the render.
    /// `ratio` is the number of photon paths in a pass, divided by their number in that simulation.
    /// `gather_count` is k, the number of photons in a density estimate of the first pass. Each of
    /// the terms t = n/k and t = 10·n·b² + (n/10)² is smoothed over the area of a density
    /// estimate's disc, so that the fractions have no edges: ln(1 + t) is averaged.
    #[must_use]
    pub fn from_splats(splats: &[Splat], (width, height): (u32, u32), ratio: f64, gather_count: f64) -> Self {
        let image = SplatImage::new(splats, (width, height));
        let pixels = 0..image.sums.len();
        if !image.has_splats() {
            return Self { width, height, first_pass_ratios: vec![FluxRatio::default(); pixels.len()] };
        }

        let counts: Vec<f64> =
            pixels.clone().into_par_iter().map(|pixel| ratio * image.splats_per_pixel(pixel)).collect();
        let disc_half_widths: Vec<u8> = counts.par_iter().map(|count| disc_half_width(gather_count / count)).collect();
        let blurs = BlurMap::new(&image, &disc_half_widths);
        let blur_term = |pixel: usize| {
            let n = counts[pixel];
            let relative = n / FOCUS_PHOTONS;
            BLUR_WEIGHT * n * blurs.squared_blur(image.column_and_row(pixel)) + relative * relative
        };
        let noise_terms = counts.par_iter().map(|n| n / gather_count).collect();
        let blur_terms = pixels.into_par_iter().map(blur_term).collect();

        // An edge between different shares would show in the picture, because density estimates
        // blur it and splats do not. So shares change only over distances as large as the disc.
        let smoothed = |terms: Vec<f64>| -> Vec<f32> {
            let logarithms: Vec<f64> = terms.into_par_iter().map(libm::log1p).collect();
            let table = SummedAreaTable::new(&logarithms, (width as usize, height as usize));
            let smooth = |(pixel, half_width): (usize, &u8)| table.square_mean(pixel, (*half_width).into());
            let means = disc_half_widths.par_iter().enumerate().map(smooth);
            means.map(|mean| libm::expm1(mean) as f32).collect()
        };
        let terms = smoothed(noise_terms).into_iter().zip(smoothed(blur_terms));
        let first_pass_ratios = terms.map(|(noise, blur)| FluxRatio { noise, blur }).collect();
        Self { width, height, first_pass_ratios }
    }

    /// Returns shares of 0 for all pixels of a film of the given width and height \[pixels]: splats
    /// carry all caustic flux, and density estimates none.
    #[must_use]
    pub fn all_to_splats((width, height): (u32, u32)) -> Self {
        let ratio = FluxRatio { noise: 0.0, blur: f32::INFINITY };
        Self { width, height, first_pass_ratios: vec![ratio; width as usize * height as usize] }
    }

    /// Returns the fractions of caustic flux that density estimates use in pass `pass`, counted
    /// from 0.
    #[must_use]
    pub fn in_pass(&self, pass: u32) -> PassDensityEstimateShares<'_> {
        let root = libm::cbrt(f64::from(pass) + 1.0);
        PassDensityEstimateShares { shares: self, noise_growth: root as f32, blur_growth: (root * root) as f32 }
    }
}

impl PassDensityEstimateShares<'_> {
    /// Returns the fraction of caustic flux that density estimates use at `film_position` \[pixels
    /// from the top left], in units of 1/[`SHARE_STEPS`]. Outside the film, the fraction is 1.
    #[inline]
    pub(super) fn share_steps_at_film_position(&self, film_position: Vec2) -> u8 {
        let DensityEstimateShares { width, height, first_pass_ratios } = self.shares;
        pixel_at_film_position(film_position, *width, *height).map_or(SHARE_STEPS, |(x, y)| {
            let FluxRatio { noise, blur } = first_pass_ratios[y as usize * *width as usize + x as usize];
            let ratio = self.noise_growth * noise + self.blur_growth * blur;
            (f32::from(SHARE_STEPS) / (1.0 + ratio)).round() as u8
        })
    }
}

/// Returns column and row of the pixel that contains `film_position` \[pixels from the top left];
/// `None` outside the film.
#[inline]
fn pixel_at_film_position(film_position: Vec2, width: u32, height: u32) -> Option<(u32, u32)> {
    let inside =
        film_position.cmpge(Vec2::ZERO).all() && film_position.x < width as f32 && film_position.y < height as f32;
    inside.then_some((film_position.x as u32, film_position.y as u32))
}

/// Returns the half width \[pixels] of the square that stands for the disc of a density estimate.
/// The disc has the area `area` \[pixels²]. The half width is at least 1 and at most
/// [`MAX_DISC_HALF_WIDTH`].
fn disc_half_width(area: f64) -> u8 {
    ((area.sqrt() - 1.0) / 2.0).round().clamp(1.0, f64::from(MAX_DISC_HALF_WIDTH)) as u8
}

#[cfg(test)]
mod tests;
