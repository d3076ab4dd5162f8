//! `caustica render`.

use super::dark::{self, without_photons};
use super::error;
use super::interrupt::{INTERRUPTED, listen};
use super::memory::{check_gauged, check_photons, check_pictures};
use super::plan::{self, counted};
use super::progress::{Progress, tell, tell_of_rejected};
use super::report::{ErrorReport, Report, Setting};
use super::scene::{in_pool, load};
use super::settings::settings;
use super::{Exit, Failure, RenderArguments, aov};
use crate::image::{self, Curve, Image, OutputFormat, ToneMap, WriteOptions, WriteReport};
use crate::integrate::{Algorithm, GuidingReports};
use crate::render::gauge::{Confidence, FEWEST};
use crate::render::{Ended, Rendered, Stop, Target, render};
use crate::study::text::percent;
use glam::Vec3;
use miette::IntoDiagnostic;
use std::path::Path;
use std::time::Instant;

pub(super) fn run(arguments: &RenderArguments) -> Result<Exit, Failure> {
    let asked = [("--target-error", arguments.target_error.is_some()), ("--aov", arguments.aov.is_some())];
    if let (Algorithm::Raycast, Some((flag, _))) = (arguments.method.integrator, asked.iter().find(|(_, is)| *is)) {
        return Err(Failure::new(Exit::Usage, error::NoError { flag }));
    }
    // Whatever can fail without rendering fails before it.
    for path in &arguments.output {
        image::check_writable(path).into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))?;
    }
    if let Some(path) = &arguments.aov {
        image::check_layers_path(path).into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))?;
    }
    if let Some(path) = &arguments.stats {
        image::check_place(path).into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))?;
    }
    listen("the picture");
    let progress = Progress::new(arguments.quiet);
    in_pool(&arguments.scene, || run_in_pool(arguments, &progress))
}

fn run_in_pool(arguments: &RenderArguments, progress: &Progress) -> Result<Exit, Failure> {
    let start = Instant::now();
    let scene = load(&arguments.scene, progress)?;
    let algorithm = arguments.method.integrator;
    let mut setting = Setting {
        scene: arguments.scene.scene.display().to_string(),
        integrator: algorithm.name(),
        seed: arguments.method.seed,
        threads: rayon::current_num_threads(),
        triangles: scene.triangle_count(),
        shapes: scene.shape_count(),
        lights: scene.lights().len(),
        radii: None,
        emission: GuidingReports::default(),
        effects: Vec::new(),
        balance: None,
        setup: 0.0,
    };
    progress.say(&format!(
        "{}: {}, {}, {}",
        setting.scene,
        counted(setting.triangles, "triangle", "triangles"),
        counted(setting.shapes, "shape", "shapes"),
        counted(setting.lights, "light", "lights")
    ));
    let powerless = dark::is_powerless(&scene);
    if setting.triangles + setting.shapes == 0 {
        progress.say("note: the scene has no objects: only its background is seen");
    } else if setting.lights == 0 {
        progress.say("note: the scene has no lights: all but its background is black");
    } else if powerless {
        progress.say("note: no light of the scene has any power: all but its background is black");
    }
    // Ray casting makes one pass, from which no error can be told.
    let gauged = !arguments.no_gauge && algorithm != Algorithm::Raycast;
    let mut settings = settings(&arguments.method, arguments.effects.effects);
    settings.eye.gauge = gauged;
    let (memory, size) = (arguments.scene.memory(), scene.camera().size());
    let pictures = if gauged { check_gauged(size, memory.free()) } else { check_pictures(1, size, memory.free()) };
    let pictures = pictures.map_err(|e| Failure::new(Exit::Usage, e))?;
    let integrator = algorithm.prepare(&scene, settings);
    check_photons(integrator.expected(), pictures, memory.free()).map_err(|e| Failure::new(Exit::Usage, e))?;
    plan::announce(integrator.as_ref(), progress);
    setting.radii = integrator.radii();
    setting.emission = integrator.guiding_reports();
    setting.effects = plan::effects(integrator.plan());
    setting.balance = integrator.balance();
    setting.setup = start.elapsed().as_secs_f64();

    let passes = arguments.passes.or(match (arguments.time, arguments.target_error) {
        (None, None) => Some(algorithm.passes()),
        // One pass of ray casting is all there is to it.
        _ if algorithm == Algorithm::Raycast => Some(algorithm.passes()),
        _ => None,
    });
    let target = arguments.target_error.map(|error| Target { error, confidence: arguments.confidence });
    let stop = Stop { at_least: 1, passes, time: arguments.time, target, interrupted: &INTERRUPTED };
    progress.pass(1, passes);
    let began = Instant::now();
    let rendered = render(integrator.as_ref(), scene.camera().size(), &stop, progress, |standing| {
        let made = standing.passes;
        let a_pass = began.elapsed().as_secs_f64() / f64::from(made);
        let error = standing.error.as_ref().filter(|_| !arguments.quiet).map(|(reading, forecast)| {
            // A target is reached when the upper end of the interval is.
            let aim = target.map(|target| (target.error, target.error * reading.error / reading.high));
            let (named, aim) = aim.unwrap_or((0.5 * reading.error, 0.5 * reading.error));
            let outlook = error::outlook(reading, forecast, (named, aim), a_pass);
            format!("error {}{outlook}", error::parts(reading))
        });
        if matches!(progress, Progress::Lines) {
            let of = passes.map_or(String::new(), |n| format!("/{n}"));
            let error = error.as_ref().map_or(String::new(), |error| format!(": {error}"));
            progress.say(&format!("pass {made}{of} after {:.1} s{error}", start.elapsed().as_secs_f64()));
        }
        progress.pass(made + 1, passes);
        error.into_iter().for_each(|note| progress.note(note));
    });
    progress.finish();
    conclude(arguments, progress, setting, powerless, &rendered)
}

/// Writes the pictures and the report, and says what was done.
fn conclude(
    arguments: &RenderArguments,
    progress: &Progress,
    setting: Setting,
    powerless: bool,
    rendered: &Rendered,
) -> Result<Exit, Failure> {
    let output = |e: miette::Report| Failure::new(Exit::Output, e);
    let (width, height) = rendered.film.size();
    let picture = Image::from_pixels(width, height, rendered.film.mean()).into_diagnostic().map_err(output)?;
    let curve = arguments.tone.unwrap_or(match arguments.method.integrator {
        Algorithm::Raycast => Curve::Course,
        _ => Curve::Srgb,
    });
    let options = WriteOptions {
        tone: ToneMap { curve, exposure_stops: arguments.exposure },
        depth: arguments.png_bits,
        floats: arguments.exr_bits,
        metadata: vec![("Software".to_owned(), format!("Caustica {}", env!("CARGO_PKG_VERSION")))],
    };
    for path in &arguments.output {
        let written = image::write(path, &picture, &options).into_diagnostic().map_err(output)?;
        progress.say(&format!("wrote {}", path.display()));
        tell_of(&written, path, arguments.exposure, progress);
    }
    if let Some(path) = &arguments.aov {
        let layers = aov::layers(rendered);
        if rendered.film.passes() < FEWEST {
            let passes = counted(rendered.film.passes() as usize, "pass tells", "passes tell");
            tell(&format!("warning: {passes} no error: {} has no maps of it", path.display()));
        }
        let written = image::write_layers(path, (width, height), &layers, &options.metadata);
        let non_finite = written.into_diagnostic().map_err(output)?;
        progress.say(&format!("wrote {}", path.display()));
        if non_finite > 0 {
            let values = counted(non_finite, "value", "values");
            tell(&format!("warning: {values} of {} beyond single precision: the scene is too bright", path.display()));
        }
    }
    tell_of_rejected(&rendered.counters);
    if picture.pixels().iter().all(|p| *p == Vec3::ZERO) {
        progress.say(dark::black(setting.lights, powerless));
    }
    without_photons(rendered).iter().for_each(|line| progress.say(line));
    let report = Report::new(setting, rendered, confidence(arguments));
    let why = match rendered.ended {
        Ended::Passes => String::new(),
        Ended::Time => format!("; time was up: --passes {} repeats this picture bit for bit", rendered.film.passes()),
        Ended::Target => {
            format!("; the error is low enough: --passes {} repeats this picture", rendered.film.passes())
        }
        Ended::Floor => "; the error cannot become as low".to_owned(),
        Ended::Interrupted => format!("; interrupted: --passes {} repeats this picture", rendered.film.passes()),
    };
    progress.say(&format!(
        "{} in {:.1} s, {:.2} M rays/s, {:.2} M photon paths/s{why}",
        counted(report.passes as usize, "pass", "passes"),
        report.seconds.render,
        report.rates.rays_per_second * 1e-6,
        report.rates.photons_per_second * 1e-6,
    ));
    if let Some(ErrorReport { reading, .. }) = &report.error {
        let interval = format!("{} to {}", percent(reading.low), percent(reading.high));
        let sure = percent(confidence(arguments).part());
        progress.say(&format!("error {}; {interval} with {sure} confidence", error::parts(reading)));
    }
    if rendered.ended == Ended::Floor {
        tell(&format!("warning: {}", error::REMEDY));
    }
    if let Some(path) = &arguments.stats {
        let json = serde_json::to_vec_pretty(&report).into_diagnostic().map_err(output)?;
        image::replace_file(path, &json).into_diagnostic().map_err(output)?;
    }
    Ok(if rendered.ended == Ended::Interrupted { Exit::Interrupted } else { Exit::Success })
}

/// Says what a file could not hold.
fn tell_of(written: &WriteReport, path: &Path, exposure: f32, progress: &Progress) {
    let pixels = |n: usize| format!("{} of {}", counted(n, "pixel", "pixels"), path.display());
    if written.non_finite > 0 {
        tell(&format!("warning: {}: not finite", pixels(written.non_finite)));
    }
    match (written.too_bright, OutputFormat::from_path(path)) {
        (0, _) => {}
        // Its users count on radiances as they are.
        (n, Ok(OutputFormat::Exr)) => {
            tell(&format!("warning: {}: beyond 65504, cut off there; --exr-bits 32 holds them", pixels(n)));
        }
        (n, _) => {
            let darker = exposure - 1.0;
            let remedy = format!("--exposure {darker} or --tone filmic shows more, an .exr file holds all");
            progress.say(&format!("note: {}: brighter than white, cut off there; {remedy}", pixels(n)));
        }
    }
    if written.negative > 0 {
        progress.say(&format!("note: {}: below black, cut off there", pixels(written.negative)));
    }
}

/// Of the intervals that are told.
fn confidence(arguments: &RenderArguments) -> Confidence {
    let target = |error| Target { error, confidence: arguments.confidence };
    arguments.target_error.map_or(arguments.confidence, |error| target(error).interval())
}
