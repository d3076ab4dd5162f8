//! Calibration of the error estimator: estimated over true error, by scene, method and passes.
//!
//! ```sh
//! cargo run --release --example calibration -- [SCENE …] [--methods M,…] [--passes N,…]
//!     [--seeds N] [--truth PASSES] [--targets ERROR,…] [--forecasts ERROR,…]
//! ```
//!
//! The truth comes from two long renders A and B by `hybrid` with a tenth of the radius.
//! E[(I − A)(I − B)] is the squared error of an image I, although A and B are noisy. `path` is left
//! out of scenes with caustics: it finds them rarely, and its passes cannot know what they miss.
//!
//! `--targets` compares the true error of renders that end by `--target-error`, at the default
//! confidence. `--forecasts` compares forecasts with the passes that follow.

mod forecasts;

use caustica::format::SceneFile;
use caustica::image::RelativeErrorWeights;
use caustica::integrate::{Algorithm, FinalGathering, IndirectPhotons, Settings, SilentMonitor};
use caustica::plan::{Effect, EffectOverrides, Plan};
use caustica::render::error_estimate::{Confidence, ErrorEstimator};
use caustica::render::{ErrorTarget, Film, StopCriteria, render};
use caustica::scene::Scene;
use glam::Vec3;
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const SCENES: [&str; 6] = ["matte", "ball-lens", "ring", "many-lights", "mirror-caustic", "frosted"];
const SIZE: (u32, u32) = (80, 60);
const PHOTONS: u32 = 20_000;

struct Arguments {
    scenes: Vec<String>,
    methods: Vec<String>,
    passes: Vec<u32>,
    seeds: u64,
    truth: u32,
    targets: Vec<f64>,
    forecasts: Vec<f64>,
}

fn arguments() -> Result<Arguments, Box<dyn Error>> {
    let list = |text: &str| text.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut arguments = Arguments {
        scenes: Vec::new(),
        methods: list("path,hybrid,sppm,ppm,pm"),
        passes: vec![4, 8, 16],
        seeds: 8,
        truth: 120,
        targets: Vec::new(),
        forecasts: Vec::new(),
    };
    let errors = |text: &str| text.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        match word.as_str() {
            "--methods" => arguments.methods = list(&value()?),
            "--passes" => arguments.passes = list(&value()?).iter().map(|n| n.parse()).collect::<Result<_, _>>()?,
            "--seeds" => arguments.seeds = value()?.parse()?,
            "--targets" => arguments.targets = errors(&value()?)?,
            "--forecasts" => arguments.forecasts = errors(&value()?)?,
            "--truth" => arguments.truth = value()?.parse()?,
            _ => arguments.scenes.push(word),
        }
    }
    if arguments.scenes.is_empty() {
        arguments.scenes = SCENES.map(str::to_owned).to_vec();
    }
    Ok(arguments)
}

fn scene(name: &str) -> Result<Scene, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.txt"));
    let mut file = SceneFile::read(&path)?;
    let camera = &mut file.description.camera.value;
    (camera.width, camera.height) = SIZE;
    Ok(file.resolve()?)
}

fn settings(seed: u64) -> Settings {
    let mut settings = Settings {
        photons: PHOTONS,
        caustic_photons: PHOTONS / 2,
        balance: false,
        final_gathering: FinalGathering::None,
        ..Settings::default()
    };
    settings.camera_paths.seed = seed;
    settings
}

/// Returns the mean of many passes with a small, constant radius.
fn reference(scene: &Scene, seed: u64, passes: u32) -> Vec<Vec3> {
    let mut settings = settings(seed);
    let radii = Algorithm::Hybrid.prepare(scene, settings.clone()).gather_radii();
    settings.radius = radii.map(|radii| radii.caustic / 10.0);
    (settings.alpha, settings.gather_k) = (1.0, Some(0));
    // Camera paths find indirect light without bias.
    settings.indirect_photons = IndirectPhotons::Off;
    (settings.photons, settings.caustic_photons) = (4 * PHOTONS, 4 * PHOTONS);
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { passes: Some(passes), ..StopCriteria::unlimited(&interrupted) };
    let integrator = Algorithm::Hybrid.prepare(scene, settings);
    render(integrator.as_ref(), SIZE, &stop, &SilentMonitor, |_| {}).film.mean()
}

/// Renders until the estimated error reaches the target, and returns the true error.
fn stopped(name: &str, scene: &Scene, algorithm: Algorithm, error: f64, seeds: u64, square: &dyn Fn(&[Vec3]) -> f64) {
    let target = Some(ErrorTarget { error, confidence: Confidence::default() });
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { target, ..StopCriteria::unlimited(&interrupted) };
    let (mut passes, mut errors) = (0, Vec::new());
    for seed in 0..seeds {
        let mut settings = settings(seed);
        settings.camera_paths.estimate_error = true;
        let integrator = algorithm.prepare(scene, settings);
        let rendered = render(integrator.as_ref(), SIZE, &stop, &SilentMonitor, |_| {});
        passes += rendered.film.passes();
        errors.push(square(&rendered.film.mean()).max(0.0).sqrt());
    }
    println!(
        "| {name} | {} | {:.0} % | {:.0} | {:.2} % ({:.2} %) | {}/{seeds} |",
        algorithm.name(),
        100.0 * error,
        f64::from(passes) / seeds as f64,
        100.0 * errors.iter().sum::<f64>() / seeds as f64,
        100.0 * errors.iter().copied().fold(0.0, f64::max),
        errors.iter().filter(|e| **e <= error).count(),
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = arguments()?;
    let named = |name: &String| Algorithm::ALL.into_iter().find(|a| a.name() == name).ok_or("no such method");
    let methods = arguments.methods.iter().map(named).collect::<Result<Vec<Algorithm>, _>>()?;
    if !arguments.forecasts.is_empty() {
        return forecasts::print(&arguments.scenes, &methods, &arguments.forecasts, arguments.seeds);
    }
    let columns: &[&str] = if arguments.targets.is_empty() {
        &[
            "scene",
            "method",
            "passes",
            "true error",
            "noise",
            "bias",
            "estimated / true, mean (least to most)",
            "intervals that hold",
        ]
    } else {
        &["scene", "method", "target", "passes, mean", "true error, mean (most)", "runs at most the target"]
    };
    println!("| {} |\n|{}", columns.join(" | "), " --- |".repeat(columns.len()));
    for name in &arguments.scenes {
        let scene = scene(name)?;
        let [a, b] = [1u64, 2].map(|i| reference(&scene, i << 40, arguments.truth));
        let truth: Vec<Vec3> = a.iter().zip(&b).map(|(a, b)| (*a + *b) * 0.5).collect();
        let scale = RelativeErrorWeights::from_pixels(SIZE, &truth);
        let apart = 0.5 * scale.mean(|i| (a[i] - b[i]).as_dvec3() * (a[i] - b[i]).as_dvec3()).sqrt();
        eprintln!("{name}: references known to {:.2} % but for their bias", 100.0 * apart);
        for algorithm in methods.iter().copied() {
            let wanted = Plan::new(&scene, algorithm.supported_effects(), EffectOverrides::PLANNED).simulated_effects();
            if algorithm == Algorithm::Path && wanted.has(Effect::Caustics) {
                continue;
            }
            let square = |mean: &[Vec3]| scale.mean(|i| (mean[i] - a[i]).as_dvec3() * (mean[i] - b[i]).as_dvec3());
            if !arguments.targets.is_empty() {
                for error in &arguments.targets {
                    stopped(name, &scene, algorithm, *error, arguments.seeds, &square);
                }
                continue;
            }
            let mut rows = vec![Vec::new(); arguments.passes.len()];
            for seed in 0..arguments.seeds {
                let mut settings = settings(seed);
                settings.camera_paths.estimate_error = true;
                let integrator = algorithm.prepare(&scene, settings);
                let (mut film, mut estimator) =
                    (Film::new(SIZE.0, SIZE.1), ErrorEstimator::new(integrator.radius_law()));
                for pass in 0..*arguments.passes.iter().max().ok_or("no passes")? {
                    let made = integrator.render_pass(pass, &SilentMonitor);
                    estimator.add(pass, &made);
                    film.add(&made.image);
                    let Some(at) = arguments.passes.iter().position(|n| *n == pass + 1) else { continue };
                    rows[at].push((estimator.estimate(&film), square(&film.mean()).max(0.0).sqrt()));
                }
            }
            for (passes, row) in arguments.passes.iter().zip(&rows) {
                let n = row.len() as f64;
                let mean = |of: &dyn Fn(usize) -> f64| (0..row.len()).map(of).sum::<f64>() / n;
                let ratios: Vec<f64> = row.iter().map(|(estimate, error)| estimate.error / error).collect();
                let held =
                    row.iter().filter(|(estimate, error)| estimate.low <= *error && *error <= estimate.high).count();
                println!(
                    "| {name} | {} | {passes} | {:.2} % | {:.2} % | {:.2} % | {:.2} ({:.2} to {:.2}) | {held}/{} |",
                    algorithm.name(),
                    100.0 * mean(&|i| row[i].1),
                    100.0 * mean(&|i| row[i].0.noise),
                    100.0 * mean(&|i| row[i].0.bias),
                    mean(&|i| ratios[i]),
                    ratios.iter().copied().fold(f64::INFINITY, f64::min),
                    ratios.iter().copied().fold(0.0, f64::max),
                    row.len(),
                );
            }
        }
    }
    Ok(())
}
