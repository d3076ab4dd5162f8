//! Emission guiding: a pilot simulation measures which photon paths contribute to the picture. The
//! render then emits more photons from the lights, positions and directions of such paths.

mod distribution;
#[cfg(test)]
mod tests;

pub(super) use distribution::EmissionGuidingDistribution;

use super::deposits::{Deposit, DepositPlace};
use super::trace::PhotonTracingTotals;
use super::{PhotonSearchBuffers, PhotonSource, PhotonTracer, StoreMask, VisiblePointMap};
use crate::color;
use crate::sampling::{DiscreteDistribution, Key, Purpose};
use crate::scene::{Interior, with_interior_type};
use distribution::{EmissionGuidingFit, EmissionGuidingSample};
use rayon::prelude::*;

/// Smallest number of rounds of the pilot, a small photon pass before the render that trains
/// emission guiding. From the second round on, paths are guided by the results of all earlier
/// rounds.
const MIN_ROUNDS: u32 = 2;

/// Largest number of rounds of the pilot, a small photon pass before the render that trains
/// emission guiding.
const MAX_ROUNDS: u32 = 12;

/// Number of contributing photon paths that ends the pilot, the small photon pass that trains
/// emission guiding. A path contributes if one of its photons lies near a surface point that the
/// camera sees. At least [`MIN_ROUNDS`] rounds are made in any case, and no more if none of their
/// paths contributes.
///
/// If light enters through a small window, few paths of the first round contribute. Each later
/// round sends more paths through the window.
const ENOUGH_CONTRIBUTING_PATHS: usize = 2000;

/// Number of photon paths that one Rayon task traces in the pilot, the small photon pass that
/// trains emission guiding.
const PATHS_PER_TASK: u32 = 4096;

/// Weight w of the unguided pdf in the pdf of emission guiding (defensive sampling). The pdf that
/// is fitted to pilot paths has the weight 1 − w.
///
/// The flux of a guided path is at most 1/w = 5 times the flux of the same path without guiding.
const DEFENSIVE_FRACTION: f64 = 0.2;

/// Settings of the pilot of emission guiding: a small photon pass that measures which emitted
/// photons contribute to the picture.
#[derive(Clone, Copy, Debug)]
pub struct EmissionGuidingPilotSettings<'a> {
    /// Kinds of photons that the render stores. Photons of other kinds contribute nothing to the
    /// picture.
    pub mask: StoreMask,
    /// Largest number of scattering events per photon path.
    pub max_bounces: u32,
    /// Surface points that the camera sees. A photon is important if many of these points are near
    /// it.
    pub visible_points: &'a VisiblePointMap,
    /// Number of photon paths in the first two rounds of the pilot together. Further rounds of half
    /// this number follow if few paths contribute to the picture. The default
    /// [`EmissionGuidingPilotSettings::DEFAULT_PATHS`] suffices for most scenes.
    pub paths: u32,
    /// Seed of the render's random numbers.
    pub seed: u64,
}

impl EmissionGuidingPilotSettings<'_> {
    /// Default of [`EmissionGuidingPilotSettings::paths`]: 131,072 photon paths in the first two
    /// rounds of the pilot together.
    ///
    /// If 1 % of them have a photon near a surface point that the camera sees, 1300 paths
    /// contribute to the picture.
    pub const DEFAULT_PATHS: u32 = 1 << 17;
}

/// Cost of the pilot simulation that trains emission guiding, and estimated benefit of the guiding.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct EmissionGuidingReport {
    /// Number of photon paths that the pilot of emission guiding traced.
    pub paths: u64,
    /// Number of rays that the pilot of emission guiding traced.
    pub rays: u64,
    /// Fraction of the photon paths in the pilot's first round that contribute to the picture. This
    /// round is not guided. A path contributes if one of its photons lies near a surface point that
    /// the camera sees.
    #[serde(rename = "useful")]
    pub contributing_fraction: f64,
    /// Estimated ratio of the picture's variance without guiding to that with guiding, for the same
    /// number of photon paths; 1 without guiding.
    ///
    /// The estimate is the ratio of the second moments of path contributions. Both moments are
    /// computed from the guided paths of the last round.
    #[serde(rename = "gain")]
    pub variance_gain: f64,
}

impl PhotonSource<'_> {
    /// Returns the source with its emission guided towards the surface points that the camera sees,
    /// and a report of the pilot that trains the guiding.
    ///
    /// The guided pdf of lights, positions and directions is a mixture of two pdfs. The main one is
    /// proportional to the root mean square of a path's contribution to the picture, which
    /// minimises the variance. The other one is the unguided pdf, which prevents tiny pdfs and huge
    /// fluxes. If no pilot photon lies near a visible point, the source stays unguided. The result
    /// depends only on the scene, this source and `pilot`.
    #[must_use]
    pub fn with_guided_emission(mut self, pilot: &EmissionGuidingPilotSettings<'_>) -> (Self, EmissionGuidingReport) {
        let unguided = self.light_distribution.clone();
        let mut report = EmissionGuidingReport { variance_gain: 1.0, ..EmissionGuidingReport::default() };
        let mut samples: Vec<EmissionGuidingSample> = Vec::new();
        let mut contributing = 0;
        for round in 0..MAX_ROUNDS {
            if round >= MIN_ROUNDS && (contributing == 0 || contributing >= ENOUGH_CONTRIBUTING_PATHS) {
                break;
            }
            let found = self.trace_pilot_round(pilot, round, &unguided);
            report.paths += found.samples.len() as u64;
            report.rays += found.rays;
            let found_count = found.samples.iter().filter(|s| s.squared_contribution > 0.0).count();
            contributing += found_count;
            if round == 0 {
                report.contributing_fraction = found_count as f64 / found.samples.len().max(1) as f64;
            } else if found.second_moment_sum > 0.0 {
                report.variance_gain = found.unguided_second_moment_sum / found.second_moment_sum;
            }
            samples.extend(found.samples);
            self.fit_guiding(&samples, &unguided);
        }
        (self, report)
    }

    /// Traces the photon paths of the pilot's round number `round`, and returns them with their
    /// contributions to the picture.
    ///
    /// `unguided` holds the probabilities of the lights before guiding.
    fn trace_pilot_round(
        &self,
        pilot: &EmissionGuidingPilotSettings<'_>,
        round: u32,
        unguided: &DiscreteDistribution,
    ) -> PilotRoundSamples {
        let key = Key::new(pilot.seed).purpose_key(Purpose::EmissionGuiding).training_round_key(round);
        let paths = pilot.paths / MIN_ROUNDS;
        let chunks: Vec<PilotRoundSamples> = (0..paths.div_ceil(PATHS_PER_TASK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * PATHS_PER_TASK..paths.min((chunk + 1).saturating_mul(PATHS_PER_TASK));
                with_interior_type!(self, <I> self.trace_pilot_chunk::<I>(pilot, key, range, paths, unguided))
            })
            .collect();
        let mut total = PilotRoundSamples::default();
        for chunk in chunks {
            total.samples.extend(chunk.samples);
            total.second_moment_sum += chunk.second_moment_sum;
            total.unguided_second_moment_sum += chunk.unguided_second_moment_sum;
            total.rays += chunk.rays;
        }
        total
    }

    /// Traces the paths with indices `range` of a pilot round of `paths` paths, and returns them
    /// with their contributions to the picture.
    fn trace_pilot_chunk<I: Interior>(
        &self,
        pilot: &EmissionGuidingPilotSettings<'_>,
        key: Key,
        range: std::ops::Range<u32>,
        paths: u32,
        unguided: &DiscreteDistribution,
    ) -> PilotRoundSamples {
        let tracer = PhotonTracer { scene: self.scene, source: self, mask: pilot.mask, max_bounces: pilot.max_bounces };
        let mut scratch = PhotonSearchBuffers::default();
        let mut tally = PhotonTracingTotals::default();
        let mut found = PilotRoundSamples::default();
        for index in range {
            let point = self.sample_primary_emission(key, index, paths);
            let mut squared_contribution = 0.0;
            if let Some((ray, flux)) = self.start_photon_path::<I>(&point) {
                tracer.follow_photon_path(
                    ray,
                    flux,
                    key.photon_path_key(index),
                    None,
                    &mut tally,
                    |deposit: Deposit<'_>| {
                        let DepositPlace::Surface(surface, _) = deposit.place else { return };
                        let flux = f64::from(color::channel_mean(deposit.flux));
                        let importance = pilot.visible_points.squared_photon_importance(
                            surface.point.p,
                            surface.facing_normal(),
                            &mut scratch,
                        );
                        squared_contribution += flux * flux * f64::from(importance);
                    },
                );
            }
            // An infinite contribution cannot be normalised, so it is ignored.
            let squared_contribution = if squared_contribution.is_finite() { squared_contribution } else { 0.0 };
            let weight = 1.0 / f64::from(point.pdf);
            let inverse_pdf = weight / f64::from(point.light_probability);
            found.second_moment_sum += squared_contribution * inverse_pdf * inverse_pdf;
            let unguided_probability = f64::from(unguided.probability(point.light));
            found.unguided_second_moment_sum += squared_contribution * inverse_pdf / unguided_probability;
            let (position, direction) = (point.position_sample, point.direction_sample);
            found.samples.push(EmissionGuidingSample {
                light: point.light,
                position_sample: position,
                direction_sample: direction,
                inverse_primary_pdf: weight,
                squared_contribution,
            });
        }
        found.rays = tally.rays;
        found
    }

    /// Fits the probabilities of the lights, and the guided pdf of each light, to `samples` of the
    /// pilot. Sets both in `self`.
    ///
    /// `unguided` holds the probabilities of the lights before guiding. If no sample contributes to
    /// the picture, `self` stays the same.
    fn fit_guiding(&mut self, samples: &[EmissionGuidingSample], unguided: &DiscreteDistribution) {
        if samples.iter().all(|sample| sample.squared_contribution == 0.0) {
            return;
        }
        let lights = self.scene.lights();
        let mut samples_by_light: Vec<Vec<&EmissionGuidingSample>> = vec![Vec::new(); lights.len()];
        for sample in samples {
            samples_by_light[sample.light].push(sample);
        }
        let fits: Vec<EmissionGuidingFit> = lights
            .par_iter()
            .zip(&samples_by_light)
            .map(|(light, samples)| EmissionGuidingFit::new(light, samples, DEFENSIVE_FRACTION))
            .collect();
        let total: f64 = fits.iter().map(EmissionGuidingFit::guided_root_mean_square).sum();
        if !(total > 0.0 && total.is_finite()) {
            return;
        }
        // `DEFENSIVE_FRACTION` is the weight of the unguided pdf in the joint pdf of light,
        // position and direction. So a light that guiding makes more probable needs a smaller
        // weight of the uniform pdf of position and direction.
        let defensive = |i: usize| DEFENSIVE_FRACTION * f64::from(unguided.probability(i));
        let chosen = |i: usize| defensive(i) + (1.0 - DEFENSIVE_FRACTION) * fits[i].guided_root_mean_square() / total;
        if let Some(choice) = DiscreteDistribution::new((0..lights.len()).map(chosen)) {
            self.light_distribution = choice;
            self.guiding =
                fits.iter().enumerate().map(|(i, fit)| fit.to_distribution(defensive(i) / chosen(i))).collect();
        }
    }
}

/// Photon paths of one round of the pilot that trains emission guiding, with their contributions to
/// the picture.
#[derive(Debug, Default)]
struct PilotRoundSamples {
    samples: Vec<EmissionGuidingSample>,
    /// Sum over the photon paths of one pilot round of (contribution to the picture / pdf of the
    /// path)².
    second_moment_sum: f64,
    /// Estimate of `second_moment_sum` as it would be without guiding. It is computed from the
    /// paths of this round, which are reweighted by importance sampling.
    unguided_second_moment_sum: f64,
    /// Number of rays that the pilot round traced.
    rays: u64,
}
