//! How well a pilot of eight passes foretells the time to an error: against another seed's render that does it.
//!
//! ```sh
//! cargo run --release --example forecasts -- [METHOD] [SCENE …]
//! ```
//!
//! Times are of the processor, without setting up; a render ends by its own gauge, at the first pass whose error is no more than asked for.

use caustica::format::SceneFile;
use caustica::integrate::{Algorithm, Settings, Silent};
use caustica::render::gauge::{Confidence, Needed};
use caustica::render::{Rendered, Stop, Target, render};
use caustica::scene::Scene;
use caustica::stats::cpu_seconds;
use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const SCENES: [&str; 5] = ["matte", "ball-lens", "ring", "mirror-caustic", "many-lights"];
const SIZE: (u32, u32) = (80, 60);
const PILOT: u32 = 8;
const ERRORS: [f64; 3] = [0.05, 0.02, 0.01];

fn scene(name: &str) -> Result<Scene, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.txt"));
    let mut file = SceneFile::read(&path)?;
    let camera = &mut file.description.camera.value;
    (camera.width, camera.height) = SIZE;
    Ok(file.resolve()?)
}

/// A render, and the processor seconds of its passes.
fn rendered(scene: &Scene, algorithm: Algorithm, seed: u64, stop: &Stop<'_>) -> (Rendered, f64) {
    let mut settings = Settings { photons: 20_000, caustic_photons: 10_000, balance: false, ..Settings::default() };
    (settings.eye.seed, settings.eye.gauge) = (seed, true);
    let integrator = algorithm.prepare(scene, settings);
    let start = cpu_seconds().unwrap_or(0.0);
    let rendered = render(integrator.as_ref(), SIZE, stop, true, &Silent, |_| {});
    (rendered, cpu_seconds().unwrap_or(0.0) - start)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let named = |word: &String| Algorithm::ALL.into_iter().find(|a| a.name() == word);
    let algorithm = words.first().and_then(named).inspect(|_| drop(words.remove(0))).unwrap_or(Algorithm::Hybrid);
    if words.is_empty() {
        words = SCENES.map(str::to_owned).to_vec();
    }
    println!("| scene, {} | error | foretold | passes | it took | passes | foretold / taken |", algorithm.name());
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for name in &words {
        let scene = scene(name)?;
        let interrupted = AtomicBool::new(false);
        let pilot = Stop { at_least: 1, passes: Some(PILOT), time: None, target: None, interrupted: &interrupted };
        let (made, seconds) = rendered(&scene, algorithm, 1, &pilot);
        let gauge = made.gauge.as_ref().ok_or("no gauge")?;
        let forecast = gauge.forecast(&gauge.read(&made.film)).ok_or("no forecast")?;
        for error in ERRORS {
            let Needed::Passes(passes) = forecast.passes_to(error) else {
                println!("| {name} | {:.0} % | never | | | | |", 100.0 * error);
                continue;
            };
            let target = Some(Target { error, confidence: Confidence::new(0.5).ok_or("half is a part")? });
            let (done, taken) = rendered(&scene, algorithm, 2, &Stop { passes: Some(20_000), target, ..pilot });
            let foretold = seconds / f64::from(PILOT) * f64::from(passes);
            println!(
                "| {name} | {:.0} % | {foretold:.1} s | {passes} | {taken:.1} s | {} | {:.2} |",
                100.0 * error,
                done.film.passes(),
                foretold / taken
            );
        }
    }
    Ok(())
}
