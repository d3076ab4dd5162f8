//! `caustica render`: renders a scene and writes pictures, error maps and a JSON report.

use super::check::quick_scene_warnings;
use super::diagnostics::{all_lights_are_black, black_picture_note, no_photon_stored_note};
use super::film::{FilmSettings, SavedFilm, film_header};
use super::frames::{FrameNameError, Turntable, frame_path};
use super::interrupt::{INTERRUPTED, listen_for_signals};
#[cfg(feature = "view")]
use super::live::LiveOutput;
use super::number::count_with_noun;
use super::outputs::{FileWithRole, OutputFailures, check_distinct_files};
use super::pictures::write_pictures;
use super::plan;
use super::progress::{InputFileCollector, ProgressDisplay, print_message, warn_of_rejected_samples};
use super::report::{EstimatedErrorReport, RenderReport, RenderSetup};
use super::scene::{load_scene_and_file, with_thread_pool};
use super::settings::settings_from_arguments;
use super::shard::Shard;
#[cfg(feature = "view")]
use super::tev::TevOutput;
use super::updates::PictureUpdates;
use super::{CommandFailure, Exit, RenderArguments, forecast_text};
use crate::camera::CropWindow;
use crate::image::{self, Image, ToneCurve, WriteOptions};
use crate::integrate::{
    Algorithm, AovSurface, CameraPathSettings, EmissionGuidingReports, Integrator, SURFACE_AOV_RAYS, SurfaceAovs,
    render_surface_aovs,
};
use crate::render::error_estimate::{Confidence, MIN_PASSES, StopForecast};
use crate::render::{
    EndReason, ErrorTarget, PassProgress, RenderLimits, RenderResult, RenderedLayers, StopCriteria,
    check_layered_picture_memory, check_photon_memory, continue_render, picture_layers, surface_layers,
};
use crate::scene::Scene;
use crate::study::text::percent_text;
#[cfg(feature = "view")]
use crate::view::{LiveRender, Phase, PlanReport};
use glam::Vec3;
use std::ops::Range;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Number of rays of each pixel for surface AOVs of the live page.
#[cfg(feature = "view")]
const LIVE_SURFACE_RAYS: u32 = 4;

/// Error: the requested shard, one of N parts of a render, has no passes.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("part {} of {} parts has none of {passes} passes", shard.number, shard.count)]
#[diagnostic(help("divide the passes into at most {passes} parts"))]
struct EmptyShardError {
    shard: Shard,
    passes: u32,
}

/// Error: a flag about simulated light is given with the algorithm `raycast`.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{flag} needs light that is simulated, and raycast only shades surfaces")]
#[diagnostic(help("choose another --integrator"))]
struct UnsupportedByRaycastError {
    flag: &'static str,
}

/// Error: a crop window exceeds the picture.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the window {window} exceeds the picture of {} × {} pixels", size.0, size.1)]
#[diagnostic(help("choose a window inside of the picture, or another --size"))]
struct CropWindowTooLargeError {
    window: CropWindow,
    size: (u32, u32),
}

pub(super) fn run(arguments: &RenderArguments) -> Result<Exit, CommandFailure> {
    check_raycast_flags(&film_settings(arguments), arguments.target_error)?;
    // Everything that can fail without rendering is checked before rendering.
    for arguments in arguments_of_frames(arguments)? {
        for path in &arguments.output {
            image::check_writable(path).map_err(CommandFailure::output_error)?;
        }
        if let Some(path) = &arguments.aov {
            image::check_layers_path(path).map_err(CommandFailure::output_error)?;
        }
        for path in arguments.stats.iter().chain(&arguments.film) {
            image::check_replaceable(path).map_err(CommandFailure::output_error)?;
        }
    }
    check_distinct_files(&output_files(arguments)?, &[FileWithRole::new("the scene file", &arguments.scene.scene)])?;
    listen_for_signals("the picture so far is written after this pass");
    let progress = ProgressDisplay::new(arguments.quiet);
    with_thread_pool(&arguments.scene, || load_scene_and_render(arguments, &progress))
}

/// Returns an error if `settings` or `--target-error` need light that `raycast` does not simulate.
pub(super) fn check_raycast_flags(
    settings: &FilmSettings<'_>,
    target_error: Option<f64>,
) -> Result<(), CommandFailure> {
    if settings.method.integrator != Algorithm::Raycast {
        return Ok(());
    }
    if settings.clamp.is_some() {
        return Err(CommandFailure::usage_error(UnsupportedByRaycastError { flag: "--clamp" }));
    }
    if target_error.is_some() {
        let flag = "--target-error";
        return Err(CommandFailure::usage_error(forecast_text::ErrorEstimateUnsupportedError { flag }));
    }
    if settings.light_groups {
        return Err(CommandFailure::usage_error(UnsupportedByRaycastError { flag: "--light-groups" }));
    }
    Ok(())
}

/// Returns the size (width, height) of the picture to render \[pixels]: that of the window `crop`
/// of a `whole` picture, or that of the whole picture.
pub(super) fn window_size(crop: Option<CropWindow>, whole: (u32, u32)) -> Result<(u32, u32), CommandFailure> {
    match crop {
        Some(window) if window.fits_into(whole) => Ok(window.size()),
        Some(window) => Err(CommandFailure::usage_error(CropWindowTooLargeError { window, size: whole })),
        None => Ok(whole),
    }
}

/// Returns the arguments of each frame of `--frames`; without this flag, a copy of `arguments`.
fn arguments_of_frames(arguments: &RenderArguments) -> Result<Vec<RenderArguments>, CommandFailure> {
    let Some(range) = arguments.frames else { return Ok(vec![arguments.clone()]) };
    range.numbers().map(|frame| frame_arguments(arguments, frame).map_err(CommandFailure::usage_error)).collect()
}

/// Returns the arguments of one frame of `--frames`: with the names of its files, and a seed of its
/// own, so that the noise of frames differs.
fn frame_arguments(arguments: &RenderArguments, frame: u32) -> Result<RenderArguments, FrameNameError> {
    let mut of_frame = arguments.clone();
    of_frame.method.seed = arguments.method.seed.wrapping_add(frame.into());
    let paths = of_frame.output.iter_mut().map(|path| ("-o", path));
    let paths = paths.chain(of_frame.aov.iter_mut().map(|path| ("--aov", path)));
    for (flag, path) in paths.chain(of_frame.stats.iter_mut().map(|path| ("--stats", path))) {
        *path = frame_path(flag, path, frame)?;
    }
    Ok(of_frame)
}

/// Returns all output files of `caustica render` that the command line names, of all frames.
fn output_files(arguments: &RenderArguments) -> Result<Vec<FileWithRole>, CommandFailure> {
    let files = |arguments: &RenderArguments| -> Vec<FileWithRole> {
        let pictures = arguments.output.iter().map(|path| FileWithRole::new("-o", path));
        let layers = arguments.aov.iter().map(|path| FileWithRole::new("--aov", path));
        let report = arguments.stats.iter().map(|path| FileWithRole::new("--stats", path));
        let film = arguments.film.iter().map(|path| FileWithRole::new("--film", path));
        pictures.chain(layers).chain(report).chain(film).collect()
    };
    Ok(arguments_of_frames(arguments)?.iter().flat_map(files).collect())
}

/// Loads the scene and renders it: once, or each frame of `--frames`.
fn load_scene_and_render(arguments: &RenderArguments, progress: &ProgressDisplay) -> Result<Exit, CommandFailure> {
    let start = Instant::now();
    #[cfg(feature = "view")]
    let live_output = LiveOutput::start(arguments)?;
    #[cfg(feature = "view")]
    let live = live_output.as_ref().map(|output| output.begin_render(start));
    let inputs = InputFileCollector::new(progress);
    let (file, scene) = load_scene_and_file(&arguments.scene, &inputs)?;
    progress.remove_progress_bar();
    quick_scene_warnings(&file, &scene, &arguments.scene).iter().for_each(|line| progress.print_line(line));
    let camera = file.description.camera.value.clone();
    drop(file);
    let input_paths = inputs.into_input_paths();
    let inputs: Vec<FileWithRole> = input_paths.iter().map(|path| FileWithRole::new("the input", path)).collect();
    check_distinct_files(&output_files(arguments)?, &inputs)?;
    print_scene_summary(&arguments.scene.scene.display().to_string(), &scene, progress);
    let Some(range) = arguments.frames else {
        let exit = render_scene(
            arguments,
            &scene,
            &input_paths,
            start,
            progress,
            #[cfg(feature = "view")]
            live,
        );
        #[cfg(feature = "view")]
        live_output.into_iter().for_each(LiveOutput::finish);
        return exit;
    };
    let turntable = Turntable::new(&scene, &camera, arguments.turn.unwrap_or(range.end));
    let turntable = turntable.map_err(CommandFailure::usage_error)?;
    for frame in range.numbers() {
        progress.print_line(&format!("frame {frame} of {} to {}", range.first, range.end - 1));
        let arguments = frame_arguments(arguments, frame).map_err(CommandFailure::usage_error)?;
        let turned = turntable.camera(frame).map(|camera| scene.with_camera(&camera));
        let scene = turned.as_ref().unwrap_or(&scene);
        let exit = render_scene(
            &arguments,
            scene,
            &input_paths,
            Instant::now(),
            progress,
            #[cfg(feature = "view")]
            None,
        )?;
        if exit != Exit::Success {
            return Ok(exit);
        }
    }
    Ok(Exit::Success)
}

/// Renders `scene`, and writes all outputs.
///
/// `inputs` are the files that the scene names. `start` is the time at which loading began. `live`
/// shows the render on a page.
fn render_scene(
    arguments: &RenderArguments,
    scene: &Scene,
    inputs: &[PathBuf],
    start: Instant,
    progress: &ProgressDisplay,
    #[cfg(feature = "view")] mut live: Option<LiveRender<'_>>,
) -> Result<Exit, CommandFailure> {
    let algorithm = arguments.method.integrator;
    let mut setup = RenderSetup {
        scene: arguments.scene.scene.display().to_string(),
        integrator: algorithm.name(),
        seed: arguments.method.seed,
        threads: rayon::current_num_threads(),
        triangles: scene.triangle_count(),
        shapes: scene.shape_count(),
        lights: scene.lights().len(),
        radii: None,
        emission_guiding: EmissionGuidingReports::default(),
        environment_guiding: None,
        scatter_point_guiding: None,
        effects: Vec::new(),
        balance: None,
        seconds: 0.0,
    };
    // Ray casting makes one pass, from which no error can be estimated.
    let estimates_error = !arguments.no_error_estimate && algorithm != Algorithm::Raycast;
    let mut settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
    settings.camera_paths.estimate_error = estimates_error;
    settings.camera_paths.groups_light = arguments.light_groups;
    (settings.camera_paths.crop, settings.camera_paths.clamp) = (arguments.crop, arguments.clamp);
    let camera_paths = settings.camera_paths.clone();
    let (memory, whole) = (arguments.scene.memory_limit(), scene.camera().size());
    let size = window_size(arguments.crop, whole)?;
    let layers = rendered_layers(arguments, estimates_error);
    let pictures = check_layered_picture_memory(size, layers, memory.available_bytes());
    let pictures = pictures.map_err(CommandFailure::usage_error)?;
    #[cfg(feature = "view")]
    live.iter().for_each(|live| live.set_phase(Phase::Pilots));
    let integrator = algorithm.prepare(scene, settings);
    check_photon_memory(integrator.expected_photons(), pictures, memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    plan::print_plan(integrator.as_ref(), progress);
    setup.radii = integrator.gather_radii();
    setup.emission_guiding = integrator.emission_guiding_reports();
    setup.environment_guiding = integrator.environment_guiding_report();
    setup.scatter_point_guiding = integrator.scatter_point_guiding_report();
    setup.effects = plan::plan_effect_reports(integrator.plan());
    setup.balance = integrator.ray_photon_balance();
    setup.seconds = start.elapsed().as_secs_f64();
    let stop = render_limits(arguments).stop_criteria(algorithm, integrator.as_ref(), &INTERRUPTED);
    let (numbers, stop) = passes_of_shard(arguments, stop)?;
    let mut film = None;
    let mut before = None;
    if let Some(path) = &arguments.film {
        let header = film_header(&film_settings(arguments), size, whole, inputs)?;
        let (saved, rendered) = SavedFilm::open(path, header, arguments.save_every)?;
        if let Some(rendered) = rendered {
            if arguments.shard.is_some() {
                saved.check_shard(&rendered, numbers.clone())?;
            }
            progress.print_line(&saved.continuation_line(&rendered));
            before = Some(rendered);
        }
        film = Some(saved);
    }
    let before = before.unwrap_or_else(|| RenderResult::without_passes(integrator.as_ref(), size));
    let options = write_options(arguments);
    let mut updates =
        arguments.update_interval().map(|interval| PictureUpdates::new(&arguments.output, &options, interval));
    #[cfg(feature = "view")]
    live.iter().for_each(|live| {
        let notes = plan::pass_work_lines(integrator.as_ref());
        live.begin_passes(PlanReport::new(integrator.plan(), notes), &stop, size);
    });
    #[cfg(feature = "view")]
    let mut tev = arguments.tev.as_ref().map(|address| TevOutput::start(address, &setup.scene));
    let rendered = render_passes(before, numbers, &stop, integrator.as_ref(), start, progress, |standing| {
        if standing.ended.is_none() {
            updates.iter_mut().for_each(|updates| updates.update(&standing.rendered.film));
            film.iter_mut().for_each(|film| film.save_if_due(standing.rendered));
        }
        #[cfg(feature = "view")]
        live.iter_mut().for_each(|live| {
            live.after_pass(standing, &stop);
            live.publish_wanted_surfaces(size, || {
                let effects = integrator.plan().simulated_effects();
                let surface = aov_surface(arguments);
                render_surface_aovs(scene, effects, &camera_paths, surface, LIVE_SURFACE_RAYS, progress)
            });
        });
        #[cfg(feature = "view")]
        tev.iter_mut().for_each(|tev| tev.send_if_due(standing.rendered));
    });
    progress.remove_progress_bar();
    #[cfg(feature = "view")]
    live.iter_mut().for_each(|live| live.publish_end(&rendered, Phase::Ended));
    let powerless = all_lights_are_black(scene);
    let aovs = || find_surface_aovs(arguments, scene, integrator.as_ref(), &camera_paths, progress);
    let aovs = arguments.aov.is_some().then(aovs).flatten();
    progress.remove_progress_bar();
    #[cfg(feature = "view")]
    tev.into_iter().for_each(|tev| tev.finish(&rendered, aovs.as_ref(), arguments.aov.is_some()));
    let outputs = RenderOutputs { arguments, rendered: &rendered, aovs, film: film.as_ref() };
    outputs.write(progress, setup, &stop, powerless)
}

/// Returns which layers beside the picture the command line asks for. Each of them needs memory.
fn rendered_layers(arguments: &RenderArguments, estimates_error: bool) -> RenderedLayers {
    RenderedLayers {
        error: estimates_error,
        groups: arguments.light_groups,
        clamped: arguments.clamp.is_some(),
        #[cfg(feature = "view")]
        sent: arguments.tev.is_some(),
        #[cfg(not(feature = "view"))]
        sent: false,
        #[cfg(feature = "view")]
        aovs: arguments.aov.is_some() || arguments.listen.is_some(),
        #[cfg(not(feature = "view"))]
        aovs: arguments.aov.is_some(),
    }
}

/// Returns the indices of the passes to render, and `stop` with the number of these passes as its
/// limit.
///
/// Without `--shard`, the indices have no limit and `stop` stays unchanged.
fn passes_of_shard<'a>(
    arguments: &RenderArguments,
    stop: StopCriteria<'a>,
) -> Result<(Range<u32>, StopCriteria<'a>), CommandFailure> {
    let Some((shard, passes)) = arguments.shard.zip(arguments.passes) else { return Ok((0..u32::MAX, stop)) };
    let numbers = shard.passes(passes);
    if numbers.is_empty() {
        return Err(CommandFailure::usage_error(EmptyShardError { shard, passes }));
    }
    let count = numbers.end - numbers.start;
    Ok((numbers, StopCriteria { passes: Some(count), ..stop }))
}

/// Returns the scene and the settings that the film file names.
fn film_settings(arguments: &RenderArguments) -> FilmSettings<'_> {
    FilmSettings {
        scene: &arguments.scene.scene,
        method: &arguments.method,
        effects: arguments.effects.effects,
        no_error_estimate: arguments.no_error_estimate,
        light_groups: arguments.light_groups,
        clamp: arguments.clamp,
        crop: arguments.crop,
        planned_passes: arguments.shard.and(arguments.passes),
    }
}

/// Returns the limits of the render that the command line sets.
fn render_limits(arguments: &RenderArguments) -> RenderLimits {
    RenderLimits {
        passes: arguments.passes,
        time: arguments.time,
        target_error: arguments.target_error,
        confidence: arguments.confidence,
        preview: arguments.preview,
    }
}

/// Prints the name of the scene, its numbers of triangles, shapes and lights, and a note if it has
/// no objects or lights.
fn print_scene_summary(name: &str, scene: &Scene, progress: &ProgressDisplay) {
    let (triangles, shapes, lights) = (scene.triangle_count(), scene.shape_count(), scene.lights().len());
    progress.print_line(&format!(
        "{name}: {}, {}, {}",
        count_with_noun(triangles, "triangle", "triangles"),
        count_with_noun(shapes, "shape", "shapes"),
        count_with_noun(lights, "light", "lights")
    ));
    if triangles + shapes == 0 {
        progress.print_line("note: the scene has no objects: the picture shows only the background");
    } else if lights == 0 {
        progress.print_line("note: the scene has no lights: all objects are black");
    } else if all_lights_are_black(scene) {
        progress.print_line("note: no light of the scene has any power: all objects are black");
    }
}

/// Adds passes to the result `before`, until a criterion of `stop` holds, and shows progress.
///
/// `numbers` are the indices of the passes to add. `after_pass` is called after each pass.
fn render_passes(
    before: RenderResult,
    numbers: Range<u32>,
    stop: &StopCriteria<'_>,
    integrator: &dyn Integrator,
    start: Instant,
    progress: &ProgressDisplay,
    mut after_pass: impl FnMut(&PassProgress<'_>),
) -> RenderResult {
    let passes_before = before.film.passes();
    let (passes, target) = (stop.passes, stop.target);
    progress.set_pass_number(passes_before + 1, passes);
    // With a target, the time is known only after the first error estimate.
    progress.set_time_left(stop.time.filter(|_| target.is_none()));
    let began = Instant::now();
    continue_render(before, numbers, integrator, stop, progress, |standing| {
        let pass_seconds = began.elapsed().as_secs_f64() / f64::from(standing.passes - passes_before);
        let forecast = standing.error.as_ref().filter(|_| !progress.is_quiet()).map(|(estimate, forecast)| {
            // Without a target, the forecast is for half of the error.
            let half = ErrorTarget { error: 0.5 * estimate.error, confidence: Confidence::default() };
            let target = target.unwrap_or(half);
            (estimate, target, forecast.stop_forecast(target.error, target.interval_confidence()))
        });
        let error = forecast.as_ref().map(|(estimate, target, forecast)| {
            format!(
                "error {}{}",
                forecast_text::error_text(estimate),
                forecast_text::time_to_target_text(estimate, *target, *forecast, pass_seconds)
            )
        });
        if progress.uses_plain_lines() {
            let of = passes.map_or(String::new(), |n| format!("/{n}"));
            let error = error.as_ref().map_or(String::new(), |error| format!(": {error}"));
            let elapsed = start.elapsed().as_secs_f64();
            progress.print_line(&format!("pass {}{of} after {elapsed:.1} s{error}", standing.passes));
        }
        progress.set_pass_number(standing.passes + 1, passes);
        // Most passes do not estimate the error. After them, the previous time left stays on show.
        let forecast = forecast.map(|(_, _, forecast)| forecast);
        if let Some(left) = time_until_stop(stop, standing.passes, forecast, began.elapsed(), pass_seconds) {
            progress.set_time_left(Some(left));
        }
        error.into_iter().for_each(|note| progress.set_progress_note(note));
        after_pass(standing);
    })
}

/// Returns the expected remaining time until the first stop criterion holds; `None` if it is
/// unknown, as with an error target after a pass without an error estimate.
///
/// `passes` is the number of passes so far. `forecast` predicts the passes until the target of
/// `stop`; it is ignored if `stop` has no target.
fn time_until_stop(
    stop: &StopCriteria<'_>,
    passes: u32,
    forecast: Option<StopForecast>,
    elapsed: Duration,
    pass_seconds: f64,
) -> Option<Duration> {
    if stop.target.is_some() && forecast.is_none() {
        return None;
    }
    let of_passes = |n: u32| f64::from(n.saturating_sub(passes)) * pass_seconds;
    let by_target = forecast.filter(|_| stop.target.is_some()).and_then(|forecast| match forecast {
        StopForecast::Passes(range) => Some(of_passes(range.median)),
        StopForecast::Never { .. } | StopForecast::TooFar { .. } => None,
    });
    let by_time = stop.time.map(|time| time.saturating_sub(elapsed).as_secs_f64());
    let all = [stop.passes.map(of_passes), by_time, by_target];
    let least = all.into_iter().flatten().min_by(f64::total_cmp)?;
    Duration::try_from_secs_f64(least).ok()
}

/// Finds albedo, normal and the like of all pixels, and shows progress; `None` if it is cancelled.
fn find_surface_aovs(
    arguments: &RenderArguments,
    scene: &Scene,
    integrator: &dyn Integrator,
    settings: &CameraPathSettings,
    progress: &ProgressDisplay,
) -> Option<SurfaceAovs> {
    let (effects, surface) = (integrator.plan().simulated_effects(), aov_surface(arguments));
    render_surface_aovs(scene, effects, settings, surface, SURFACE_AOV_RAYS, progress)
}

/// Returns the surface whose properties the command line asks for.
fn aov_surface(arguments: &RenderArguments) -> AovSurface {
    if arguments.aov_first_hit { AovSurface::First } else { AovSurface::FirstNonSpecular }
}

/// Outputs that are written after a render has ended: picture, layers, film and statistics.
struct RenderOutputs<'a> {
    arguments: &'a RenderArguments,
    rendered: &'a RenderResult,
    /// Albedo, normal and the like for `--aov`; `None` without this flag, or after a cancellation.
    aovs: Option<SurfaceAovs>,
    /// Film file of the render; `None` without `--film`.
    film: Option<&'a SavedFilm<'a>>,
}

impl RenderOutputs<'_> {
    /// Writes all outputs and prints a summary. An output that fails does not stop the others.
    ///
    /// `powerless` is true if the scene has lights, but none has any power.
    fn write(
        &self,
        progress: &ProgressDisplay,
        setup: RenderSetup,
        stop: &StopCriteria<'_>,
        powerless: bool,
    ) -> Result<Exit, CommandFailure> {
        let Self { arguments, rendered, film, .. } = *self;
        let (width, height) = rendered.film.size();
        let picture = Image::from_pixels(width, height, rendered.film.mean()).map_err(CommandFailure::output_error)?;
        let mut failures = OutputFailures::default();
        self.write_pictures(progress, &picture, &mut failures);
        if let (Some(path), Some(film)) = (&arguments.film, film)
            && failures.ok_or_collect_error(film.save(rendered)).is_some()
        {
            progress.print_line(&format!("wrote {}", path.display()));
        }
        warn_of_rejected_samples(&rendered.counters);
        if picture.pixels().iter().all(|p| *p == Vec3::ZERO) {
            progress.print_line(black_picture_note(setup.lights, powerless));
        }
        no_photon_stored_note(rendered).iter().for_each(|line| progress.print_line(line));
        let limits = render_limits(arguments);
        let report = RenderReport::new(setup, &limits, stop, rendered);
        print_render_summary(&limits, stop, progress, &report, rendered);
        if let Some(path) = &arguments.stats {
            let json = serde_json::to_vec_pretty(&report).map_err(CommandFailure::output_error)?;
            failures.ok_or_collect_error(image::replace_file(path, &json));
        }
        failures.into_result(if rendered.ended == EndReason::Interrupted { Exit::Interrupted } else { Exit::Success })
    }

    /// Writes the files of `-o` and `--aov`. Collects errors in `failures`.
    fn write_pictures(&self, progress: &ProgressDisplay, picture: &Image, failures: &mut OutputFailures) {
        let Self { arguments, rendered, ref aovs, .. } = *self;
        let options = write_options(arguments);
        write_pictures(arguments.output.iter(), picture, &options, progress, failures);
        let Some(path) = &arguments.aov else { return };
        let passes = rendered.film.passes();
        if passes < MIN_PASSES && rendered.estimator.is_some() {
            let passes = count_with_noun(passes as usize, "pass gives", "passes give");
            print_message(&format!("warning: {passes} no error estimate: {} has no maps of it", path.display()));
        }
        let mut layers = picture_layers(rendered);
        layers.extend(aovs.iter().flat_map(surface_layers));
        let written = image::write_layers(path, rendered.film.size(), &layers, &options.metadata);
        if let Some(non_finite) = failures.ok_or_collect_error(written) {
            progress.print_line(&format!("wrote {}", path.display()));
            if non_finite > 0 {
                let values = count_with_noun(non_finite, "value", "values");
                let path = path.display();
                print_message(&format!("warning: {values} of {path} exceed single precision: the scene is too bright"));
            }
        }
    }
}

/// Returns the options with which the files of `-o` and `--aov` are written.
fn write_options(arguments: &RenderArguments) -> WriteOptions {
    arguments.pictures.write_options(match arguments.method.integrator {
        Algorithm::Raycast => ToneCurve::Legacy,
        Algorithm::Hybrid
        | Algorithm::Path
        | Algorithm::Sppm
        | Algorithm::Ppm
        | Algorithm::Pm
        | Algorithm::Distributed
        | Algorithm::Whitted => ToneCurve::Srgb,
    })
}

/// Prints the number of passes, rays and photons per second, why the render ended, and the
/// estimated error.
fn print_render_summary(
    limits: &RenderLimits,
    stop: &StopCriteria<'_>,
    progress: &ProgressDisplay,
    report: &RenderReport,
    rendered: &RenderResult,
) {
    let n = rendered.film.passes();
    let why = match rendered.ended {
        EndReason::Passes => String::new(),
        EndReason::Time => format!("; time was up: --passes {n} repeats this picture bit for bit"),
        EndReason::Target => format!("; the error is low enough: --passes {n} repeats this picture bit for bit"),
        EndReason::Floor => "; more passes cannot reach the error".to_owned(),
        EndReason::Interrupted => format!("; interrupted: --passes {n} repeats this picture"),
    };
    progress.print_line(&format!(
        "{} in {:.1} s, {:.2} M rays/s, {:.2} M photon paths/s{why}",
        count_with_noun(report.passes as usize, "pass", "passes"),
        report.seconds.render,
        report.rates.rays_per_second * 1e-6,
        report.rates.photons_per_second * 1e-6,
    ));
    if let Some(fraction) = report.clamped_fraction {
        progress.print_line(&format!("clamping removed {} of the light", percent_text(fraction)));
    }
    if let Some(EstimatedErrorReport { estimate, confidence, .. }) = &report.error {
        let interval = format!("{} to {}", percent_text(estimate.low), percent_text(estimate.high));
        let confidence = percent_text(confidence.probability());
        progress.print_line(&format!(
            "estimated error {}; {interval} with {confidence} confidence",
            forecast_text::error_text(estimate)
        ));
    }
    if limits.are_default() {
        default_end_line(stop, rendered.ended).iter().for_each(|line| progress.print_line(line));
    }
    if rendered.ended == EndReason::Floor {
        print_message(&format!("warning: {}", forecast_text::BIAS_REMEDY));
    }
}

/// Returns a line that says which default limit ended a render: error, time or bias. `None` if the
/// number of passes or the user ended it, or if `stop` lacks a target or a time limit.
fn default_end_line(stop: &StopCriteria<'_>, ended: EndReason) -> Option<String> {
    let (target, time) = (stop.target?, stop.time?);
    let error = percent_text(target.error);
    let confidence = percent_text(target.confidence.probability());
    let time = forecast_text::duration_text(time.as_secs_f64());
    match ended {
        EndReason::Target => Some(format!(
            "ended by error: at most {error} with {confidence} confidence. --target-error sets another error"
        )),
        EndReason::Time => {
            Some(format!("ended by time: {time} were over before the error fell to {error}. --time sets another time"))
        }
        EndReason::Floor => Some(format!("ended by bias: more passes cannot lower the error to {error}")),
        EndReason::Passes | EndReason::Interrupted => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::error_estimate::Confidence;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn the_last_line_names_the_default_limit_that_ended_a_render() {
        let interrupted = AtomicBool::new(false);
        let target = Some(ErrorTarget { error: 0.03, confidence: Confidence::default() });
        let stop =
            StopCriteria { target, time: Some(Duration::from_secs(300)), ..StopCriteria::unlimited(&interrupted) };
        let line = |ended| default_end_line(&stop, ended);
        let begins = |ended, text: &str| line(ended).is_some_and(|line| line.starts_with(text));
        assert!(begins(EndReason::Target, "ended by error: at most 3.0 %"));
        assert!(begins(EndReason::Time, "ended by time: 5 min 0 s were over before the error fell to 3.0 %"));
        assert!(begins(EndReason::Floor, "ended by bias: "));
        assert_eq!(line(EndReason::Passes).or(line(EndReason::Interrupted)), None);
    }

    #[test]
    fn the_first_stop_condition_sets_the_time_left() {
        let interrupted = AtomicBool::new(false);
        let limits = |passes: Option<u32>, time: Option<u64>| {
            let time = time.map(Duration::from_secs);
            StopCriteria { passes, time, ..StopCriteria::unlimited(&interrupted) }
        };
        let left_of = |stop: StopCriteria<'_>| {
            time_until_stop(&stop, 4, None, Duration::from_secs(8), 2.0).map(|left| left.as_secs())
        };
        let left = |passes, time| left_of(limits(passes, time));
        assert_eq!(left(Some(10), None), Some(12));
        assert_eq!(left(None, Some(10)), Some(2));
        assert_eq!(left(Some(10), Some(10)), Some(2));
        assert_eq!((left(None, None), left(None, Some(1))), (None, Some(0)));
        let target = Some(ErrorTarget { error: 0.03, confidence: Confidence::default() });
        assert_eq!(left_of(StopCriteria { target, ..limits(Some(10), Some(10)) }), None);
    }
}
