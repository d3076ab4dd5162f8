//! Rendering in threads of its own, while the thread that called serves signals and the callback.

use crate::errors::Failure;
use crate::rendered::{NativeResult, confidence_from_probability, estimate_tuple};
use crate::scene::NativeScene;
use caustica::camera::{CropWindow, Filter, FilterKind, UnknownFilter};
use caustica::image::ToneCurve;
use caustica::integrate::{
    AovSurface, CameraPathSettings, DEFAULT_ALPHA, FinalGathering, IndirectPhotons, LightTracing, PassStage,
    SURFACE_AOV_RAYS, VolumeEstimator, render_surface_aovs,
};
use caustica::photon::{Kernel, UnknownKernel};
use caustica::plan::UnknownOverrideError;
use caustica::render::error_estimate::{Confidence, ErrorForecast};
use caustica::render::{
    ErrorTarget, LayerSelection, PassProgress, RenderLimits, RenderResult, StopCriteria, check_layered_picture_memory,
    check_photon_memory, render,
};
use caustica::{Algorithm, ErrorEstimate, ProgressMonitor, Settings};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// Time between two looks for signals, such as Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(20);

/// Arguments of `Scene.render`, which Python has checked. The program's flags have equal names.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct RenderOptions {
    integrator: String,
    passes: Option<u32>,
    seconds: Option<f64>,
    target_error: Option<f64>,
    confidence: f64,
    preview: bool,
    estimate_error: bool,
    seed: u64,
    size: Option<(u32, u32)>,
    threads: usize,
    photons: Option<u32>,
    caustic_photons: Option<u32>,
    spp: Option<u32>,
    max_bounces: u32,
    gather_k: Option<u32>,
    radius: Option<f32>,
    alpha: Option<f64>,
    kernel: String,
    filter: String,
    adaptive: bool,
    final_gathering: String,
    light_tracing: String,
    indirect_photons: String,
    volume: String,
    prefix_rays: bool,
    environment_guiding: bool,
    scatter_point_guiding: bool,
    effects: String,
    aovs: bool,
    aov_first_hit: bool,
    light_groups: bool,
    crop: Option<(u32, u32, u32, u32)>,
    clamp: Option<f32>,
}

/// Returns the algorithm named `name`, or a `ValueError` that lists all names.
pub fn algorithm_by_name(name: &str) -> PyResult<Algorithm> {
    let names = Algorithm::ALL.map(|algorithm| (algorithm.name(), algorithm));
    choice("integrator", name, &names)
}

/// Returns the value of `choices` that is named `name`, or a `ValueError` that lists all names.
fn choice<T: Copy>(option: &str, name: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(known, _)| *known == name);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<&str> = choices.iter().map(|(known, _)| *known).collect();
        PyValueError::new_err(format!("{option} is {name:?}: choose one of {}", known.join(", ")))
    })
}

impl RenderOptions {
    /// Returns the settings that the program makes from flags of equal names.
    fn settings(&self, algorithm: Algorithm) -> PyResult<Settings> {
        let filter: FilterKind =
            self.filter.parse().map_err(|e: UnknownFilter| PyValueError::new_err(e.to_string()))?;
        let kernel: Kernel = self.kernel.parse().map_err(|e: UnknownKernel| PyValueError::new_err(e.to_string()))?;
        let effects = self.effects.parse().map_err(|e: UnknownOverrideError| PyValueError::new_err(e.to_string()))?;
        let defaults = Settings::default();
        let unaimed_paths = self.photons.unwrap_or(defaults.unaimed_paths);
        Ok(Settings {
            camera_paths: CameraPathSettings {
                samples_per_pixel: self.spp,
                max_bounces: self.max_bounces,
                seed: self.seed,
                filter: Filter::new(filter),
                adaptive: self.adaptive,
                // Ray casting makes one pass, from which no error can be estimated.
                estimate_error: self.estimate_error && algorithm != Algorithm::Raycast,
                groups_light: self.light_groups,
                crop: self.crop.map(|(left, top, right, bottom)| CropWindow { left, top, right, bottom }),
                clamp: self.clamp,
                effects,
            },
            unaimed_paths,
            aimed_paths: self.caustic_photons.unwrap_or(unaimed_paths / 2),
            allows_ray_photon_balance: self.photons.is_none()
                && self.caustic_photons.is_none()
                && self.gather_k.is_none(),
            gather_k: self.gather_k,
            initial_gather_radius: self.radius,
            alpha: self.alpha.unwrap_or(DEFAULT_ALPHA),
            kernel,
            allows_prefix_rays: self.prefix_rays,
            allows_environment_guiding: self.environment_guiding,
            allows_scatter_point_guiding: self.scatter_point_guiding,
            light_tracing: choice(
                "light_tracing",
                &self.light_tracing,
                &[("off", LightTracing::Off), ("weighted", LightTracing::Weighted), ("full", LightTracing::Full)],
            )?,
            indirect_photons: choice(
                "indirect_photons",
                &self.indirect_photons,
                &[
                    ("off", IndirectPhotons::Off),
                    ("weighted", IndirectPhotons::Weighted),
                    ("full", IndirectPhotons::Full),
                ],
            )?,
            volume_estimator: choice(
                "volume",
                &self.volume,
                &[
                    ("beams", VolumeEstimator::Beams),
                    ("beam-radiance", VolumeEstimator::BeamRadiance),
                    ("points", VolumeEstimator::Points),
                ],
            )?,
            final_gathering: choice(
                "final_gathering",
                &self.final_gathering,
                &[
                    ("none", FinalGathering::None),
                    ("bsdf", FinalGathering::Bsdf),
                    ("importance", FinalGathering::Importance),
                ],
            )?,
        })
    }

    /// Returns when the render ends.
    fn limits(&self) -> PyResult<RenderLimits> {
        let time = self.seconds.map(Duration::try_from_secs_f64).transpose();
        Ok(RenderLimits {
            max_passes: self.passes,
            time_limit: time.map_err(|e| PyValueError::new_err(format!("time: {e}")))?,
            target_error: self.target_error,
            confidence: confidence_from_probability(self.confidence)?,
            preview: self.preview,
        })
    }
}

/// Flags by which the calling thread ends a render.
#[derive(Default)]
struct Flags {
    /// True to end the render after the current pass.
    stopped: AtomicBool,
    /// True to abandon the current pass.
    cancelled: AtomicBool,
}

impl ProgressMonitor for Flags {
    fn begin_stage(&self, _: PassStage, _: u64) {}

    fn report_progress(&self, _: u64) {}

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Progress after a pass, for the callback.
struct Progress {
    passes: u32,
    /// Time since the call of `render` \[s].
    seconds: f64,
    error: Option<(ErrorEstimate, ErrorForecast)>,
    /// Confidence of the interval of `error`.
    confidence: Confidence,
}

/// Both ends of a conversation in which a render reports a pass and waits until it may go on.
struct Reports {
    progress: SyncSender<Progress>,
    go_on: Receiver<()>,
}

/// Renders `scene` without the GIL. Serves signals, and calls `callback` after each pass.
pub fn render_scene(
    py: Python<'_>,
    scene: &NativeScene,
    options: &RenderOptions,
    callback: Option<Py<PyAny>>,
) -> PyResult<NativeResult> {
    let algorithm = algorithm_by_name(&options.integrator)?;
    let (settings, limits) = (options.settings(algorithm)?, options.limits()?);
    let (flags, start) = (Flags::default(), Instant::now());
    let (progress, received) = sync_channel(0);
    let (allow, go_on) = sync_channel(1);
    let reports = Reports { progress, go_on };
    let reports_passes = callback.is_some();
    let (flags, limits) = (&flags, &limits);
    let (outcome, exception) = py.detach(move || {
        std::thread::scope(|scope| {
            let work = move || {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build();
                let pool = pool.map_err(|e| Failure::Threads(e.to_string()))?;
                pool.install(move || {
                    let size = options.size.unwrap_or_else(|| scene.described_size());
                    let report = |progress: &PassProgress<'_>, confidence| {
                        let Reports { progress: sender, go_on } = &reports;
                        let (passes, error) = (progress.passes, progress.error);
                        let seconds = start.elapsed().as_secs_f64();
                        if reports_passes && sender.send(Progress { passes, seconds, error, confidence }).is_ok() {
                            // An error means that the caller waits no longer, so the render may
                            // end.
                            let _ = go_on.recv();
                        }
                    };
                    let surface = match (options.aovs, options.aov_first_hit) {
                        (false, _) => None,
                        (true, false) => Some(AovSurface::FirstNonSpecular),
                        (true, true) => Some(AovSurface::First),
                    };
                    render_passes(scene, size, algorithm, settings, surface, limits, flags, report)
                })
            };
            let worker = scope.spawn(work);
            let exception = serve_caller(&received, &allow, flags, callback.as_ref());
            (worker.join(), exception)
        })
    });
    if let Some(exception) = exception {
        return Err(exception);
    }
    let outcome = outcome.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    outcome.map_err(|failure| failure.into_exception(py))
}

/// Calls `callback` for each report, and looks for signals meanwhile, until the render has ended.
///
/// Returns the exception of the callback or of a signal. The render then ends soon.
fn serve_caller(
    received: &Receiver<Progress>,
    allow: &SyncSender<()>,
    flags: &Flags,
    callback: Option<&Py<PyAny>>,
) -> Option<PyErr> {
    let mut exception = None;
    loop {
        let report = match received.recv_timeout(SIGNAL_INTERVAL) {
            Ok(progress) => Some(progress),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return exception,
        };
        if exception.is_none() {
            let served = Python::attach(|py| {
                py.check_signals()?;
                let (Some(callback), Some(report)) = (callback, &report) else { return Ok(true) };
                call_back(py, callback, report)
            });
            match served {
                Ok(goes_on) => flags.stopped.fetch_or(!goes_on, Ordering::Relaxed),
                Err(error) => {
                    exception = Some(error);
                    flags.cancelled.store(true, Ordering::Relaxed);
                    flags.stopped.swap(true, Ordering::Relaxed)
                }
            };
        }
        if report.is_some() {
            // The queue has room for the one answer that the render waits for.
            let _ = allow.try_send(());
        }
    }
}

/// Calls the Python function `callback`. Returns false if it returns `False`.
fn call_back(py: Python<'_>, callback: &Py<PyAny>, report: &Progress) -> PyResult<bool> {
    let error = report.error.map(|(estimate, forecast)| estimate_tuple(&estimate, forecast, report.confidence));
    let answer = callback.bind(py).call1((report.passes, report.seconds, error))?;
    Ok(!answer.is(pyo3::types::PyBool::new(py, false)))
}

/// Renders passes until a limit is reached or a flag is set, then surface AOVs of `surface`.
#[expect(clippy::too_many_arguments, reason = "they come from one call")]
fn render_passes(
    scene: &NativeScene,
    size: (u32, u32),
    algorithm: Algorithm,
    settings: Settings,
    surface: Option<AovSurface>,
    limits: &RenderLimits,
    flags: &Flags,
    report: impl Fn(&PassProgress<'_>, Confidence),
) -> Result<NativeResult, Failure> {
    let began = Instant::now();
    let free = || scene.memory().available_bytes();
    let camera_paths = settings.camera_paths.clone();
    let CameraPathSettings { estimate_error: estimates_error, groups_light, clamp, .. } = camera_paths;
    let (clamps_light, renders_aovs) = (clamp.is_some(), surface.is_some());
    let layers =
        LayerSelection { estimates_error, groups_light, clamps_light, renders_aovs, ..LayerSelection::default() };
    let whole = size;
    let size = camera_paths.window(whole).size();
    let picture_bytes = check_layered_picture_memory(size, layers, free()).map_err(Failure::Memory)?;
    let scene = scene.resolved_for_size(whole)?;
    let integrator = algorithm.prepare(&scene, settings);
    check_photon_memory(integrator.expected_photons(), picture_bytes, free()).map_err(Failure::Memory)?;
    let stop = limits.stop_criteria(algorithm, integrator.as_ref(), &flags.stopped);
    let stop = StopCriteria { time_before_passes: began.elapsed(), ..stop };
    let interval_confidence = |default| stop.target.map_or(default, ErrorTarget::interval_confidence);
    // `render` estimates the error with the default confidence if it has no target.
    let (confidence, progress_confidence) =
        (interval_confidence(limits.confidence), interval_confidence(Confidence::default()));
    let start = RenderResult::without_passes(integrator.as_ref(), size);
    let rendered =
        render(start, 0..u32::MAX, integrator.as_ref(), &stop, flags, |progress| report(progress, progress_confidence));
    let effects = integrator.plan().simulated_effects();
    let aovs = surface
        .and_then(|surface| render_surface_aovs(&scene, effects, &camera_paths, surface, SURFACE_AOV_RAYS, flags));
    let tone = if algorithm == Algorithm::Raycast { ToneCurve::Legacy } else { ToneCurve::Srgb };
    Ok(NativeResult::new(rendered, aovs, tone, confidence))
}
