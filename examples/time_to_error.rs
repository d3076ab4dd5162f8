//! Error against processor and wall time, for every integrator, on the reference room:
//!
//! ```sh
//! cargo run --release --example time_to_error -- [BUDGET SECONDS] [INTEGRATOR …]
//! ```
//!
//! The error is the mean over pixels and channels of (ours − reference)² / (reference² + .01),
//! clipped at 10 per pixel. Integrators take turns, one pass each, so that a busy machine affects
//! all alike. Preparation counts.

use caustica::camera::{Filter, FilterKind};
use caustica::format::SceneFile;
use caustica::image::{self, Image, metrics};
use caustica::integrate::{Algorithm, CameraPathSettings, FinalGathering, Integrator, Settings, SilentMonitor};
use caustica::render::Film;
use caustica::scene::Scene;
use caustica::stats::cpu_seconds;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// Target error.
const TARGET: f64 = 0.005;

/// Progress of an integrator.
struct Run<'a> {
    name: &'a str,
    integrator: Box<dyn Integrator + 'a>,
    film: Film,
    cpu: f64,
    wall: f64,
    /// Processor time \[s] at which the next line is printed.
    next: f64,
    reached: Option<(f64, f64)>,
}

/// Returns the integrator of a name. The suffix `-even` switches off work division by a pilot,
/// `-adaptive` makes camera rays follow noise.
fn integrator<'a>(name: &str, scene: &'a Scene) -> Option<Box<dyn Integrator + 'a>> {
    // The reference has a box filter.
    let (name, adaptive) = name.strip_suffix("-adaptive").map_or((name, false), |name| (name, true));
    let camera_paths =
        CameraPathSettings { filter: Filter::new(FilterKind::Box), adaptive, ..CameraPathSettings::default() };
    let (word, balance) = name.strip_suffix("-even").map_or((name, true), |word| (word, false));
    let (algorithm, final_gathering) = match word {
        "pm-direct" => (Algorithm::Pm, FinalGathering::None),
        "pm-importance" => (Algorithm::Pm, FinalGathering::Importance),
        _ => (Algorithm::ALL.into_iter().find(|a| a.name() == word)?, FinalGathering::default()),
    };
    let settings =
        Settings { camera_paths, allows_ray_photon_balance: balance, final_gathering, ..Settings::default() };
    Some(algorithm.prepare(scene, settings))
}

/// Runs `work` and returns its result with its processor and wall time \[s].
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64, f64) {
    let (cpu, wall) = (cpu_seconds().unwrap_or(0.0), Instant::now());
    let made = work();
    (made, cpu_seconds().unwrap_or(0.0) - cpu, wall.elapsed().as_secs_f64())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let budget = words.first().and_then(|w| w.parse().ok()).inspect(|_: &f64| drop(words.remove(0))).unwrap_or(60.0);
    if words.is_empty() {
        words = ["hybrid", "path", "sppm", "ppm", "pm", "pm-direct"].map(str::to_owned).to_vec();
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let reference = image::read(&root.join("tests/data/cbox-caustic.exr"))?;
    let mut file = SceneFile::read(&root.join("tests/scenes/cbox-caustic.txt")).map_err(|e| format!("{e:?}"))?;
    let size = (reference.width(), reference.height());
    (file.description.camera.value.width, file.description.camera.value.height) = size;
    let scene = file.resolve().map_err(|e| format!("{e:?}"))?;
    let (width, height) = size;

    let mut runs = Vec::new();
    for word in &words {
        let (made, cpu, wall) = timed(|| integrator(word, &scene));
        let integrator = made.ok_or_else(|| format!("`{word}` is no integrator of this comparison"))?;
        runs.push(Run { name: word, integrator, film: Film::new(width, height), cpu, wall, next: 1.0, reached: None });
    }
    println!("| integrator | passes | CPU s | wall s | error |\n| --- | --- | --- | --- | --- |");
    while runs.iter().any(|run| run.cpu < budget) {
        for run in runs.iter_mut().filter(|run| run.cpu < budget) {
            let (pass, cpu, wall) = timed(|| run.integrator.render_pass(run.film.passes(), &SilentMonitor));
            run.film.add(&pass.image);
            (run.cpu, run.wall) = (run.cpu + cpu, run.wall + wall);
            let picture = Image::from_pixels(width, height, run.film.mean_picture())?;
            let error = metrics::relative_mse(&picture, &reference, 0.01, Some(10.0))?;
            if error <= TARGET && run.reached.is_none() {
                run.reached = Some((run.cpu, run.wall));
            }
            if run.cpu >= run.next || run.cpu >= budget {
                println!("| {} | {} | {:.1} | {:.1} | {error:.5} |", run.name, run.film.passes(), run.cpu, run.wall);
                run.next = run.cpu * 2.0;
            }
        }
    }
    println!("\n| integrator | CPU s to {TARGET} | wall s |\n| --- | --- | --- |");
    for run in &runs {
        match run.reached {
            Some((cpu, wall)) => println!("| {} | {cpu:.1} | {wall:.1} |", run.name),
            None => println!("| {} | not within {budget} | |", run.name),
        }
    }
    Ok(())
}
