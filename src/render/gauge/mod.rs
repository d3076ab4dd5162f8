//! The error of a picture while it is made: noise from how passes differ, bias from what their photons tell at finer discs.
//!
//! Passes are independent, so the noise of their mean is s²/n (Welford). Bias comes from differences D₀ = L(r) − L(r/√2) and
//! D₁ = L(r/√2) − L(r/2) of estimates by the same photons: with all that follow they add up to L(r) − L(0), the bias itself. Squares and
//! products are taken between passes that differ, so noise adds nothing to them in the mean.

mod forecast;
mod reading;
mod specks;
mod spread;

pub use forecast::{Forecast, Needed};
pub use reading::{Confidence, ErrorEstimate, FEWEST};

use super::Film;
use crate::image::RelativeScale;
use crate::integrate::{Discs, NestedEstimates, Pass, RadiusLaw};
use glam::{DVec3, Vec3};
use spread::Spread;

/// Learns the error of a picture from its passes.
#[derive(Clone, Debug)]
pub struct ErrorEstimator {
    law: Option<RadiusLaw>,
    passes: u32,
    /// Σ (x − mean)² by channel. Squares of what single precision holds are double.
    deviations: Vec<DVec3>,
    estimates: Option<Estimates>,
    frozen: Frozen,
    spread: Spread,
    scale: Option<RelativeScale>,
}

/// Sums over passes of what estimates tell.
#[derive(Clone, Debug)]
struct Estimates {
    /// Of D₀ and D₁.
    steps: [Vec<Vec3>; 2],
    /// Of D₀², D₀·D₁ and D₁², over channels.
    products: Vec<[f64; 3]>,
    discs: Vec<[DiscMean; 2]>,
    spread: Spread,
}

#[derive(Clone, Copy, Debug, Default)]
struct DiscMean {
    radius: f32,
    photons: f32,
    passes: u32,
}

/// What walks that all passes share do to the picture, seen at some of its pixels.
#[derive(Clone, Debug, Default)]
struct Frozen {
    places: Vec<u32>,
    /// Σ of the pixel less the same by fresh walks.
    sums: Vec<DVec3>,
    /// Σ of its square, over channels.
    squares: Vec<f64>,
}

/// What a gauge knows of each pixel, by rows from the top.
#[derive(Clone, Debug, Default)]
pub struct ErrorMaps {
    /// Standard error of the mean of the passes \[W/(m² sr)].
    pub noise: Vec<Vec3>,
    /// Bias of the mean of the passes \[W/(m² sr)]; noisy itself.
    pub bias: Vec<Vec3>,
    /// Mean discs of estimates from the caustic map.
    pub caustic: Vec<Discs>,
    /// Mean discs of estimates from the other map.
    pub global: Vec<Discs>,
}

impl ErrorEstimator {
    /// A gauge for pictures whose radii follow `law`; `None` where there are no estimates.
    #[must_use]
    pub fn new(law: Option<RadiusLaw>) -> Self {
        Self {
            law,
            passes: 0,
            deviations: Vec::new(),
            estimates: None,
            frozen: Frozen::default(),
            spread: Spread::default(),
            scale: None,
        }
    }

    /// Adds a pass; `film` holds those before it.
    pub fn add(&mut self, film: &Film, pass: &Pass) {
        let n = f64::from(self.passes);
        self.deviations.resize(pass.image.len(), DVec3::ZERO);
        for ((sum, value), before) in self.deviations.iter_mut().zip(&pass.image).zip(film.means()) {
            if n > 0.0 {
                let delta = value.as_dvec3() - before;
                *sum += delta * delta * (n / (n + 1.0));
            }
        }
        // What errors are relative to is known better as passes are added; a few times is enough.
        if self.passes.is_power_of_two() {
            self.scale = Some(RelativeScale::of_pixels(film.size(), &film.mean()));
        }
        let weights = self.scale.as_ref().map_or(&[][..], RelativeScale::weights);
        // A pixel of the mean counts for 1 at most.
        self.spread.add(pass.image.iter().copied(), weights, n + 1.0);
        if !pass.nested.is_empty() {
            let estimates = self.estimates.get_or_insert_with(|| Estimates::new(pass.nested.len()));
            estimates.add(&pass.nested);
            estimates.spread.add(pass.nested.iter().map(|g| g.steps[0]), weights, n + 1.0);
        }
        self.frozen.add(pass);
        self.passes += 1;
    }

    /// What is known of each pixel.
    #[must_use]
    pub fn maps(&self, film: &Film) -> ErrorMaps {
        let n = f64::from(self.passes.max(1));
        let over = (n * (n - 1.0)).max(1.0);
        let noise = self.deviations.iter().map(|m2| (*m2 / over).map(f64::sqrt).as_vec3()).collect();
        let Some(estimates) = &self.estimates else { return ErrorMaps { noise, ..ErrorMaps::default() } };
        let factor = (self.read(film).extrapolation / n) as f32;
        let [zero, one] = &estimates.steps;
        let bias = zero.iter().zip(one).map(|(a, b)| (*a + *b) * factor).collect();
        let discs = |map: usize| estimates.discs.iter().map(|d| d[map].mean()).collect();
        ErrorMaps { noise, bias, caustic: discs(0), global: discs(1) }
    }
}

impl Estimates {
    fn new(pixels: usize) -> Self {
        Self {
            steps: [vec![Vec3::ZERO; pixels], vec![Vec3::ZERO; pixels]],
            products: vec![[0.0; 3]; pixels],
            discs: vec![[DiscMean::default(); 2]; pixels],
            spread: Spread::default(),
        }
    }

    fn add(&mut self, nested: &[NestedEstimates]) {
        let [zero, one] = &mut self.steps;
        for (i, pixel) in nested.iter().enumerate() {
            let [a, b] = pixel.steps;
            zero[i] += a;
            one[i] += b;
            let (a, b) = (a.as_dvec3(), b.as_dvec3());
            for (sum, product) in self.products[i].iter_mut().zip([a.dot(a), a.dot(b), b.dot(b)]) {
                *sum += product;
            }
            let [caustic, global] = &mut self.discs[i];
            caustic.add(pixel.caustic);
            global.add(pixel.global);
        }
    }
}

impl DiscMean {
    fn add(&mut self, discs: Option<Discs>) {
        if let Some(Discs { radius, photons }) = discs {
            self.radius += radius;
            self.photons += photons;
            self.passes += 1;
        }
    }

    /// Zero where no estimate was made.
    fn mean(self) -> Discs {
        let n = self.passes.max(1) as f32;
        Discs { radius: self.radius / n, photons: self.photons / n }
    }
}

impl Frozen {
    fn add(&mut self, pass: &Pass) {
        if self.places.is_empty() {
            self.places = pass.fresh.iter().map(|(i, _)| *i).collect();
            self.sums = vec![DVec3::ZERO; self.places.len()];
            self.squares = vec![0.0; self.places.len()];
        }
        for ((sum, square), (at, fresh)) in self.sums.iter_mut().zip(&mut self.squares).zip(&pass.fresh) {
            let difference = pass.image[*at as usize].as_dvec3() - fresh.as_dvec3();
            *sum += difference;
            *square += difference.length_squared();
        }
    }
}

#[cfg(test)]
mod tests;
