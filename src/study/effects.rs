//! What each effect costs and what it adds: the same picture with and without it.

use super::settled;
use crate::image::metrics::{MetricError, rmse};
use crate::image::{Image, SizeError, WriteError};
use crate::integrate::{Algorithm, Expected, Integrator, Monitor, Settings};
use crate::plan::{Decision, Plan};
use crate::render::Film;
use crate::scene::Scene;
use crate::stats::{Counters, cpu_seconds};
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Why a study has no result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A pixel is beyond measure.
    #[error("the pictures cannot be compared: {0}")]
    Metric(#[from] MetricError),
    /// The picture's size cannot be used.
    #[error(transparent)]
    Size(#[from] SizeError),
    /// A picture cannot be encoded.
    #[error(transparent)]
    Encode(#[from] WriteError),
}

/// What seconds are counted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Time of all threads of this process: other processes do not count.
    Processor,
    /// Time on the wall, where the system does not tell the other.
    Wall,
}

impl Clock {
    /// The better one that this system has.
    fn best() -> Self {
        if cpu_seconds().is_some() { Self::Processor } else { Self::Wall }
    }

    /// What `work` gives, and its seconds.
    fn time<T>(self, work: impl FnOnce() -> T) -> (T, f64) {
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

/// What making a picture took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spent {
    /// Preparation, pilots included \[s].
    pub setup: f64,
    /// Each pass \[s].
    pub passes: Vec<f64>,
    /// Work of all passes.
    pub counters: Counters,
}

impl Spent {
    /// All passes, without preparation \[s].
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.passes.iter().sum()
    }
}

/// What an effect costs: with it less without it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// A pass \[s].
    pub seconds: f64,
    /// Standard error of `seconds`, from the differences of the passes \[s]; `None` with one pass.
    pub seconds_error: Option<f64>,
    /// Seconds of all passes with it, in those without it.
    pub ratio: f64,
    /// Preparation \[s].
    pub setup: f64,
    /// Rays of every kind a pass.
    pub rays: f64,
    /// Density estimates a pass.
    pub gathers: f64,
    /// Photons in them a pass.
    pub gathered_photons: f64,
}

/// What an effect does to the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// Root of the mean squared difference over pixels and channels \[W/(m² sr)].
    pub rmse: f64,
    /// The same in the mean radiance of the whole picture; `None` where that is black.
    pub relative_rmse: Option<f64>,
    /// Mean over pixels and channels of the radiance that it adds, where it adds \[W/(m² sr)].
    pub adds: f64,
    /// Mean over pixels and channels of the radiance that it takes away, where it takes \[W/(m² sr)].
    pub takes: f64,
}

/// A picture with an effect, held against one without.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The effect, and why it is simulated.
    pub decision: Decision,
    /// What the picture without it took.
    pub without: Spent,
    /// What it costs.
    pub cost: Cost,
    /// What it is worth.
    pub gain: Gain,
    /// The whole picture less the one without it.
    pub difference: Image,
}

/// The result of a study.
#[derive(Clone, Debug)]
pub struct Findings {
    /// What of light the whole picture simulates.
    pub plan: Plan,
    /// What seconds are counted by.
    pub clock: Clock,
    /// The whole picture.
    pub picture: Image,
    /// Its mean over pixels and channels \[W/(m² sr)].
    pub mean: f64,
    /// What it took.
    pub whole: Spent,
    /// One for each effect that is simulated.
    pub effects: Vec<Finding>,
    /// Whether it ended before all passes were made.
    pub interrupted: bool,
}

/// The pictures of a study, ready to be rendered: the whole one, and one without each effect that is simulated.
///
/// They share the seed. As random numbers are keyed by what they decide, a picture without an effect differs by that effect alone,
/// but for what pilots learn: photons are aimed, and radii found, anew for each. How many rays and photons a pass has, where a pilot
/// says, is said once, of the whole picture.
pub struct EffectStudy<'a> {
    size: (u32, u32),
    clock: Clock,
    /// The whole picture comes first.
    runs: Vec<Run<'a>>,
}

struct Run<'a> {
    /// The effect that is left out; `None` for the whole picture.
    without: Option<Decision>,
    integrator: Box<dyn Integrator + 'a>,
    film: Film,
    spent: Spent,
}

impl<'a> EffectStudy<'a> {
    /// Plans a scene and prepares all pictures.
    #[must_use]
    pub fn prepare(scene: &'a Scene, algorithm: Algorithm, settings: &Settings) -> Self {
        let clock = Clock::best();
        let plan = Plan::new(scene, algorithm.simulates(), settings.eye.effects);
        let settings = settled(scene, algorithm, settings);
        let size = scene.camera().size();
        let run = |without: Option<Decision>| {
            let mut settings = settings.clone();
            if let Some(decision) = without {
                settings.eye.effects = settings.eye.effects.without(decision.effect);
            }
            let (integrator, setup) = clock.time(|| algorithm.prepare(scene, settings));
            let spent = Spent { setup, ..Spent::default() };
            Run { without, integrator, film: Film::new(size.0, size.1), spent }
        };
        let on = plan.decisions.iter().filter(|d| d.on).copied();
        let runs = std::iter::once(None).chain(on.map(Some)).map(run).collect();
        Self { size, clock, runs }
    }

    /// What of light the whole picture simulates.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        self.runs[0].integrator.plan()
    }

    /// Pictures that are made.
    #[must_use]
    pub fn pictures(&self) -> usize {
        self.runs.len()
    }

    /// What the largest pass will keep in memory.
    #[must_use]
    pub fn expected(&self) -> Expected {
        let all = self.runs.iter().map(|run| run.integrator.expected());
        all.fold(Expected::default(), |a, b| Expected {
            paths: a.paths.max(b.paths),
            photons: a.photons.max(b.photons),
            most: a.most.max(b.most),
        })
    }

    /// Renders `passes` passes of each picture, at least one, or fewer where `interrupted` becomes true. `after` hears the number
    /// of passes made of each.
    ///
    /// # Errors
    /// [`StudyError`] where a pixel is not finite.
    pub fn run(
        mut self,
        passes: u32,
        interrupted: &AtomicBool,
        monitor: &dyn Monitor,
        mut after: impl FnMut(u32),
    ) -> Result<Findings, StudyError> {
        let mut made = 0;
        while made == 0 || (made < passes && !interrupted.load(Ordering::Relaxed)) {
            // Turn by turn, beginning elsewhere each time: a machine that slows down, or a cache that is cold, is unfair to none.
            let first = made as usize % self.runs.len();
            let (late, early) = self.runs.split_at_mut(first);
            for run in early.iter_mut().chain(late) {
                let (pass, seconds) = self.clock.time(|| run.integrator.pass(made, monitor));
                run.film.add(&pass.image);
                run.spent.passes.push(seconds);
                run.spent.counters += pass.counters;
            }
            made += 1;
            after(made);
        }
        self.conclude(made < passes)
    }

    fn conclude(self, interrupted: bool) -> Result<Findings, StudyError> {
        let (width, height) = self.size;
        let plan = self.plan().clone();
        let image = |run: &Run<'_>| Image::from_pixels(width, height, run.film.mean());
        let (picture, whole) = (image(&self.runs[0])?, self.runs[0].spent.clone());
        let mean = mean(picture.pixels().iter().map(|p| p.as_dvec3().element_sum()), &picture);
        let find = |run: Run<'_>| {
            let without = image(&run)?;
            let Run { without: left_out, spent, .. } = run;
            let gain = gain(&picture, &without, mean)?;
            let pairs = picture.pixels().iter().zip(without.pixels());
            let difference = Image::from_pixels(width, height, pairs.map(|(a, b)| *a - *b).collect())?;
            let found = |decision| Finding { decision, cost: cost(&whole, &spent), without: spent, gain, difference };
            Ok(left_out.map(found))
        };
        let effects = self.runs.into_iter().skip(1).filter_map(|run| find(run).transpose());
        let effects = effects.collect::<Result<_, StudyError>>()?;
        Ok(Findings { plan, clock: self.clock, mean, whole, effects, interrupted, picture })
    }
}

/// Mean over pixels and channels of what is summed over channels.
fn mean(sums: impl Iterator<Item = f64>, of: &Image) -> f64 {
    sums.sum::<f64>() / (3.0 * of.pixels().len() as f64)
}

fn gain(whole: &Image, without: &Image, mean_of_whole: f64) -> Result<Gain, StudyError> {
    let rmse = rmse(whole, without)?;
    let differences = || whole.pixels().iter().zip(without.pixels()).map(|(a, b)| a.as_dvec3() - b.as_dvec3());
    let adds = mean(differences().map(|d| d.max(glam::DVec3::ZERO).element_sum()), whole);
    let takes = mean(differences().map(|d| (-d).max(glam::DVec3::ZERO).element_sum()), whole);
    let relative_rmse = (mean_of_whole > 0.0).then(|| rmse / mean_of_whole);
    Ok(Gain { rmse, relative_rmse, adds, takes })
}

fn cost(whole: &Spent, without: &Spent) -> Cost {
    let differences: Vec<f64> = whole.passes.iter().zip(&without.passes).map(|(a, b)| a - b).collect();
    let n = differences.len() as f64;
    let seconds = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - seconds) * (d - seconds)).sum::<f64>() / (n - 1.0);
    let a_pass = |count: fn(&Counters) -> u64| (count(&whole.counters) as f64 - count(&without.counters) as f64) / n;
    Cost {
        seconds,
        seconds_error: (differences.len() > 1).then(|| (variance / n).sqrt()),
        ratio: whole.seconds() / without.seconds(),
        setup: whole.setup - without.setup,
        rays: a_pass(Counters::rays),
        gathers: a_pass(|c| c.gathers),
        gathered_photons: a_pass(|c| c.gathered_photons),
    }
}
