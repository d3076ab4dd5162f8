//! Emission guiding: a pilot finds which emitted photons change the picture.

mod distribution;
#[cfg(test)]
mod tests;

pub(super) use distribution::GuidingDistribution;

use super::deposits::{Deposit, DepositPlace};
use super::trace::PathTally;
use super::{PhotonPass, PhotonSource, Scratch, StoreMask, VisiblePointMap};
use crate::color;
use crate::sampling::{DiscreteDistribution, Key, Purpose};
use crate::scene::{Interior, InteriorKind, InteriorStack, NoInterior, SpectralInterior};
use distribution::{GuidingFit, GuidingSample};
use rayon::prelude::*;

/// Rounds of a pilot. Each round samples by the distribution of the rounds before.
const ROUNDS: u32 = 2;

/// Paths per parallel chunk.
const CHUNK: u32 = 4096;

/// Fraction of the emission that stays unguided (defensive sampling). It bounds path weights by its
/// inverse.
const DEFENSIVE_FRACTION: f64 = 0.2;

/// Settings of the pilot for emission guiding.
#[derive(Clone, Copy, Debug)]
pub struct GuidingPilot<'a> {
    /// Photons that count.
    pub mask: StoreMask,
    /// Number of bounces after which a path ends.
    pub max_bounces: u32,
    /// Visible points, where photons count.
    pub visible: &'a VisiblePointMap,
    /// Number of paths; [`GuidingPilot::PATHS`] suffices for most scenes.
    pub paths: u32,
    /// Seed of the render.
    pub seed: u64,
}

impl GuidingPilot<'_> {
    /// Default number of paths: enough to resolve 1000 cells if 1 % of the paths are visible.
    pub const PATHS: u32 = 1 << 17;
}

/// Result of a pilot for emission guiding.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct GuidingReport {
    /// Number of traced paths.
    pub paths: u64,
    /// Number of traced rays.
    pub rays: u64,
    /// Fraction of unguided paths that light a visible point.
    pub useful: f64,
    /// Factor by which guiding reduces the paths needed for equal variance of the picture; 1
    /// without guiding.
    ///
    /// The last round of the pilot measures the distribution of the rounds before.
    pub gain: f64,
}

impl PhotonSource<'_> {
    /// The source with guided emission: lights, positions and directions are sampled by their
    /// effect on the picture.
    ///
    /// For each path, a pilot measures the sum of the squared changes of the picture by its
    /// photons. The guided pdf is proportional to the root of the mean square, which minimises the
    /// variance (Pharr, Jakob, Humphreys 2023, section 2.2.2). It is mixed with the unguided pdf,
    /// so every mean is unbiased and weights are bounded. If the pilot lights no visible point, the
    /// source stays unguided. The result depends only on the scene, this source and `pilot`.
    #[must_use]
    pub fn with_guided_emission(mut self, pilot: &GuidingPilot<'_>) -> (Self, GuidingReport) {
        let unguided = self.choice.clone();
        let mut report = GuidingReport { gain: 1.0, ..GuidingReport::default() };
        let mut samples = Vec::new();
        let mut first = 0.0;
        for round in 0..ROUNDS {
            let found = self.trace_round(pilot, round);
            report.paths += found.samples.len() as u64;
            report.rays += found.rays;
            if round == 0 {
                let useful = found.samples.iter().filter(|s| s.square > 0.0).count();
                report.useful = useful as f64 / found.samples.len().max(1) as f64;
                first = found.second_moment;
            } else if found.second_moment > 0.0 && first > 0.0 {
                report.gain = first / found.second_moment;
            }
            samples.extend(found.samples);
            self.fit_guiding(&samples, &unguided);
        }
        (self, report)
    }

    /// Traces one round of the pilot.
    fn trace_round(&self, pilot: &GuidingPilot<'_>, round: u32) -> RoundSamples {
        let key = Key::new(pilot.seed).purpose_key(Purpose::GuidingTraining).training_round_key(round);
        let paths = pilot.paths / ROUNDS;
        let chunks: Vec<RoundSamples> = (0..paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..paths.min((chunk + 1).saturating_mul(CHUNK));
                match self.interior_kind() {
                    InteriorKind::Spectral => self.trace_chunk::<SpectralInterior>(pilot, key, range, paths),
                    InteriorKind::Bodies => self.trace_chunk::<InteriorStack>(pilot, key, range, paths),
                    InteriorKind::Nothing => self.trace_chunk::<NoInterior>(pilot, key, range, paths),
                }
            })
            .collect();
        let mut total = RoundSamples::default();
        for chunk in chunks {
            total.samples.extend(chunk.samples);
            total.second_moment += chunk.second_moment;
            total.rays += chunk.rays;
        }
        total
    }

    fn trace_chunk<I: Interior>(
        &self,
        pilot: &GuidingPilot<'_>,
        key: Key,
        range: std::ops::Range<u32>,
        paths: u32,
    ) -> RoundSamples {
        let pass = PhotonPass { scene: self.scene, source: self, mask: pilot.mask, max_bounces: pilot.max_bounces };
        let mut scratch = Scratch::new();
        let mut tally = PathTally::default();
        let mut found = RoundSamples::default();
        for index in range {
            let point = self.primary_emission_sample(key, index, paths);
            let mut square = 0.0;
            if let Some((ray, flux)) = self.start_path::<I>(&point) {
                pass.follow_photon_path(ray, flux, key.path_key(index), &mut tally, |deposit: Deposit<'_>| {
                    let DepositPlace::Surface(surface) = deposit.place else { return };
                    let flux = f64::from(color::channel_mean(deposit.flux));
                    let importance = pilot.visible.importance(surface.point.p, surface.facing_normal(), &mut scratch);
                    square += flux * flux * f64::from(importance);
                });
            }
            // One path with an infinite change must not dominate the distribution.
            let square = if square.is_finite() { square } else { 0.0 };
            let weight = 1.0 / f64::from(point.pdf);
            let contribution = weight / f64::from(point.probability);
            found.second_moment += square * contribution * contribution;
            let (position, direction) = (point.position, point.direction);
            found.samples.push(GuidingSample { light: point.light, position, direction, weight, square });
        }
        found.rays = tally.rays;
        found
    }

    /// Fits the guiding distributions to the samples of all rounds.
    fn fit_guiding(&mut self, samples: &[GuidingSample], unguided: &DiscreteDistribution) {
        let lights = self.scene.lights();
        let mut of_light: Vec<Vec<&GuidingSample>> = vec![Vec::new(); lights.len()];
        for sample in samples {
            of_light[sample.light].push(sample);
        }
        let fits: Vec<GuidingFit> = lights
            .par_iter()
            .zip(&of_light)
            .map(|(light, samples)| GuidingFit::new(light, samples, DEFENSIVE_FRACTION))
            .collect();
        let total: f64 = fits.iter().map(GuidingFit::guided_deviation).sum();
        if !(total > 0.0 && total.is_finite()) {
            return;
        }
        // The mixture is over all lights: a light with a higher guided probability needs a smaller
        // fraction of its own.
        let defensive = |i: usize| DEFENSIVE_FRACTION * f64::from(unguided.probability(i));
        let chosen = |i: usize| defensive(i) + (1.0 - DEFENSIVE_FRACTION) * fits[i].guided_deviation() / total;
        if let Some(choice) = DiscreteDistribution::new((0..lights.len()).map(chosen)) {
            self.choice = choice;
            self.guiding =
                fits.iter().enumerate().map(|(i, fit)| fit.to_distribution(defensive(i) / chosen(i))).collect();
        }
    }
}

/// Samples of one round of the pilot.
#[derive(Debug, Default)]
struct RoundSamples {
    samples: Vec<GuidingSample>,
    /// Sum over the paths of their squared contributions.
    second_moment: f64,
    rays: u64,
}
