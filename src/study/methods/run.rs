//! Running methods side by side.

use super::clock::{Clock, system, timed};
use super::split::{by_pixel, mean, split};
use super::variant::{VariantError, check};
use super::{Checkpoint, MethodFound, MethodsFound, Moment, References, Subject, Variant};
use crate::color::Rgb;
use crate::image::Image;
use crate::image::flip::{FlipOptions, flip};
use crate::image::metrics::rmse;
use crate::integrate::{Expected, Integrator, Monitor, Radii};
use crate::render::Film;
use crate::render::error_estimate::ErrorEstimator;
use crate::scene::Scene;
use crate::stats::cpu_seconds;
use crate::study::StudyError;
use std::sync::atomic::{AtomicBool, Ordering};

/// How much more than the checkpoint before the last one must have, so that both are kept.
const WORTH: f64 = 1.3;

/// Bytes a pixel of a film and of the gauge of its error.
const FILM: u64 = 24 + 192;

/// Bytes a pixel of a picture.
const PICTURE: u64 = 12;

/// When the runs of a study end; at least one pass of each is made.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// After the round in which the mean processor time of a seed reaches this \[s].
    pub budget: f64,
    /// After so many passes.
    pub passes: Option<u32>,
}

/// What a study tells of while it runs.
#[derive(Clone, Copy, Debug)]
pub enum Step<'s> {
    /// So many rounds are made: a pass of each seed of each method that still runs.
    Round(u32),
    /// The method of this label was looked at.
    Checkpoint(&'s str, &'s Checkpoint),
}

/// Makes the integrator of a seed.
pub(super) type Maker<'a> = Box<dyn Fn(u64) -> Box<dyn Integrator + 'a> + 'a>;

/// Methods ready to be run side by side.
///
/// The integrators of all seeds are kept while their method runs, with what their pilots learned; those of the first seed are prepared
/// at once, the others in the first round.
pub struct MethodStudy<'a> {
    size: (u32, u32),
    seeds: u32,
    clock: Clock<'a>,
    runs: Vec<Run<'a>>,
}

/// A variant under way.
struct Run<'a> {
    variant: Variant,
    make: Maker<'a>,
    setup: f64,
    radii: Option<Radii>,
    expected: Expected,
    alpha: f64,
    seeds: Vec<Seed<'a>>,
    time: Moment,
    rays: u64,
    photons: u64,
    checkpoints: Vec<Checkpoint>,
    /// The last pictures, once it has ended.
    last: Option<Last>,
}

struct Seed<'a> {
    integrator: Option<Box<dyn Integrator + 'a>>,
    film: Film,
    /// Made with the first pass.
    gauge: Option<ErrorEstimator>,
}

struct Last {
    passes: u32,
    picture: Image,
    error: Vec<f32>,
    difference: Image,
}

impl<'a> MethodStudy<'a> {
    /// Prepares variants that are each rendered with `seeds` seeds, from that of its settings upwards.
    ///
    /// # Errors
    /// [`VariantError`] where there is no variant, two have one label, or there are fewer than two seeds.
    pub fn prepare(scene: &'a Scene, variants: Vec<Variant>, seeds: u32) -> Result<Self, VariantError> {
        let made_by = |variant: Variant| {
            let (algorithm, settings) = (variant.algorithm, variant.settings.clone());
            let make = move |seed| {
                let mut settings = settings.clone();
                settings.eye.seed = seed;
                settings.eye.estimate_error = true;
                algorithm.prepare(scene, settings)
            };
            (variant, Box::new(make) as Maker<'a>)
        };
        Self::new(scene.camera().size(), variants.into_iter().map(made_by).collect(), seeds, system())
    }

    pub(super) fn new(
        size: (u32, u32),
        variants: Vec<(Variant, Maker<'a>)>,
        seeds: u32,
        clock: Clock<'a>,
    ) -> Result<Self, VariantError> {
        let (named, makers): (Vec<_>, Vec<_>) = variants.into_iter().unzip();
        check(&named, seeds)?;
        let runs = named.into_iter().zip(makers).map(|(variant, make)| {
            let (first, setup) = timed(&clock, || make(variant.settings.eye.seed));
            let (radii, expected) = (first.radii(), first.expected());
            let alpha = first.radius_law().map_or(1.0, |law| law.alpha);
            let none = (1..seeds).map(|_| None);
            let film = |integrator| Seed { integrator, film: Film::new(size.0, size.1), gauge: None };
            Run {
                variant,
                make,
                setup: setup.processor,
                radii,
                expected,
                alpha,
                seeds: std::iter::once(Some(first)).chain(none).map(film).collect(),
                time: Moment::default(),
                rays: 0,
                photons: 0,
                checkpoints: Vec::new(),
                last: None,
            }
        });
        let runs = runs.collect();
        Ok(Self { size, seeds, clock, runs })
    }

    /// What the largest pass will keep in memory.
    #[must_use]
    pub fn expected(&self) -> Expected {
        self.runs.iter().map(|run| run.expected).fold(Expected::default(), |a, b| Expected {
            paths: a.paths.max(b.paths),
            photons: a.photons.max(b.photons),
            most: a.most.max(b.most),
        })
    }

    /// Bytes that the pictures of so many variants and seeds take.
    #[must_use]
    pub fn bytes((width, height): (u32, u32), variants: usize, seeds: u32) -> u64 {
        let (variants, seeds) = (variants as u64, u64::from(seeds));
        // Films, the picture, error and difference of each variant; the references with their mean and scale; the means of one variant.
        let pixel = variants * (FILM * seeds + 2 * PICTURE + 4) + 3 * PICTURE + 8 + PICTURE * (seeds + 2);
        u64::from(width) * u64::from(height) * pixel
    }

    /// Runs all variants, pass by pass in turns, until each has come to an end by `limits`, or after the round in which `interrupted`
    /// becomes true.
    ///
    /// # Errors
    /// [`StudyError`] where a pixel is not finite, or the references are of another size.
    pub fn run(
        mut self,
        subject: &Subject,
        limits: Limits,
        references: &References,
        interrupted: &AtomicBool,
        monitor: &dyn Monitor,
        mut after: impl FnMut(Step<'_>),
    ) -> Result<MethodsFound, StudyError> {
        let (mut round, mut cut) = (0u32, false);
        while self.runs.iter().any(|run| run.last.is_none()) {
            self.round(round, monitor);
            round += 1;
            after(Step::Round(round));
            let asked = interrupted.load(Ordering::Relaxed);
            for run in self.runs.iter_mut().filter(|run| run.last.is_none()) {
                let spent = run.time.processor / f64::from(self.seeds) >= limits.budget;
                let done = spent || limits.passes.is_some_and(|most| round >= most) || round == u32::MAX;
                cut |= asked && !done;
                if done || asked || round.is_power_of_two() {
                    let checkpoint = run.look(round, done || asked, self.size, references)?;
                    after(Step::Checkpoint(&run.variant.label, &checkpoint));
                }
            }
        }
        Ok(self.conclude(subject, limits, references, cut))
    }

    /// A pass of each seed of each variant that still runs, beginning elsewhere each time: a machine that slows down, or a cache that is
    /// cold, is unfair to none.
    fn round(&mut self, pass: u32, monitor: &dyn Monitor) {
        let seeds = self.seeds as usize;
        let running = (0..self.runs.len()).filter(|i| self.runs[*i].last.is_none());
        let turns: Vec<(usize, usize)> = running.flat_map(|run| (0..seeds).map(move |seed| (run, seed))).collect();
        let (late, early) = turns.split_at(pass as usize % turns.len());
        for (run, seed) in early.iter().chain(late) {
            self.runs[*run].pass(*seed, pass, &self.clock, monitor);
        }
    }

    fn conclude(self, subject: &Subject, limits: Limits, references: &References, interrupted: bool) -> MethodsFound {
        let threads = rayon::current_num_threads();
        let share = |run: &Run<'_>| run.time.processor / (run.time.wall * threads as f64);
        // Wall time in place of processor time tells nothing.
        let told = |share: &f64| share.is_finite() && cpu_seconds().is_some();
        let shares = self.runs.iter().map(share).filter(told);
        MethodsFound {
            scene: subject.scene.clone(),
            command: subject.command.clone(),
            program: format!("caustica {}", env!("CARGO_PKG_VERSION")),
            machine: super::clock::machine(threads),
            seeds: self.seeds,
            budget: limits.budget,
            share: shares.fold(1.0, f64::min),
            truth: references.truth(),
            methods: self.runs.into_iter().filter_map(|run| run.found(subject)).collect(),
            interrupted,
        }
    }
}

impl Run<'_> {
    fn pass(&mut self, seed: usize, pass: u32, clock: &dyn Fn() -> Moment, monitor: &dyn Monitor) {
        let Seed { integrator, film, gauge } = &mut self.seeds[seed];
        let first = self.variant.settings.eye.seed;
        let integrator = integrator.get_or_insert_with(|| (self.make)(first.wrapping_add(seed as u64)));
        let (pass, time) = timed(clock, || integrator.pass(pass, monitor));
        gauge.get_or_insert_with(|| ErrorEstimator::new(integrator.radius_law())).add(film, &pass);
        film.add(&pass.image);
        self.time += time;
        self.rays += pass.counters.rays();
        self.photons += pass.global.emitted + pass.caustic.emitted;
    }

    /// Takes the measure of all seeds after so many passes. A last checkpoint takes the place of one that is not much before it.
    fn look(
        &mut self,
        passes: u32,
        last: bool,
        size: (u32, u32),
        references: &References,
    ) -> Result<Checkpoint, StudyError> {
        let pictures: Vec<Vec<Rgb>> = self.seeds.iter().map(|seed| seed.film.mean()).collect();
        let image = |pixels: Vec<Rgb>| Image::from_pixels(size.0, size.1, pixels);
        for picture in &pictures {
            // Fails where a pixel is beyond measure.
            rmse(&image(picture.clone())?, references.mean())?;
        }
        let measured = split(references, &pictures);
        let told = |seed: &Seed<'_>| Some(seed.gauge.as_ref()?.estimate(&seed.film).error);
        let gauged: Vec<f64> = self.seeds.iter().filter_map(told).filter(|e| e.is_finite()).map(|e| e * e).collect();
        let seeds = pictures.len() as f64;
        let checkpoint = Checkpoint {
            passes,
            seconds: self.time.processor / seeds,
            wall: self.time.wall / seeds,
            rays: self.rays as f64 / seeds,
            photons: self.photons as f64 / seeds,
            squares: measured.squares,
            noises: measured.noises,
            noise2: measured.noise2,
            bias2: measured.bias2,
            gauged,
            rmse: measured.rmse,
            flip: flip(references.mean(), &image(pictures[0].clone())?, &FlipOptions::default())?.mean,
        };
        if last {
            self.checkpoints.pop_if(|before| f64::from(passes) < WORTH * f64::from(before.passes));
            let truth = references.mean().pixels();
            let differences = truth.iter().enumerate().map(|(i, t)| (mean(&pictures, i) - t.as_dvec3()).as_vec3());
            let difference = image(differences.collect())?;
            let error = by_pixel(references, &pictures);
            let picture = image(pictures.into_iter().next().unwrap_or_default())?;
            self.last = Some(Last { passes, picture, error, difference });
            self.seeds.clear();
        }
        self.checkpoints.push(checkpoint.clone());
        Ok(checkpoint)
    }

    fn found(self, subject: &Subject) -> Option<MethodFound> {
        let Last { passes, picture, error, difference } = self.last?;
        Some(MethodFound {
            command: subject.render(&self.variant, passes),
            label: self.variant.label,
            algorithm: self.variant.algorithm,
            setup: self.setup,
            alpha: self.alpha,
            radii: self.radii.map(|r| [r.global, r.caustic]),
            checkpoints: self.checkpoints,
            picture,
            error,
            difference,
        })
    }
}
