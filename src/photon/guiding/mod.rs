//! Emission that has learned which photons are seen.

mod distribution;
#[cfg(test)]
mod tests;

pub(super) use distribution::GuidingDistribution;

use super::trace::Deposit;
use super::{Audit, PhotonPass, PhotonSource, Scratch, StoreMask, VisiblePointMap};
use crate::color;
use crate::sampling::{Discrete, Key, Purpose};
use crate::scene::{Interior, InteriorKind, InteriorStack, NoInterior, SpectralInterior};
use distribution::{Fit, Sample};
use rayon::prelude::*;

/// Rounds of a pilot: each goes where those before it found something.
const ROUNDS: u32 = 2;

/// Paths a chunk.
const CHUNK: u32 = 4096;

/// Part of the emission that stays as it was: no path weighs more than one over this of what it weighed.
const SAFE_SHARE: f64 = 0.2;

/// What to learn, and from how much.
#[derive(Clone, Copy, Debug)]
pub struct GuidingPilot<'a> {
    /// Which photons count.
    pub mask: StoreMask,
    /// Bounces after which a path is cut.
    pub max_bounces: u32,
    /// Where they count.
    pub visible: &'a VisiblePointMap,
    /// Paths of the pilot; [`GuidingPilot::PATHS`] is enough for most.
    pub paths: u32,
    /// Seed of the render.
    pub seed: u64,
}

impl GuidingPilot<'_> {
    /// Paths of a pilot that tells a thousand cells apart where one path in a hundred is seen.
    pub const PATHS: u32 = 1 << 17;
}

/// What a pilot found.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct GuidingReport {
    /// Paths traced.
    pub paths: u64,
    /// Rays traced.
    pub rays: u64,
    /// Part of the paths from the unlearned source that lit something visible.
    pub useful: f64,
    /// How many times as many paths the unlearned source would need for the same accuracy of the picture, as the pilot's last
    /// round saw it of what the rounds before had learned; 1 where nothing was learned.
    pub gain: f64,
}

impl PhotonSource<'_> {
    /// This source with its choice of lights, and the choice of where and which way they emit, changed so that paths go where they
    /// matter.
    ///
    /// A pilot measures for each path the sum of the squared changes that its photons make to the picture. The density of
    /// emission becomes proportional to the root of their mean, which gives the least variance (Pharr, Jakob, Humphreys 2023,
    /// section 2.2.2), mixed with the density as it was: every mean stays what it was, and no weight grows beyond bounds. Where
    /// the pilot lights nothing visible the source stays as it was. The result depends on the scene, this source and the
    /// pilot's fields alone.
    #[must_use]
    pub fn guided(mut self, pilot: &GuidingPilot<'_>) -> (Self, GuidingReport) {
        let unlearned = self.choice.clone();
        let mut lesson = GuidingReport { gain: 1.0, ..GuidingReport::default() };
        let mut samples = Vec::new();
        let mut first = 0.0;
        for round in 0..ROUNDS {
            let found = self.explore(pilot, round);
            lesson.paths += found.samples.len() as u64;
            lesson.rays += found.rays;
            if round == 0 {
                let useful = found.samples.iter().filter(|s| s.square > 0.0).count();
                lesson.useful = useful as f64 / found.samples.len().max(1) as f64;
                first = found.second_moment;
            } else if found.second_moment > 0.0 && first > 0.0 {
                lesson.gain = first / found.second_moment;
            }
            samples.extend(found.samples);
            self.learn(&samples, &unlearned);
        }
        (self, lesson)
    }

    /// One round of the pilot.
    fn explore(&self, pilot: &GuidingPilot<'_>, round: u32) -> Found {
        let key = Key::new(pilot.seed).purpose(Purpose::Learning).round(round);
        let paths = pilot.paths / ROUNDS;
        let chunks: Vec<Found> = (0..paths.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..paths.min((chunk + 1).saturating_mul(CHUNK));
                match self.memory() {
                    InteriorKind::Spectral => self.explore_chunk::<SpectralInterior>(pilot, key, range, paths),
                    InteriorKind::Bodies => self.explore_chunk::<InteriorStack>(pilot, key, range, paths),
                    InteriorKind::Nothing => self.explore_chunk::<NoInterior>(pilot, key, range, paths),
                }
            })
            .collect();
        let mut total = Found::default();
        for chunk in chunks {
            total.samples.extend(chunk.samples);
            total.second_moment += chunk.second_moment;
            total.rays += chunk.rays;
        }
        total
    }

    fn explore_chunk<I: Interior>(
        &self,
        pilot: &GuidingPilot<'_>,
        key: Key,
        range: std::ops::Range<u32>,
        paths: u32,
    ) -> Found {
        let pass = PhotonPass { scene: self.scene, source: self, mask: pilot.mask, max_bounces: pilot.max_bounces };
        let mut scratch = Scratch::new();
        let mut audit = Audit::default();
        let mut found = Found::default();
        for index in range {
            let draw = self.draw(key, index, paths);
            let mut square = 0.0;
            if let Some((walk, flux)) = self.start::<I>(&draw) {
                pass.follow(walk, flux, key.path(index), (&mut audit, &mut found.rays), |_, deposit, flux, _| {
                    let Deposit::SurfaceInteraction(surface) = deposit else { return };
                    let flux = f64::from(color::mean(flux));
                    let importance = pilot.visible.importance(surface.point.p, surface.facing_normal(), &mut scratch);
                    square += flux * flux * f64::from(importance);
                });
            }
            // One path of no finite worth must not decide alone.
            let square = if square.is_finite() { square } else { 0.0 };
            let weight = 1.0 / f64::from(draw.density);
            let over = weight / f64::from(draw.probability);
            found.second_moment += square * over * over;
            let (position, direction) = (draw.position, draw.direction);
            found.samples.push(Sample { light: draw.light, position, direction, weight, square });
        }
        found
    }

    /// Sets the densities to what the samples of all rounds say.
    fn learn(&mut self, samples: &[Sample], unlearned: &Discrete) {
        let lights = self.scene.lights();
        let mut of_light: Vec<Vec<&Sample>> = vec![Vec::new(); lights.len()];
        for sample in samples {
            of_light[sample.light].push(sample);
        }
        let fits: Vec<Fit> =
            lights.par_iter().zip(&of_light).map(|(light, samples)| Fit::new(light, samples, SAFE_SHARE)).collect();
        let total: f64 = fits.iter().map(Fit::deviation).sum();
        if !(total > 0.0 && total.is_finite()) {
            return;
        }
        // The mixture is of whole sources: a light that is chosen more often needs less of its own share to be safe.
        let safe = |i: usize| SAFE_SHARE * f64::from(unlearned.probability(i));
        let chosen = |i: usize| safe(i) + (1.0 - SAFE_SHARE) * fits[i].deviation() / total;
        if let Some(choice) = Discrete::new((0..lights.len()).map(chosen)) {
            self.choice = choice;
            self.densities = fits.iter().enumerate().map(|(i, fit)| fit.density(safe(i) / chosen(i))).collect();
        }
    }
}

/// What a round of the pilot found.
#[derive(Debug, Default)]
struct Found {
    samples: Vec<Sample>,
    /// Sum over the paths of the squares of what they would add to an estimate.
    second_moment: f64,
    rays: u64,
}
