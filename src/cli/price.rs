//! `caustica price`.

use super::error::{NoError, seconds};
use super::interrupt::{INTERRUPTED, listen};
use super::memory::{check_gauged, check_photons};
use super::plan::announce;
use super::progress::Progress;
use super::scene::{in_pool, load};
use super::settings::{flags, settings};
use super::{Exit, Failure, PriceArguments, error};
use crate::integrate::{Algorithm, Integrator};
use crate::render::error_estimate::{ErrorEstimate, Forecast, PassesNeeded};
use crate::render::{Rendered, StopCriteria, render};
use crate::stats::peak_memory;
use crate::study::text::{amount, percent};
use miette::IntoDiagnostic;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

/// Passes that a pilot makes whatever they take: fewer know little of what is rare.
const LEAST_PASSES: u32 = 8;

/// A pilot that was ended before it knew anything.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the pilot ended after {passes} passes, from which no error can be told")]
#[diagnostic(help("let it make four passes at least"))]
struct TooShort {
    passes: u32,
}

pub(super) fn run(arguments: &PriceArguments) -> Result<Exit, Failure> {
    if arguments.method.integrator == Algorithm::Raycast {
        return Err(Failure::new(Exit::Usage, NoError { flag: "price" }));
    }
    listen("what the pilot found");
    let progress = Progress::new(arguments.quiet);
    in_pool(&arguments.scene, || {
        let start = Instant::now();
        let scene = load(&arguments.scene, &progress)?;
        let algorithm = arguments.method.integrator;
        let mut settings = settings(&arguments.method, arguments.effects.effects);
        settings.eye.gauge = true;
        let memory = arguments.scene.memory();
        let pictures = check_gauged(scene.camera().size(), memory.free()).map_err(|e| Failure::new(Exit::Usage, e))?;
        let integrator = algorithm.prepare(&scene, settings);
        check_photons(integrator.expected(), pictures, memory.free()).map_err(|e| Failure::new(Exit::Usage, e))?;
        announce(integrator.as_ref(), &progress);
        let setup = start.elapsed().as_secs_f64();
        let (rendered, a_pass) = pilot(arguments, integrator.as_ref(), scene.camera().size(), &progress);
        let list = List::new(arguments, algorithm, &rendered, setup, a_pass);
        let list = list.map_err(|e| Failure::new(Exit::Interrupted, e))?;
        let text = if arguments.json {
            let json = serde_json::to_string_pretty(&list);
            json.into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))? + "\n"
        } else {
            list.table()
        };
        let written = std::io::stdout().write_all(text.as_bytes());
        written.into_diagnostic().map_err(|e| Failure::new(Exit::Output, e))?;
        let interrupted = INTERRUPTED.load(std::sync::atomic::Ordering::Relaxed);
        Ok(if interrupted { Exit::Interrupted } else { Exit::Success })
    })
}

/// Renders for as long as the pilot may, and tells the seconds that a pass takes from then on.
fn pilot(
    arguments: &PriceArguments,
    integrator: &dyn Integrator,
    size: (u32, u32),
    progress: &Progress,
) -> (Rendered, f64) {
    let stop = StopCriteria {
        min_passes: LEAST_PASSES,
        time: Some(arguments.pilot),
        passes: None,
        target: None,
        interrupted: &INTERRUPTED,
    };
    let (began, mut first) = (Instant::now(), 0.0);
    progress.pass(1, None);
    let rendered = render(integrator, size, &stop, progress, |standing| {
        if standing.passes == 1 {
            first = began.elapsed().as_secs_f64();
        }
        progress.pass(standing.passes + 1, None);
    });
    progress.finish();
    // The first pass warms caches up.
    let (passes, wall) = (rendered.film.passes(), rendered.wall.as_secs_f64());
    let a_pass = if passes > 2 { (wall - first) / f64::from(passes - 1) } else { wall / f64::from(passes) };
    (rendered, a_pass)
}

/// What errors cost, after a pilot.
#[derive(Debug, Serialize)]
struct List {
    schema: u32,
    version: &'static str,
    scene: String,
    integrator: &'static str,
    width: u32,
    height: u32,
    threads: usize,
    /// Of the pilot's picture.
    pilot: ErrorEstimate,
    setup_seconds: f64,
    pass_seconds: f64,
    pass_photons: f64,
    peak_memory_bytes: Option<u64>,
    prices: Vec<Price>,
}

/// What an error costs.
#[derive(Debug, Serialize)]
struct Price {
    error: f64,
    /// `None` where no number of passes gives it.
    passes: Option<u32>,
    /// Setting up and passes \[s].
    seconds: Option<f64>,
    /// From the ends of the interval in which the pilot's error lies \[s].
    seconds_low: Option<f64>,
    seconds_high: Option<f64>,
    photons: Option<f64>,
    /// What is left where the error cannot be had.
    floor: Option<f64>,
    flags: Option<String>,
}

impl List {
    fn new(
        arguments: &PriceArguments,
        algorithm: Algorithm,
        rendered: &Rendered,
        setup: f64,
        a_pass: f64,
    ) -> Result<Self, TooShort> {
        let passes = rendered.film.passes();
        let reading = rendered.estimator.as_ref().map(|gauge| gauge.estimate(&rendered.film)).unwrap_or_default();
        let forecast = rendered.estimator.as_ref().and_then(|gauge| gauge.forecast(&reading));
        let forecast = forecast.ok_or(TooShort { passes })?;
        let pass_photons = (rendered.global.emitted + rendered.caustic.emitted) as f64 / f64::from(passes);
        let mut words = flags(&arguments.method, "--effects", arguments.effects.effects);
        if arguments.method.seed != 0 {
            words.extend(["--seed".to_owned(), arguments.method.seed.to_string()]);
        }
        if let Some((width, height)) = arguments.scene.size {
            words.extend(["--size".to_owned(), format!("{width}x{height}")]);
        }
        let words = words.join(" ");
        let price = |error: &f64| {
            let price = Price::new(*error, &reading, &forecast, (setup, a_pass, pass_photons));
            Price { flags: price.passes.map(|n| format!("{words} --passes {n}")), ..price }
        };
        let (width, height) = rendered.film.size();
        Ok(Self {
            schema: 1,
            version: env!("CARGO_PKG_VERSION"),
            scene: arguments.scene.scene.display().to_string(),
            integrator: algorithm.name(),
            width,
            height,
            threads: rayon::current_num_threads(),
            pilot: reading,
            setup_seconds: setup,
            pass_seconds: a_pass,
            pass_photons,
            peak_memory_bytes: peak_memory(),
            prices: arguments.errors.iter().map(price).collect(),
        })
    }

    fn table(&self) -> String {
        let Self { pilot, peak_memory_bytes, .. } = self;
        let memory = peak_memory_bytes.map_or("?".to_owned(), |bytes| format!("{}B", amount(bytes as f64)));
        let mut text = format!(
            "{} at {} × {}: after {} passes the error is {}\n",
            self.integrator,
            self.width,
            self.height,
            pilot.passes,
            error::parts(pilot)
        );
        let _ = writeln!(
            text,
            "  {:>7} {:>9} {:>14} {:>24} {:>9} {:>8}  to be had by",
            "error", "passes", "time", "likely", "photons", "memory"
        );
        for price in &self.prices {
            let error = percent(price.error);
            let (Some(passes), Some(time)) = (price.passes, price.seconds) else {
                let why = match price.floor {
                    Some(floor) => format!("never: {} is bias that stays; {}", percent(floor), error::REMEDY),
                    None => "more than ten million passes".to_owned(),
                };
                let _ = writeln!(text, "  {error:>7} {why}");
                continue;
            };
            let ends = [price.seconds_low, price.seconds_high].map(|t| t.map_or("?".to_owned(), seconds));
            let _ = writeln!(
                text,
                "  {error:>7} {passes:>9} {:>14} {:>24} {:>9} {memory:>8}  {}",
                seconds(time),
                ends.join(" to "),
                price.photons.map_or(String::new(), amount),
                price.flags.as_deref().unwrap_or_default(),
            );
        }
        text
    }
}

impl Price {
    fn new(
        error: f64,
        reading: &ErrorEstimate,
        forecast: &Forecast,
        (setup, a_pass, pass_photons): (f64, f64, f64),
    ) -> Self {
        let needed = |aim: f64| match forecast.passes_to(aim) {
            PassesNeeded::Passes(n) => Ok(n),
            PassesNeeded::Never { floor } => Err(Some(floor)),
            PassesNeeded::TooMany => Err(None),
        };
        let time = |n: u32| setup + a_pass * f64::from(n);
        // Were the pilot's error larger than it seems, less of it would be asked for. What has no error has it for nothing.
        let at = |end: f64| if end > 0.0 { needed(error * reading.error / end).ok().map(time) } else { Some(time(1)) };
        let (passes, floor) = match needed(error) {
            Ok(n) => (Some(n), None),
            Err(floor) => (None, floor),
        };
        Self {
            error,
            passes,
            seconds: passes.map(time),
            seconds_low: passes.and_then(|_| at(reading.low)),
            seconds_high: passes.and_then(|_| at(reading.high)),
            photons: passes.map(|n| f64::from(n) * pass_photons),
            floor,
            flags: None,
        }
    }
}
