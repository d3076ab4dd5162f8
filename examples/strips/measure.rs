//! Renders one scene by one method until its estimated error falls to each of several targets.

use caustica::image::metrics::relative_error;
use caustica::integrate::{Integrator, RayPhotonBalance, SilentMonitor};
use caustica::render::ErrorTarget;
use caustica::render::error_estimate::{Confidence, MIN_ERROR_ESTIMATE_PASSES};
use caustica::stats::cpu_seconds;
use caustica::{Algorithm, ErrorEstimate, Image, RenderResult, Scene, Settings, StopCriteria, render};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::sync::atomic::{AtomicBool, Ordering};

/// Estimated errors at which pictures are kept, in descending order.
pub const TARGETS: [f64; 4] = [0.10, 0.05, 0.02, 0.01];

/// State of a render when it reached a target, or when the time was over.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stage {
    pub target: f64,
    /// Flags of `caustica render` that make small passes; empty for default passes.
    pub flags: String,
    /// True if the upper end of the error interval is at most `target`.
    pub is_reached: bool,
    pub error: f64,
    /// Interval that contains the true error with a probability of 80 %.
    pub low: f64,
    pub high: f64,
    pub passes: u32,
    /// Processor time since the process began to load the scene \[s].
    pub cpu_seconds: f64,
    pub camera_rays_per_pixel: f64,
    pub photon_paths: u64,
    /// Relative error with the last picture of the default method as the true picture; `None` for
    /// the default method.
    pub difference: Option<f64>,
}

/// Size of passes: the numbers of camera rays and photon paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassSize {
    /// Default numbers, which a pilot balances.
    Default,
    /// One camera ray per pixel. Numbers of photon paths keep the ratio to camera rays of default
    /// passes.
    Small,
}

/// A render of one method that can be continued.
pub struct MethodRender<'a> {
    integrator: Box<dyn Integrator + 'a>,
    /// State after the passes so far; `None` only while passes are rendered.
    rendered: Option<RenderResult>,
    /// Processor time so far \[s].
    cpu_seconds: f64,
    /// Flags of `caustica render` that make these passes; empty for default passes.
    flags: String,
    /// One stage for each of [`TARGETS`] that is reached, or all after [`MethodRender::finish`].
    pub stages: Vec<Stage>,
    /// Picture of each stage.
    pub pictures: Vec<Image>,
}

impl<'a> MethodRender<'a> {
    /// Prepares a render of `scene` by `algorithm`. `loading` is the processor time of loading the
    /// scene \[s].
    pub fn prepare(algorithm: Algorithm, scene: &'a Scene, size: PassSize, loading: f64) -> Self {
        let mut settings = Settings::default();
        settings.camera_paths.estimate_error = true;
        let mut flags = String::new();
        if size == PassSize::Small {
            let balance = algorithm.prepare(scene, settings.clone()).ray_photon_balance();
            flags = make_passes_small(&mut settings, balance);
        }
        let start = processor_time();
        let integrator = algorithm.prepare(scene, settings);
        let cpu_seconds = loading + processor_time() - start;
        let rendered = Some(RenderResult::without_passes(integrator.as_ref(), scene.camera().size()));
        Self { integrator, rendered, cpu_seconds, flags, stages: Vec::new(), pictures: Vec::new() }
    }

    /// Renders until `target` is reached or `limit` \[s] of processor time are over. Adds a stage
    /// for each target that is reached. Returns true if `target` is reached.
    pub fn render_until(&mut self, target: f64, limit: f64) -> Result<bool, Box<dyn Error>> {
        let is_over = AtomicBool::new(false);
        // The probability is that of `caustica render --target-error`.
        let confidence = Confidence::default();
        let stop = StopCriteria {
            min_passes: MIN_ERROR_ESTIMATE_PASSES,
            target: Some(ErrorTarget { error: target, confidence }),
            ..StopCriteria::unlimited(&is_over)
        };
        if self.stages.last().is_some_and(|stage| stage.target <= target) {
            return Ok(true);
        }
        let before = self.rendered.take().ok_or("an earlier render failed")?;
        let (start, cpu_before) = (processor_time(), self.cpu_seconds);
        let mut failure = None;
        let (stages, pictures, flags) = (&mut self.stages, &mut self.pictures, &self.flags);
        let after = render(before, 0..u32::MAX, self.integrator.as_ref(), &stop, &SilentMonitor, |progress| {
            let cpu = cpu_before + processor_time() - start;
            if let Some((estimate, _)) = progress.error.filter(|_| progress.passes >= MIN_ERROR_ESTIMATE_PASSES) {
                while let Some(&next) = TARGETS.get(stages.len()).filter(|next| estimate.high <= **next) {
                    stages.push(stage(next, flags, &estimate, progress.rendered, cpu));
                    match picture(progress.rendered) {
                        Ok(picture) => pictures.push(picture),
                        Err(error) => failure = Some(error),
                    }
                }
            }
            is_over.store(cpu >= limit, Ordering::Relaxed);
        });
        self.cpu_seconds = cpu_before + processor_time() - start;
        self.rendered = Some(after);
        match failure {
            Some(error) => Err(error),
            None => Ok(self.stages.last().is_some_and(|stage| stage.target <= target)),
        }
    }

    /// Adds a stage with the last picture for each target that was not reached.
    pub fn finish(&mut self) -> Result<(), Box<dyn Error>> {
        let rendered = self.rendered.as_ref().ok_or("an earlier render failed")?;
        let target = ErrorTarget { error: TARGETS[TARGETS.len() - 1], confidence: Confidence::default() };
        let estimate = rendered.estimate_error(Some(target)).map(|(estimate, _)| estimate);
        for &target in &TARGETS[self.stages.len()..] {
            let estimate = estimate.ok_or("too few passes for an error estimate")?;
            self.stages.push(stage(target, &self.flags, &estimate, rendered, self.cpu_seconds));
            self.pictures.push(picture(rendered)?);
        }
        Ok(())
    }

    /// Returns the relative error of the picture so far, with `reference` as the true picture.
    pub fn difference(&self, reference: &Image) -> Result<f64, Box<dyn Error>> {
        let rendered = self.rendered.as_ref().ok_or("an earlier render failed")?;
        Ok(relative_error(&picture(rendered)?, reference)?)
    }

    /// Processor time so far \[s].
    pub fn cpu_seconds(&self) -> f64 {
        self.cpu_seconds
    }
}

/// Processor time of this process so far \[s].
pub fn processor_time() -> f64 {
    cpu_seconds().unwrap_or(f64::NAN)
}

/// Makes passes of `settings` small, see [`PassSize::Small`]. Returns the flags that do so.
fn make_passes_small(settings: &mut Settings, balance: Option<RayPhotonBalance>) -> String {
    settings.camera_paths.samples_per_pixel = Some(1);
    let mut flags = "--spp 1".to_owned();
    let Some(balance) = balance else { return flags };
    let small = |paths: Option<u32>| paths.map(|paths| (paths / balance.samples_per_pixel).div_ceil(100) * 100);
    let (unaimed, aimed) = (small(balance.unaimed_paths), small(balance.aimed_paths));
    for (flag, paths) in [("--photons", unaimed), ("--caustic-photons", aimed)] {
        flags += &paths.map_or(String::new(), |paths| format!(" {flag} {paths}"));
    }
    // The command line derives the same settings from these flags.
    settings.allows_ray_photon_balance = unaimed.is_none() && aimed.is_none();
    settings.unaimed_paths = unaimed.unwrap_or(settings.unaimed_paths);
    settings.aimed_paths = aimed.unwrap_or(settings.unaimed_paths / 2);
    flags
}

fn stage(target: f64, flags: &str, estimate: &ErrorEstimate, rendered: &RenderResult, cpu_seconds: f64) -> Stage {
    let (width, height) = rendered.film.size();
    Stage {
        target,
        flags: flags.to_owned(),
        is_reached: estimate.high <= target,
        error: estimate.error,
        low: estimate.low,
        high: estimate.high,
        passes: estimate.passes,
        cpu_seconds,
        camera_rays_per_pixel: rendered.counters.camera_rays as f64 / (f64::from(width) * f64::from(height)),
        photon_paths: rendered.unaimed.emitted_paths + rendered.aimed.emitted_paths,
        difference: None,
    }
}

fn picture(rendered: &RenderResult) -> Result<Image, Box<dyn Error>> {
    let (width, height) = rendered.film.size();
    Ok(Image::from_pixels(width, height, rendered.film.mean_picture())?)
}
