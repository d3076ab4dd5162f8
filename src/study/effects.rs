//! Study of effects: renders a scene with all effects, then with each effect left out, to measure
//! the cost and contribution of each.

use crate::image::metrics::{MetricError, rmse};
use crate::image::{Image, PictureSizeError, WriteError};
use crate::integrate::{Algorithm, ExpectedPhotons, Integrator, ProgressMonitor, Settings};
use crate::plan::{EffectDecision, Plan};
use crate::render::Film;
use crate::scene::Scene;
use crate::stats::{Counters, cpu_seconds};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Reason why a study of effects or of methods failed.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A pixel is not finite, or two pictures to be compared differ in size.
    #[error("the pictures cannot be compared: {0}")]
    Metric(#[from] MetricError),
    /// The width or height of the picture is not allowed.
    #[error(transparent)]
    InvalidSize(#[from] PictureSizeError),
    /// A picture of the report cannot be encoded as PNG.
    #[error(transparent)]
    Encode(#[from] WriteError),
}

/// Clock that measures the time of passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ClockKind {
    /// Processor time, summed over all threads of this process.
    Processor,
    /// Wall time, used if the system does not report processor time.
    Wall,
}

impl ClockKind {
    /// Returns [`Self::Processor`] if the system reports processor time, else [`Self::Wall`].
    fn preferred_clock() -> Self {
        if cpu_seconds().is_some() { Self::Processor } else { Self::Wall }
    }

    /// Runs `work`; returns its result and the time that it took on this clock \[s].
    fn measure_seconds<T>(self, work: impl FnOnce() -> T) -> (T, f64) {
        let start = Instant::now();
        let now = || match self {
            Self::Processor => cpu_seconds().unwrap_or(0.0),
            Self::Wall => start.elapsed().as_secs_f64(),
        };
        let before = now();
        let done = work();
        (done, now() - before)
    }
}

/// Time and work of rendering one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureCost {
    /// Time to prepare the integrator, including pilots (small simulations before the first pass)
    /// \[s].
    pub setup_seconds: f64,
    /// Time of each pass, in order \[s].
    pub pass_seconds: Vec<f64>,
    /// Work counters, such as numbers of rays, summed over all passes.
    pub counters: Counters,
}

impl PictureCost {
    /// Returns the time of all passes, without `setup_seconds` \[s].
    #[must_use]
    pub fn total_pass_seconds(&self) -> f64 {
        self.pass_seconds.iter().sum()
    }
}

/// Cost that one effect adds: cost of the picture with all effects of the plan, minus the cost of
/// the picture without this effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AddedCost {
    /// Time that the effect adds to a pass, mean over passes \[s].
    #[serde(rename = "seconds")]
    pub seconds_per_pass: f64,
    /// Standard error of `seconds_per_pass` \[s], from the variance between passes; `None` if only
    /// one pass was made.
    #[serde(rename = "seconds_error")]
    pub seconds_standard_error: Option<f64>,
    /// Pass time with all effects, divided by the pass time without this effect.
    #[serde(rename = "ratio")]
    pub time_ratio: f64,
    /// Time that the effect adds to the preparation of the integrator \[s].
    #[serde(rename = "setup")]
    pub setup_seconds: f64,
    /// Number of rays of all kinds that the effect adds to a pass.
    pub rays: f64,
    /// Number of photon density estimates that the effect adds to a pass.
    pub gathers: f64,
    /// Number of gathered photons, summed over all density estimates, that the effect adds to a
    /// pass.
    pub gathered_photons: f64,
}

/// Light that an effect adds to and removes from the picture, averaged over the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EffectContribution {
    /// Root mean square, over pixels and channels, of the difference between the pictures with and
    /// without the effect \[W/(m² sr)].
    pub rmse: f64,
    /// `rmse` divided by the mean radiance of the picture with all effects; `None` if that mean is
    /// 0.
    pub relative_rmse: Option<f64>,
    /// Increase of radiance by the effect, mean over all pixels and channels \[W/(m² sr)]. A
    /// decrease counts as 0.
    #[serde(rename = "adds")]
    pub added_radiance: f64,
    /// Decrease of radiance by the effect, mean over all pixels and channels, not negative \[W/(m²
    /// sr)]. An increase counts as 0.
    #[serde(rename = "takes")]
    pub removed_radiance: f64,
}

/// Measured cost of one effect, and the change that it makes to the picture.
#[derive(Clone, Debug)]
pub struct EffectResult {
    /// Decision of the plan: the effect, and the reason why it is simulated.
    pub decision: EffectDecision,
    /// Time and work of the picture without the effect.
    pub cost_without_effect: PictureCost,
    /// Time and work that the effect adds.
    pub added_cost: AddedCost,
    /// Light that the effect adds to and removes from the picture.
    pub contribution: EffectContribution,
    /// Picture with all effects minus the picture without this effect \[W/(m² sr)].
    pub difference: Image,
}

/// Measured cost and contribution of each effect of light in a scene.
#[derive(Clone, Debug)]
pub struct EffectStudyResult {
    /// Plan of the full picture: the effects that it simulates, with reasons.
    pub effect_plan: Plan,
    /// Clock that measured all times.
    pub clock: ClockKind,
    /// Mean of the passes with all effects of the plan \[W/(m² sr)].
    pub picture: Image,
    /// Mean of `picture` over pixels and channels \[W/(m² sr)].
    pub mean_radiance: f64,
    /// Time and work of rendering `picture`.
    pub full_picture_cost: PictureCost,
    /// Results, one for each effect that the plan simulates.
    pub effects: Vec<EffectResult>,
    /// True if the study was interrupted before all passes were made.
    pub interrupted: bool,
}

/// Study of effects that is ready to run: one picture with all effects of the plan, and for each
/// effect one picture without it.
///
/// All pictures share the seed and the numbers of rays and photons. Each random decision has its
/// own random number, so leaving out an effect does not change the other decisions. Each picture
/// has its own pilots (small simulations before the first pass). So gather radii may differ between
/// pictures, and so may the directions in which lights emit photons.
pub struct EffectStudy<'a> {
    size: (u32, u32),
    clock: ClockKind,
    /// Pictures of the study: the first one has all effects; each other one leaves out one
    /// simulated effect.
    runs: Vec<PictureInProgress<'a>>,
}

/// State of one picture of a study of effects: integrator, film and cost of the passes so far.
struct PictureInProgress<'a> {
    /// Decision about the effect that is left out; `None` for the picture with all effects.
    omitted_effect: Option<EffectDecision>,
    integrator: Box<dyn Integrator + 'a>,
    film: Film,
    spent: PictureCost,
}

impl<'a> EffectStudy<'a> {
    /// Plans the effects of `scene` and prepares an integrator for each picture.
    #[must_use]
    pub fn prepare(scene: &'a Scene, algorithm: Algorithm, settings: &Settings) -> Self {
        let clock = ClockKind::preferred_clock();
        let plan = Plan::new(scene, algorithm.supported_effects(), settings.camera_paths.effects);
        let settings = settings_with_pilot_counts(scene, algorithm, settings);
        let size = scene.camera().size();
        let run = |without: Option<EffectDecision>| {
            let mut settings = settings.clone();
            if let Some(decision) = without {
                settings.camera_paths.effects = settings.camera_paths.effects.with_forced_off(decision.effect);
            }
            let (integrator, setup) = clock.measure_seconds(|| algorithm.prepare(scene, settings));
            let spent = PictureCost { setup_seconds: setup, ..PictureCost::default() };
            PictureInProgress { omitted_effect: without, integrator, film: Film::new(size.0, size.1), spent }
        };
        let on = plan.decisions.iter().filter(|d| d.is_simulated).copied();
        let runs = std::iter::once(None).chain(on.map(Some)).map(run).collect();
        Self { size, clock, runs }
    }

    /// Returns the plan of the picture with all effects: which effects are simulated, and why.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        self.runs[0].integrator.plan()
    }

    /// Returns the number of pictures: one with all effects, and one without each simulated effect.
    #[must_use]
    pub fn picture_count(&self) -> usize {
        self.runs.len()
    }

    /// Returns the photon counts that are expected for a pass. If a count differs between the
    /// pictures of the study, its largest value is returned.
    #[must_use]
    pub fn max_expected_photon_counts(&self) -> ExpectedPhotons {
        let all = self.runs.iter().map(|run| run.integrator.expected_photons());
        all.fold(ExpectedPhotons::default(), |a, b| ExpectedPhotons {
            paths: a.paths.max(b.paths),
            memory_in_photons: a.memory_in_photons.max(b.memory_in_photons),
            largest_map_in_photons: a.largest_map_in_photons.max(b.largest_map_in_photons),
        })
    }

    /// Renders `passes` passes of each picture, at least one, and returns the measured results.
    ///
    /// The pictures take turns: each makes one pass per round. After each round, calls `after` with
    /// the number of passes that each picture has. Stops early if `interrupted` becomes true.
    ///
    /// # Errors
    /// [`StudyError`] if a pixel is not finite.
    pub fn run(
        mut self,
        passes: u32,
        interrupted: &AtomicBool,
        monitor: &dyn ProgressMonitor,
        mut after: impl FnMut(u32),
    ) -> Result<EffectStudyResult, StudyError> {
        let mut made = 0;
        while made == 0 || (made < passes && !interrupted.load(Ordering::Relaxed)) {
            // Pictures take turns, and each round starts with another picture. So a temporary
            // slowdown of the machine or a cold cache affects all pictures about equally.
            let first = made as usize % self.runs.len();
            let (late, early) = self.runs.split_at_mut(first);
            for run in early.iter_mut().chain(late) {
                let (pass, seconds) = self.clock.measure_seconds(|| run.integrator.render_pass(made, monitor));
                run.film.add(&pass.image);
                run.spent.pass_seconds.push(seconds);
                run.spent.counters += pass.counters;
            }
            made += 1;
            after(made);
        }
        self.into_result(made < passes)
    }

    fn into_result(self, interrupted: bool) -> Result<EffectStudyResult, StudyError> {
        let (width, height) = self.size;
        let effect_plan = self.plan().clone();
        let image = |run: &PictureInProgress<'_>| Image::from_pixels(width, height, run.film.mean_picture());
        let (picture, full_cost) = (image(&self.runs[0])?, self.runs[0].spent.clone());
        let mean = mean_over_image(picture.pixels().iter().map(|p| p.as_dvec3().element_sum()), &picture);
        let mut effects = Vec::new();
        for run in self.runs.into_iter().skip(1) {
            let Some(decision) = run.omitted_effect else { continue };
            let without = image(&run)?;
            let contribution = effect_contribution(&picture, &without, mean)?;
            let pairs = picture.pixels().iter().zip(without.pixels());
            let difference = Image::from_pixels(width, height, pairs.map(|(a, b)| *a - *b).collect())?;
            let added_cost = effect_cost(&full_cost, &run.spent);
            effects.push(EffectResult {
                decision,
                cost_without_effect: run.spent,
                added_cost,
                contribution,
                difference,
            });
        }
        Ok(EffectStudyResult {
            effect_plan,
            clock: self.clock,
            mean_radiance: mean,
            full_picture_cost: full_cost,
            effects,
            interrupted,
            picture,
        })
    }
}

/// Returns `settings` with fixed numbers of rays and photons, so that all pictures of the study use
/// the same numbers.
///
/// A pilot (small simulation before the first pass) chooses the numbers for the picture with all
/// effects. If `settings` forbid this pilot or `algorithm` has none, the numbers of `settings`
/// stay.
fn settings_with_pilot_counts(scene: &Scene, algorithm: Algorithm, settings: &Settings) -> Settings {
    let mut fixed = Settings { allows_ray_photon_balance: false, ..settings.clone() };
    if settings.allows_ray_photon_balance
        && let Some(balance) = algorithm.prepare(scene, settings.clone()).ray_photon_balance()
    {
        fixed.camera_paths.samples_per_pixel = Some(balance.samples_per_pixel);
        fixed.unaimed_paths = balance.unaimed_paths.unwrap_or(fixed.unaimed_paths);
        fixed.aimed_paths = balance.aimed_paths.unwrap_or(fixed.aimed_paths);
    }
    fixed
}

/// Returns the mean of a quantity over the pixels and channels of a picture. `channel_sums` yields
/// the sum of the quantity over the three channels, for each pixel. The picture has the size of
/// `image`.
fn mean_over_image(channel_sums: impl Iterator<Item = f64>, image: &Image) -> f64 {
    channel_sums.sum::<f64>() / (3.0 * image.pixels().len() as f64)
}

fn effect_contribution(full: &Image, without: &Image, mean_of_full: f64) -> Result<EffectContribution, StudyError> {
    let rmse = rmse(full, without)?;
    let differences = || full.pixels().iter().zip(without.pixels()).map(|(a, b)| a.as_dvec3() - b.as_dvec3());
    let adds = mean_over_image(differences().map(|d| d.max(glam::DVec3::ZERO).element_sum()), full);
    let removes = mean_over_image(differences().map(|d| (-d).max(glam::DVec3::ZERO).element_sum()), full);
    let relative_rmse = (mean_of_full > 0.0).then(|| rmse / mean_of_full);
    Ok(EffectContribution { rmse, relative_rmse, added_radiance: adds, removed_radiance: removes })
}

fn effect_cost(full: &PictureCost, without: &PictureCost) -> AddedCost {
    let differences: Vec<f64> = full.pass_seconds.iter().zip(&without.pass_seconds).map(|(a, b)| a - b).collect();
    let n = differences.len() as f64;
    let seconds = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - seconds) * (d - seconds)).sum::<f64>() / (n - 1.0);
    let per_pass = |count: fn(&Counters) -> u64| (count(&full.counters) as f64 - count(&without.counters) as f64) / n;
    AddedCost {
        seconds_per_pass: seconds,
        seconds_standard_error: (differences.len() > 1).then(|| (variance / n).sqrt()),
        time_ratio: full.total_pass_seconds() / without.total_pass_seconds(),
        setup_seconds: full.setup_seconds - without.setup_seconds,
        rays: per_pass(Counters::total_rays),
        gathers: per_pass(|c| c.density_estimates),
        gathered_photons: per_pass(|c| c.gathered_photons),
    }
}
