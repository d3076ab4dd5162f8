//! `caustica render`: renders a scene and writes pictures, error maps and a JSON report.

mod final_outputs;
mod pass_loop;
mod runs;
mod series;
mod stereo;
mod summary;
mod turntable;

use self::final_outputs::{RenderOutputs, write_options};
use self::pass_loop::render_passes;
use self::runs::{arguments_of_renders, named_inputs, output_files};
use self::stereo::render_stereo_pair;
use self::summary::print_scene_summary;
use self::turntable::render_frames;
use super::check::quick_scene_warnings;
use super::diagnostics::all_lights_are_black;
use super::film::{FilmHeaderSettings, LockedFilmFile, make_film_header};
use super::input_files::{InputFile, InputFileCollector};
use super::interrupt::{INTERRUPTED, STOP_CONSEQUENCE, listen_for_signals};
#[cfg(feature = "view")]
use super::live::LiveOutput;
use super::outputs::{FileWithRole, check_distinct_files};
use super::picture_updates::PictureUpdater;
use super::plan;
use super::progress::ProgressDisplay;
use super::report::RenderSetup;
use super::scene::{load_scene_and_file, with_thread_pool};
use super::settings::settings_from_arguments;
use super::shard::Shard;
#[cfg(feature = "view")]
use super::tev::TevOutput;
use super::{CommandFailure, Exit, RenderArguments, forecast_text};
use crate::camera::CropWindow;
use crate::image;
use crate::integrate::{
    Algorithm, AovSurface, CameraPathSettings, EmissionGuidingReports, Integrator, SURFACE_AOV_RAYS, SurfaceAovs,
    render_surface_aovs,
};
use crate::render::{
    FilmHeader, LayerSelection, RenderLimits, RenderResult, StopCriteria, check_layered_picture_memory,
    check_photon_memory,
};
use crate::scene::Scene;
#[cfg(feature = "view")]
use crate::view::{PlanReport, RenderPublisher, RenderStage};
use std::ops::Range;
use std::time::Instant;

/// Text on the progress bar while surface AOVs are rendered.
const AOV_LABEL: &str = "AOVs";

/// Number of camera rays per pixel for the surface AOVs (albedo, normal and others) of the live
/// page.
#[cfg(feature = "view")]
const LIVE_AOV_PIXEL_RAYS: u32 = 4;

/// Error: the requested shard, one of N parts of a render, has no passes.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("part {} of {} parts has none of {passes} passes", shard.number, shard.count)]
#[diagnostic(help("divide the passes into at most {passes} parts"))]
struct EmptyShardError {
    shard: Shard,
    passes: u32,
}

/// Error: a flag that needs simulated light is given with the algorithm `raycast`, which simulates
/// none.
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
    check_raycast_flags(&film_header_settings(arguments), arguments.target_error)?;
    // Everything that can fail without rendering is checked before rendering.
    for arguments in arguments_of_renders(arguments)? {
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
    check_distinct_files(&output_files(arguments)?, &named_inputs(arguments))?;
    listen_for_signals(STOP_CONSEQUENCE);
    let progress = ProgressDisplay::new(arguments.quiet);
    with_thread_pool(&arguments.scene, || load_scene_and_render(arguments, &progress))
}

/// Returns a failure if the algorithm is `raycast` and one of three flags is given: `--clamp` and
/// `--light-groups` need simulated light, and `--target-error` needs an error estimate.
pub(super) fn check_raycast_flags(
    settings: &FilmHeaderSettings<'_>,
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

/// Returns the width and height of the picture to render \[pixels]: those of the window `crop`, or
/// `whole` if `crop` is `None`. `whole` is the size of the whole picture.
pub(super) fn rendered_picture_size(crop: Option<CropWindow>, whole: (u32, u32)) -> Result<(u32, u32), CommandFailure> {
    match crop {
        Some(window) if window.fits_into(whole) => Ok(window.size()),
        Some(window) => Err(CommandFailure::usage_error(CropWindowTooLargeError { window, size: whole })),
        None => Ok(whole),
    }
}

/// Loads the scene and renders all its pictures: each frame of `--frames`, both eyes of `--stereo`,
/// or else one picture.
fn load_scene_and_render(arguments: &RenderArguments, progress: &ProgressDisplay) -> Result<Exit, CommandFailure> {
    let start = Instant::now();
    #[cfg(feature = "view")]
    let live_output = LiveOutput::start(arguments)?;
    #[cfg(feature = "view")]
    let live = live_output.as_ref().map(|output| output.begin_render(start));
    let scene_file = InputFile::new(&arguments.scene.scene);
    let inputs = InputFileCollector::new(progress);
    let (file, scene) = load_scene_and_file(&arguments.scene, &inputs)?;
    progress.remove_progress_bar();
    quick_scene_warnings(&file, &scene, &arguments.scene).iter().for_each(|line| progress.print_line(line));
    let camera = file.description.camera.value.clone();
    drop(file);
    let inputs = inputs.into_input_files();
    let named: Vec<FileWithRole> = inputs.iter().map(|file| FileWithRole::new("the input", &file.path)).collect();
    check_distinct_files(&output_files(arguments)?, &named)?;
    // Make the digests of the inputs before pilots (simulations before the first pass) run, because
    // files may change meanwhile.
    let film_header = requested_film_header(arguments, &scene, &scene_file, &inputs)?;
    print_scene_summary(&arguments.scene.scene.display().to_string(), &scene, progress);
    if let Some(range) = arguments.frames {
        return render_frames(arguments, range, &scene, &camera, progress);
    }
    if let Some(distance) = arguments.stereo {
        return render_stereo_pair(arguments, distance, &scene, &camera, progress);
    }
    let exit = render_scene(
        arguments,
        &scene,
        film_header,
        start,
        progress,
        #[cfg(feature = "view")]
        live,
    );
    #[cfg(feature = "view")]
    live_output.into_iter().for_each(LiveOutput::finish);
    exit
}

/// Renders one picture of `scene`, and writes all its outputs.
///
/// `film_header` is the header of the film of `--film`; `None` without this flag. The limit of
/// `--time` counts from `start`, the time at which loading began. If there are several pictures,
/// `start` is the time at which this picture began. `live` publishes the render on the live page.
fn render_scene(
    arguments: &RenderArguments,
    scene: &Scene,
    film_header: Option<FilmHeader>,
    start: Instant,
    progress: &ProgressDisplay,
    #[cfg(feature = "view")] mut live: Option<RenderPublisher<'_>>,
) -> Result<Exit, CommandFailure> {
    let algorithm = arguments.method.integrator;
    let mut setup = RenderSetup {
        scene: arguments.scene.scene.display().to_string(),
        integrator: algorithm.name(),
        seed: arguments.method.seed,
        threads: rayon::current_num_threads(),
        triangles: scene.triangle_count(),
        analytic_shapes: scene.analytic_shape_count(),
        lights: scene.lights().len(),
        gather_radii: None,
        emission_guiding: EmissionGuidingReports::default(),
        environment_guiding: None,
        scatter_point_guiding: None,
        effects: Vec::new(),
        balance: None,
        setup_seconds: 0.0,
    };
    // Ray casting makes only one pass. An error estimate needs several passes.
    let estimates_error = !arguments.no_error_estimate && algorithm != Algorithm::Raycast;
    let mut settings = settings_from_arguments(&arguments.method, arguments.effects.effects);
    settings.camera_paths.estimate_error = estimates_error;
    settings.camera_paths.groups_light = arguments.light_groups;
    (settings.camera_paths.crop, settings.camera_paths.clamp) = (arguments.crop, arguments.clamp);
    let camera_paths = settings.camera_paths.clone();
    let memory = arguments.scene.memory_limit();
    let size = rendered_picture_size(arguments.crop, scene.camera().size())?;
    let layers = requested_layers(arguments, estimates_error);
    let picture_bytes = check_layered_picture_memory(size, layers, memory.available_bytes());
    let picture_bytes = picture_bytes.map_err(CommandFailure::usage_error)?;
    #[cfg(feature = "view")]
    live.iter().for_each(|live| live.publish_stage(RenderStage::Pilots));
    let integrator = algorithm.prepare(scene, settings);
    check_photon_memory(integrator.expected_photons(), picture_bytes, memory.available_bytes())
        .map_err(CommandFailure::usage_error)?;
    plan::print_plan(integrator.as_ref(), progress);
    setup.gather_radii = integrator.initial_gather_radii();
    setup.emission_guiding = integrator.emission_guiding_reports();
    setup.environment_guiding = integrator.environment_guiding_report();
    setup.scatter_point_guiding = integrator.scatter_point_guiding_report();
    setup.effects = plan::plan_effect_reports(integrator.plan());
    setup.balance = integrator.ray_photon_balance();
    setup.setup_seconds = start.elapsed().as_secs_f64();
    let stop = render_limits(arguments).stop_criteria(algorithm, integrator.as_ref(), &INTERRUPTED);
    let (numbers, stop) = shard_passes_and_stop(arguments, stop)?;
    let mut film = None;
    let mut before = None;
    if let Some((path, header)) = arguments.film.as_ref().zip(film_header) {
        let (saved, rendered) = LockedFilmFile::open(path, header, arguments.save_every)?;
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
    let stop = StopCriteria { time_before_passes: start.elapsed(), ..stop };
    let options = write_options(arguments);
    let mut updates =
        arguments.update_interval().map(|interval| PictureUpdater::new(&arguments.output, &options, interval));
    #[cfg(feature = "view")]
    live.iter().for_each(|live| {
        let notes = plan::pass_work_lines(integrator.as_ref());
        live.publish_plan_and_limits(PlanReport::new(integrator.plan(), notes), &stop, size);
    });
    #[cfg(feature = "view")]
    let mut tev = arguments.tev.as_ref().map(|address| TevOutput::start(address, &setup.scene));
    let rendered = render_passes(before, numbers, &stop, integrator.as_ref(), start, progress, |standing| {
        if standing.end_reason.is_none() {
            updates.iter_mut().for_each(|updates| updates.update_if_due(&standing.rendered.film));
            film.iter_mut().for_each(|film| film.save_if_due(standing.rendered));
        }
        #[cfg(feature = "view")]
        live.iter_mut().for_each(|live| {
            live.publish_pass_if_due(standing, &stop);
            live.publish_wanted_surface_aovs(size, || {
                let effects = integrator.plan().simulated_effects();
                let surface = aov_surface(arguments);
                progress.set_work_label(AOV_LABEL);
                render_surface_aovs(scene, effects, &camera_paths, surface, LIVE_AOV_PIXEL_RAYS, progress)
            });
        });
        #[cfg(feature = "view")]
        tev.iter_mut().for_each(|tev| tev.send_if_due(standing.rendered));
    });
    progress.remove_progress_bar();
    #[cfg(feature = "view")]
    live.iter_mut().for_each(|live| live.publish_end(&rendered, RenderStage::Ended));
    let lights_are_black = all_lights_are_black(scene);
    let aovs = || find_surface_aovs(arguments, scene, integrator.as_ref(), &camera_paths, progress);
    let aovs = arguments.aov.is_some().then(aovs).flatten();
    progress.remove_progress_bar();
    #[cfg(feature = "view")]
    tev.into_iter().for_each(|tev| tev.finish(&rendered, aovs.as_ref(), arguments.aov.is_some()));
    let outputs = RenderOutputs { arguments, rendered: &rendered, aovs, film_file: film.as_ref() };
    outputs.write(progress, setup, &render_limits(arguments), &stop, lights_are_black)
}

/// Returns the layers that the command line asks for besides the picture, such as light groups.
/// Each of these layers takes memory.
fn requested_layers(arguments: &RenderArguments, estimates_error: bool) -> LayerSelection {
    LayerSelection {
        estimates_error,
        groups_light: arguments.light_groups,
        clamps_light: arguments.clamp.is_some(),
        #[cfg(feature = "view")]
        sends_to_tev: arguments.tev.is_some(),
        #[cfg(not(feature = "view"))]
        sends_to_tev: false,
        #[cfg(feature = "view")]
        renders_aovs: arguments.aov.is_some() || arguments.listen.is_some(),
        #[cfg(not(feature = "view"))]
        renders_aovs: arguments.aov.is_some(),
    }
}

/// Returns the indices (from 0) of the passes of `--shard`, which is one of N parts of the passes.
/// Also returns a copy of `stop` that ends the render after these passes.
///
/// Without `--shard`, returns all indices and an unchanged `stop`.
fn shard_passes_and_stop<'a>(
    arguments: &RenderArguments,
    stop: StopCriteria<'a>,
) -> Result<(Range<u32>, StopCriteria<'a>), CommandFailure> {
    let Some((shard, passes)) = arguments.shard.zip(arguments.passes) else { return Ok((0..u32::MAX, stop)) };
    let numbers = shard.passes(passes);
    if numbers.is_empty() {
        return Err(CommandFailure::usage_error(EmptyShardError { shard, passes }));
    }
    let count = numbers.end - numbers.start;
    Ok((numbers, StopCriteria { max_passes: Some(count), ..stop }))
}

/// Returns the header of the film of `--film`; `None` without this flag.
///
/// `scene_file` is the file of `scene`, and `inputs` are the files that it names.
fn requested_film_header(
    arguments: &RenderArguments,
    scene: &Scene,
    scene_file: &InputFile,
    inputs: &[InputFile],
) -> Result<Option<FilmHeader>, CommandFailure> {
    if arguments.film.is_none() {
        return Ok(None);
    }
    let whole = scene.camera().size();
    let size = rendered_picture_size(arguments.crop, whole)?;
    make_film_header(&film_header_settings(arguments), size, whole, scene_file, inputs).map(Some)
}

/// Returns the scene and the settings that the header of the film file holds.
fn film_header_settings(arguments: &RenderArguments) -> FilmHeaderSettings<'_> {
    FilmHeaderSettings {
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
        max_passes: arguments.passes,
        time_limit: arguments.time,
        target_error: arguments.target_error,
        confidence: arguments.confidence,
        preview: arguments.preview,
    }
}

/// Renders albedo, normal and the other surface AOVs of all pixels, and shows progress. Returns
/// `None` if the user cancels the render.
fn find_surface_aovs(
    arguments: &RenderArguments,
    scene: &Scene,
    integrator: &dyn Integrator,
    settings: &CameraPathSettings,
    progress: &ProgressDisplay,
) -> Option<SurfaceAovs> {
    let (effects, surface) = (integrator.plan().simulated_effects(), aov_surface(arguments));
    progress.set_work_label(AOV_LABEL);
    // The passes have ended, so the time left of the whole render is no longer meaningful.
    progress.set_time_left(None);
    render_surface_aovs(scene, effects, settings, surface, SURFACE_AOV_RAYS, progress)
}

/// Returns which surface along a camera ray the AOVs describe: the first with `--aov-first-hit`,
/// else the first that is not specular.
fn aov_surface(arguments: &RenderArguments) -> AovSurface {
    if arguments.aov_first_hit { AovSurface::First } else { AovSurface::FirstNonSpecular }
}
