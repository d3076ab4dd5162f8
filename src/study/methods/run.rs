//! Runs the methods of a study by turns, one pass at a time, and measures checkpoints.

use super::clock::{ClockFn, measure_time, system_clock};
use super::noise_and_bias::{mean_pixel_over_pictures, relative_pixel_errors, separate_noise_and_bias};
use super::variant::{MethodVariantError, check_method_variants};
use super::{
    ConvergenceCheckpoint, CpuWallTime, MethodResult, MethodStudyResult, MethodVariant, ReferencePictures, StudiedScene,
};
use crate::color::Rgb;
use crate::image::Image;
use crate::image::flip::{FlipMetricOptions, flip_metric};
use crate::image::metrics::rmse;
use crate::integrate::{ExpectedPhotons, GatherRadii, Integrator, ProgressMonitor};
use crate::render::Film;
use crate::render::error_estimate::ErrorEstimator;
use crate::scene::Scene;
use crate::stats::cpu_seconds;
use crate::study::StudyError;
use std::sync::atomic::{AtomicBool, Ordering};

/// Smallest ratio between the passes of the last two checkpoints of a method. If the ratio is
/// smaller, the earlier one of the two is dropped.
const MIN_CHECKPOINT_PASS_RATIO: f64 = 1.3;

/// Memory of a film (50 bytes per pixel) and of its error estimator (284 bytes per pixel).
const BYTES_PER_FILM_PIXEL: u64 = 50 + 284;

/// Memory of a picture in single precision \[bytes per pixel].
const BYTES_PER_PICTURE_PIXEL: u64 = 12;

/// Limits at which the methods of a study stop. Each method makes at least one pass.
#[derive(Clone, Copy, Debug)]
pub struct StudyLimits {
    /// Largest processor time per seed \[s]. A method stops after the pass in which its processor
    /// time, averaged over seeds, reaches this limit.
    pub cpu_seconds_per_seed: f64,
    /// Largest number of passes that a method makes; `None` without a limit.
    pub passes: Option<u32>,
}

/// Progress event of a study that compares rendering methods.
#[derive(Clone, Copy, Debug)]
pub enum MethodStudyEvent<'s> {
    /// Each method that is still running has made one more pass with each seed. Holds the number of
    /// passes that each of these seeds has made so far.
    PassFinished(u32),
    /// A method has reached a checkpoint. Holds the method's label and the measured checkpoint.
    Checkpoint(&'s str, &'s ConvergenceCheckpoint),
}

/// Function that prepares the integrator of a method for the given seed.
pub(super) type IntegratorFactory<'a> = Box<dyn Fn(u64) -> Box<dyn Integrator + 'a> + 'a>;

/// Study that is ready to measure the convergence of rendering methods.
///
/// The integrator of each method's first seed is prepared in advance. The integrators of the other
/// seeds are prepared before their first pass. All integrators of a method stay in memory until the
/// method ends.
pub struct MethodStudy<'a> {
    size: (u32, u32),
    seeds: u32,
    clock: ClockFn<'a>,
    runs: Vec<MethodRun<'a>>,
}

/// State of one rendering method while a study runs: its seeds, times and checkpoints.
struct MethodRun<'a> {
    variant: MethodVariant,
    make_integrator: IntegratorFactory<'a>,
    setup_seconds: f64,
    gather_radii: Option<GatherRadii>,
    expected_photons: ExpectedPhotons,
    alpha: f64,
    seeds: Vec<SeedRun<'a>>,
    total_pass_time: CpuWallTime,
    rays: u64,
    photon_paths: u64,
    checkpoints: Vec<ConvergenceCheckpoint>,
    /// Pictures of the last checkpoint; `None` while the method runs.
    final_pictures: Option<FinalPictures>,
}

/// State of one seed of a rendering method: integrator, film and error estimator.
struct SeedRun<'a> {
    /// Integrator of this seed, prepared in advance for the first seed of a method. For the other
    /// seeds, the value is `None` until their first pass.
    integrator: Option<Box<dyn Integrator + 'a>>,
    film: Film,
    /// Error estimator of this seed; `None` before the first pass.
    estimator: Option<ErrorEstimator>,
}

/// Final pictures of a rendering method, made at its last checkpoint; see [`MethodResult`].
struct FinalPictures {
    passes: u32,
    first_seed_picture: Image,
    relative_pixel_errors: Vec<f32>,
    mean_difference: Image,
}

impl<'a> MethodStudy<'a> {
    /// Prepares a study of `variants` with `seeds` seeds each.
    ///
    /// The first seed of a variant is the seed in its settings; the others are the next integers.
    ///
    /// # Errors
    /// [`MethodVariantError`] if there is no variant, if labels repeat, or if `seeds` is below two.
    pub fn prepare(scene: &'a Scene, variants: Vec<MethodVariant>, seeds: u32) -> Result<Self, MethodVariantError> {
        let with_factory = |variant: MethodVariant| {
            let (algorithm, settings) = (variant.algorithm, variant.settings.clone());
            let make = move |seed| {
                let mut settings = settings.clone();
                settings.camera_paths.seed = seed;
                settings.camera_paths.estimate_error = true;
                algorithm.prepare(scene, settings)
            };
            (variant, Box::new(make) as IntegratorFactory<'a>)
        };
        Self::new(scene.camera().size(), variants.into_iter().map(with_factory).collect(), seeds, system_clock())
    }

    pub(super) fn new(
        size: (u32, u32),
        variants: Vec<(MethodVariant, IntegratorFactory<'a>)>,
        seeds: u32,
        clock: ClockFn<'a>,
    ) -> Result<Self, MethodVariantError> {
        let (named, makers): (Vec<_>, Vec<_>) = variants.into_iter().unzip();
        check_method_variants(&named, seeds)?;
        let runs = named.into_iter().zip(makers).map(|(variant, make)| {
            let (first, setup) = measure_time(&clock, || make(variant.settings.camera_paths.seed));
            let (radii, expected) = (first.initial_gather_radii(), first.expected_photons());
            let alpha = first.radius_law().map_or(1.0, |law| law.alpha);
            let none = (1..seeds).map(|_| None);
            let film = |integrator| SeedRun { integrator, film: Film::new(size.0, size.1), estimator: None };
            MethodRun {
                variant,
                make_integrator: make,
                setup_seconds: setup.cpu_seconds,
                gather_radii: radii,
                expected_photons: expected,
                alpha,
                seeds: std::iter::once(Some(first)).chain(none).map(film).collect(),
                total_pass_time: CpuWallTime::default(),
                rays: 0,
                photon_paths: 0,
                checkpoints: Vec::new(),
                final_pictures: None,
            }
        });
        let runs = runs.collect();
        Ok(Self { size, seeds, clock, runs })
    }

    /// Returns the photon counts that are expected for a pass. If a count differs between the
    /// methods of the study, its largest value is returned.
    #[must_use]
    pub fn max_expected_photon_counts(&self) -> ExpectedPhotons {
        self.runs.iter().map(|run| run.expected_photons).fold(ExpectedPhotons::default(), |a, b| ExpectedPhotons {
            paths: a.paths.max(b.paths),
            memory_in_photons: a.memory_in_photons.max(b.memory_in_photons),
            largest_map_in_photons: a.largest_map_in_photons.max(b.largest_map_in_photons),
        })
    }

    /// Returns the memory that all pictures of a study take \[bytes].
    ///
    /// The pictures have `width` × `height` pixels. `variants` is the number of methods, and
    /// `seeds` the number of seeds of each method.
    #[must_use]
    pub fn study_picture_bytes((width, height): (u32, u32), variants: usize, seeds: u32) -> u64 {
        let (variants, seeds) = (variants as u64, u64::from(seeds));
        // For each variant: the films of all seeds; the last picture, its difference and its error
        // map. Once: both references and their mean; the weights of relative errors; pictures and
        // temporary images of the seeds of one variant.
        let pixel = variants * (BYTES_PER_FILM_PIXEL * seeds + 2 * BYTES_PER_PICTURE_PIXEL + 4)
            + 3 * BYTES_PER_PICTURE_PIXEL
            + 8
            + BYTES_PER_PICTURE_PIXEL * (seeds + 2);
        u64::from(width) * u64::from(height) * pixel
    }

    /// Runs all methods by turns, pass by pass, until each reaches one of the `limits`.
    ///
    /// Stops early if `interrupted` becomes true. Calls `after` for each progress event.
    ///
    /// # Errors
    /// [`StudyError`] if a pixel is not finite, or the references have another size.
    pub fn run(
        mut self,
        subject: &StudiedScene,
        limits: StudyLimits,
        references: &ReferencePictures,
        interrupted: &AtomicBool,
        monitor: &dyn ProgressMonitor,
        mut after: impl FnMut(MethodStudyEvent<'_>),
    ) -> Result<MethodStudyResult, StudyError> {
        let (mut round, mut was_cut_short) = (0u32, false);
        while self.runs.iter().any(|run| run.final_pictures.is_none()) {
            self.run_one_pass_per_seed(round, monitor);
            round += 1;
            after(MethodStudyEvent::PassFinished(round));
            let stop_requested = interrupted.load(Ordering::Relaxed);
            for run in self.runs.iter_mut().filter(|run| run.final_pictures.is_none()) {
                let is_out_of_time =
                    run.total_pass_time.cpu_seconds / f64::from(self.seeds) >= limits.cpu_seconds_per_seed;
                let done = is_out_of_time || limits.passes.is_some_and(|most| round >= most) || round == u32::MAX;
                was_cut_short |= stop_requested && !done;
                if done || stop_requested || round.is_power_of_two() {
                    let checkpoint = run.add_checkpoint(round, done || stop_requested, self.size, references)?;
                    after(MethodStudyEvent::Checkpoint(&run.variant.label, &checkpoint));
                }
            }
        }
        Ok(self.into_result(subject, limits, references, was_cut_short))
    }

    /// Makes one pass of each seed of each method that has not reached a limit.
    ///
    /// Each call starts with another method and seed, so that a temporary slowdown of the machine
    /// affects all methods equally.
    fn run_one_pass_per_seed(&mut self, pass: u32, monitor: &dyn ProgressMonitor) {
        let seeds = self.seeds as usize;
        let running = (0..self.runs.len()).filter(|i| self.runs[*i].final_pictures.is_none());
        let turns: Vec<(usize, usize)> = running.flat_map(|run| (0..seeds).map(move |seed| (run, seed))).collect();
        let (late, early) = turns.split_at(pass as usize % turns.len());
        for (run, seed) in early.iter().chain(late) {
            self.runs[*run].run_timed_pass(*seed, pass, &self.clock, monitor);
        }
    }

    fn into_result(
        self,
        subject: &StudiedScene,
        limits: StudyLimits,
        references: &ReferencePictures,
        interrupted: bool,
    ) -> MethodStudyResult {
        let threads = rayon::current_num_threads();
        let share =
            |run: &MethodRun<'_>| run.total_pass_time.cpu_seconds / (run.total_pass_time.wall_seconds * threads as f64);
        // The share of the threads' time is unknown if the system does not report processor time.
        let is_known = |share: &f64| share.is_finite() && cpu_seconds().is_some();
        let shares = self.runs.iter().map(share).filter(is_known);
        MethodStudyResult {
            scene_path: subject.scene_path.clone(),
            study_command: subject.study_command.clone(),
            program: format!("caustica {}", env!("CARGO_PKG_VERSION")),
            machine: super::clock::machine_description(threads),
            seeds: self.seeds,
            max_cpu_seconds_per_seed: limits.cpu_seconds_per_seed,
            thread_time_share: shares.fold(1.0, f64::min),
            reference: references.mean_reference(),
            methods: self.runs.into_iter().filter_map(|run| run.into_result(subject)).collect(),
            interrupted,
        }
    }
}

impl MethodRun<'_> {
    fn run_timed_pass(
        &mut self,
        seed: usize,
        number: u32,
        clock: &dyn Fn() -> CpuWallTime,
        monitor: &dyn ProgressMonitor,
    ) {
        let SeedRun { integrator, film, estimator } = &mut self.seeds[seed];
        let first = self.variant.settings.camera_paths.seed;
        let integrator = integrator.get_or_insert_with(|| (self.make_integrator)(first.wrapping_add(seed as u64)));
        let (pass, time) = measure_time(clock, || integrator.render_pass(number, monitor));
        estimator.get_or_insert_with(|| ErrorEstimator::new(integrator.radius_law())).add(number, &pass);
        film.add(&pass.image);
        self.total_pass_time += time;
        self.rays += pass.counters.total_rays();
        self.photon_paths += pass.unaimed.emitted_paths + pass.aimed.emitted_paths;
    }

    /// Measures the pictures of all seeds after `passes` passes. Adds a checkpoint and returns it.
    ///
    /// `last` is true when the method ends. Then the previous checkpoint is dropped if it has
    /// almost as many passes, see [`MIN_CHECKPOINT_PASS_RATIO`].
    fn add_checkpoint(
        &mut self,
        passes: u32,
        last: bool,
        size: (u32, u32),
        references: &ReferencePictures,
    ) -> Result<ConvergenceCheckpoint, StudyError> {
        let pictures: Vec<Vec<Rgb>> = self.seeds.iter().map(|seed| seed.film.mean_picture()).collect();
        let image = |pixels: Vec<Rgb>| Image::from_pixels(size.0, size.1, pixels);
        for picture in &pictures {
            // `rmse` is called because it fails if a pixel is not finite. Its value is not used.
            rmse(&image(picture.clone())?, references.mean())?;
        }
        let measured = separate_noise_and_bias(references, &pictures);
        let error = |seed: &SeedRun<'_>| Some(seed.estimator.as_ref()?.estimate(&seed.film).error);
        let squared_error_estimates: Vec<f64> =
            self.seeds.iter().filter_map(error).filter(|e| e.is_finite()).map(|e| e * e).collect();
        let seeds = pictures.len() as f64;
        let checkpoint = ConvergenceCheckpoint {
            passes,
            cpu_seconds: self.total_pass_time.cpu_seconds / seeds,
            wall_seconds: self.total_pass_time.wall_seconds / seeds,
            rays: self.rays as f64 / seeds,
            photon_paths: self.photon_paths as f64 / seeds,
            relative_squared_errors: measured.squared_errors,
            squared_noises: measured.squared_noises,
            squared_noise: measured.squared_noise,
            squared_bias: measured.squared_bias,
            squared_estimated_errors: squared_error_estimates,
            rmse: measured.rmse,
            flip: flip_metric(references.mean(), &image(pictures[0].clone())?, &FlipMetricOptions::default())?.mean,
        };
        if last {
            self.checkpoints.pop_if(|before| f64::from(passes) < MIN_CHECKPOINT_PASS_RATIO * f64::from(before.passes));
            let reference = references.mean().pixels();
            let differences = reference
                .iter()
                .enumerate()
                .map(|(i, t)| (mean_pixel_over_pictures(&pictures, i) - t.as_dvec3()).as_vec3());
            let mean_difference = image(differences.collect())?;
            let pixel_errors = relative_pixel_errors(references, &pictures);
            let first_seed_picture = image(pictures.into_iter().next().unwrap_or_default())?;
            self.final_pictures = Some(FinalPictures {
                passes,
                first_seed_picture,
                relative_pixel_errors: pixel_errors,
                mean_difference,
            });
            self.seeds.clear();
        }
        self.checkpoints.push(checkpoint.clone());
        Ok(checkpoint)
    }

    fn into_result(self, subject: &StudiedScene) -> Option<MethodResult> {
        let FinalPictures { passes, first_seed_picture, relative_pixel_errors: pixel_errors, mean_difference } =
            self.final_pictures?;
        Some(MethodResult {
            render_command: subject.render_command_line(&self.variant, passes),
            label: self.variant.label,
            algorithm: self.variant.algorithm,
            setup_seconds: self.setup_seconds,
            alpha: self.alpha,
            gather_radii: self.gather_radii.map(|r| [r.indirect, r.caustic]),
            checkpoints: self.checkpoints,
            first_seed_picture,
            relative_pixel_errors: pixel_errors,
            mean_difference,
        })
    }
}
