//! Compares forecasts of a pilot of eight passes with the render that continues it.
//!
//! Times are processor times without preparation. A render ends by its own error estimate, at the
//! first pass that reaches the target.

use super::{SIZE, scene, settings};
use caustica::integrate::{Algorithm, SilentMonitor};
use caustica::render::error_estimate::{Confidence, PassesNeeded};
use caustica::render::{ErrorTarget, RenderResult, StopCriteria, render};
use caustica::scene::Scene;
use caustica::stats::cpu_seconds;
use std::error::Error;
use std::sync::atomic::AtomicBool;

const PILOT: u32 = 8;

/// Renders and returns the film with the processor time of its passes \[s].
fn rendered(scene: &Scene, algorithm: Algorithm, seed: u64, stop: &StopCriteria<'_>) -> (RenderResult, f64) {
    let mut settings = settings(seed);
    settings.camera_paths.estimate_error = true;
    let integrator = algorithm.prepare(scene, settings);
    let start = cpu_seconds().unwrap_or(0.0);
    let rendered = render(integrator.as_ref(), SIZE, stop, &SilentMonitor, |_| {});
    (rendered, cpu_seconds().unwrap_or(0.0) - start)
}

/// Prints forecast and actual time by scene, method, seed and error.
pub fn print(scenes: &[String], methods: &[Algorithm], errors: &[f64], seeds: u64) -> Result<(), Box<dyn Error>> {
    println!("| scene | method | seed | error | foretold | passes | it took | passes | foretold / taken |");
    println!("|{}", " --- |".repeat(9));
    for name in scenes {
        let scene = scene(name)?;
        for (method, seed) in methods.iter().flat_map(|method| (0..seeds).map(move |seed| (*method, seed))) {
            let interrupted = AtomicBool::new(false);
            let pilot = StopCriteria { passes: Some(PILOT), ..StopCriteria::unlimited(&interrupted) };
            let (made, seconds) = rendered(&scene, method, seed, &pilot);
            let estimator = made.estimator.as_ref().ok_or("no error estimator")?;
            let forecast = estimator.forecast(&estimator.estimate(&made.film)).ok_or("no forecast")?;
            for error in errors {
                let row = format!("| {name} | {} | {seed} | {:.1} %", method.name(), 100.0 * error);
                let PassesNeeded::Passes(passes) = forecast.passes_to_reach(*error) else {
                    println!("{row} | {:?} | | | | |", forecast.passes_to_reach(*error));
                    continue;
                };
                let target =
                    Some(ErrorTarget { error: *error, confidence: Confidence::new(0.5).ok_or("half is a part")? });
                let (done, taken) =
                    rendered(&scene, method, seed, &StopCriteria { passes: Some(2000), target, ..pilot });
                let foretold = seconds / f64::from(PILOT) * f64::from(passes);
                let (took, ratio) = (done.film.passes(), foretold / taken);
                println!("{row} | {foretold:.1} s | {passes} | {taken:.1} s | {took} | {ratio:.2} |");
            }
        }
    }
    Ok(())
}
