//! Error and cost of a render in shards, on the reference room:
//!
//! ```sh
//! cargo run --release --example sharding -- error [PHOTONS] [PASSES] [SHARDS] [SEED]
//! cargo run --release --example sharding -- cost [EDGE …]
//! ```
//!
//! `error` renders the room with one camera ray per pixel and few photons per pass, in shards that
//! share nothing but their film files. It compares the estimated error of the sum with the true
//! error against the reference picture of another renderer. `cost` measures the work that each
//! shard repeats, by the edge of the picture in pixels. Times are processor seconds of all threads.

use caustica::camera::{Filter, FilterKind};
use caustica::format::SceneFile;
use caustica::image::{self, RelativeErrorWeights};
use caustica::integrate::{Algorithm, Settings, SilentMonitor};
use caustica::render::{FilmFile, FilmHeader, RenderResult, StopCriteria, render};
use caustica::scene::Scene;
use caustica::stats::cpu_seconds;
use glam::DVec3;
use std::error::Error;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Edge of the reference picture \[pixels].
const REFERENCE_EDGE: u32 = 128;

/// Number of shards whose cost is stated.
const SHARDS: u32 = 64;

/// Number of passes whose cost is stated.
const PASSES: u32 = 1024;

/// Number of passes that are timed after the first one.
const TIMED_PASSES: u32 = 3;

/// Processor times of the parts of a render \[s].
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    load: f64,
    pilots: f64,
    passes: f64,
    films: f64,
}

impl Work {
    /// Returns the work of other parts relative to that of the passes.
    fn overhead(self) -> f64 {
        (self.load + self.pilots + self.films) / self.passes
    }
}

/// Runs `work`, and adds its processor time to `seconds`.
fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = cpu_seconds().unwrap_or(0.0);
    let made = work();
    *seconds += cpu_seconds().unwrap_or(0.0) - start;
    made
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests").join(name)
}

/// Loads the room with a picture of `edge` × `edge` pixels.
fn room(edge: u32) -> Result<Scene, Box<dyn Error>> {
    let mut file = SceneFile::read(&path("scenes/cbox-caustic.txt")).map_err(|e| format!("{e:?}"))?;
    (file.description.camera.value.width, file.description.camera.value.height) = (edge, edge);
    Ok(file.resolve().map_err(|e| format!("{e:?}"))?)
}

/// Returns default settings with error estimates and the pixel filter of the reference.
fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.camera_paths.estimate_error = true;
    settings.camera_paths.filter = Filter::new(FilterKind::Box);
    settings
}

/// Returns the film of shard `number`, counted from 0, as the bytes of a film file.
fn shard(settings: &Settings, passes: std::ops::Range<u32>, work: &mut Work) -> Result<Vec<u8>, Box<dyn Error>> {
    let size = (REFERENCE_EDGE, REFERENCE_EDGE);
    let scene = timed(&mut work.load, || room(REFERENCE_EDGE))?;
    let integrator = timed(&mut work.pilots, || Algorithm::Hybrid.prepare(&scene, settings.clone()));
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { max_passes: Some(passes.len() as u32), ..StopCriteria::unlimited(&interrupted) };
    let before = RenderResult::without_passes(integrator.as_ref(), size);
    let render_shard = || render(before, passes, integrator.as_ref(), &stop, &SilentMonitor, |_| {});
    let rendered = timed(&mut work.passes, render_shard);
    let header = FilmHeader {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        scene: "cbox-caustic".to_owned(),
        inputs: Vec::new(),
        width: size.0,
        height: size.1,
        settings: Vec::new(),
        seed: settings.camera_paths.seed,
        planned_passes: None,
    };
    let mut bytes = Vec::new();
    timed(&mut work.films, || FilmFile::write(&header, &rendered, &mut bytes))?;
    Ok(bytes)
}

/// Renders in shards, and prints estimated and true error.
fn compare_errors(photons: u32, passes: u32, shards: u32, seed: u64) -> Result<(), Box<dyn Error>> {
    let mut settings =
        Settings { unaimed_paths: photons, aimed_paths: photons / 2, allows_ray_photon_balance: false, ..settings() };
    settings.camera_paths.samples_per_pixel = Some(1);
    settings.camera_paths.seed = seed;
    let mut work = Work::default();
    let mut total: Option<RenderResult> = None;
    let size = passes / shards;
    for number in 0..shards {
        let bytes = shard(&settings, number * size..(number + 1) * size, &mut work)?;
        total = Some(timed(&mut work.films, || -> Result<_, Box<dyn Error>> {
            let film = FilmFile::read(&bytes[..])?.rendered;
            match total.take() {
                None => Ok(film),
                Some(mut total) => total.merge(&film).map(|()| total).map_err(Into::into),
            }
        })?);
    }
    let total = total.ok_or("there are no shards")?;
    let estimator = total.estimator.as_ref().ok_or("there is no error estimate")?;
    let estimate = estimator.estimate(&total.film);

    let reference = image::read(&path("data/cbox-caustic.exr"))?;
    let deviation = image::read(&path("data/cbox-caustic-stderr.exr"))?;
    let weights = RelativeErrorWeights::from_image(&reference);
    let pixels = total.film.mean_picture();
    // The expected square of the difference is the sum of both squared errors.
    let squared_deviation = |i: usize| deviation.pixels()[i].as_dvec3() * deviation.pixels()[i].as_dvec3();
    let noise = weights.mean_relative_squared_error(squared_deviation);
    let square = weights.mean_relative_squared_error(|i| -> DVec3 {
        let difference = (pixels[i] - reference.pixels()[i]).as_dvec3();
        difference * difference - squared_deviation(i)
    });
    println!("| passes | shards | estimated error | 90 % interval | true error | noise of the reference |");
    println!("| --- | --- | --- | --- | --- | --- |");
    let percent = |value: f64| format!("{:.2} %", 100.0 * value);
    println!(
        "| {} | {shards} | {} | {} to {} | {} | {} |",
        total.film.passes(),
        percent(estimate.error),
        percent(estimate.low),
        percent(estimate.high),
        percent(square.max(0.0).sqrt()),
        percent(noise.sqrt())
    );
    let Work { load, pilots, passes, films } = work;
    println!("\nCPU s: loading {load:.2}, pilots {pilots:.2}, passes {passes:.2}, films {films:.2}");
    println!("work beside the passes: {}", percent(work.overhead()));
    Ok(())
}

/// Prints the work that shards repeat, for a picture of each edge.
fn print_costs(edges: &[u32]) -> Result<(), Box<dyn Error>> {
    println!("| picture | load s | pilots s | pass s | {SHARDS} shards of {PASSES} passes | passes a shard for 5 % |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for &edge in edges {
        let mut work = Work::default();
        let scene = timed(&mut work.load, || room(edge))?;
        let integrator = timed(&mut work.pilots, || Algorithm::Hybrid.prepare(&scene, settings()));
        // The first pass fills caches.
        integrator.render_pass(0, &SilentMonitor);
        timed(&mut work.passes, || (1..=TIMED_PASSES).for_each(|i| drop(integrator.render_pass(i, &SilentMonitor))));
        let (repeated, pass) = (work.load + work.pilots, work.passes / f64::from(TIMED_PASSES));
        // One render repeats nothing.
        let added = f64::from(SHARDS - 1) * repeated / (repeated + f64::from(PASSES) * pass);
        println!(
            "| {edge} × {edge} | {:.3} | {:.2} | {pass:.3} | {:.1} % | {:.0} |",
            work.load,
            work.pilots,
            100.0 * added,
            (repeated / (0.05 * pass)).ceil()
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Vec<u32> = words.iter().skip(1).map(|word| word.parse()).collect::<Result<_, _>>()?;
    let number = |i: usize, default: u32| numbers.get(i).copied().unwrap_or(default);
    match words.first().map(String::as_str) {
        Some("error") => compare_errors(number(0, 1000), number(1, PASSES), number(2, SHARDS), number(3, 0).into()),
        Some("cost") if numbers.is_empty() => print_costs(&[64, 128, 256, 512]),
        Some("cost") => print_costs(&numbers),
        _ => Err("the first word is `error` or `cost`".into()),
    }
}
