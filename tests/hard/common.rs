//! Scenes, renders and statistics that the groups share.

use caustica::color::Rgb;
use caustica::format::{Source, parse, resolve};
use caustica::integrate::{Algorithm, Settings, Silent};
use caustica::sampling::{Key, Purpose};
use caustica::scene::Scene;
use std::f64::consts::PI;
use std::path::Path;

/// P(|T| ≥ t) for Student's T with `dof` degrees of freedom: with T = √ν tanφ its density is that of cosᵛ⁻¹φ, here by 4000 midpoints.
pub fn student(t: f64, dof: f64) -> f64 {
    let norm = libm::exp(libm::lgamma(0.5 * (dof + 1.0)) - libm::lgamma(0.5 * dof)) / PI.sqrt();
    let start = libm::atan(t.abs() / dof.sqrt());
    let step = (0.5 * PI - start) / 4000.0;
    let density = |i: u32| libm::pow(libm::cos(start + (f64::from(i) + 0.5) * step).max(0.0), dof - 1.0);
    2.0 * norm * (0..4000).map(density).sum::<f64>() * step
}

/// Mean of samples and its standard error.
pub fn mean_and_error(samples: &[f64]) -> (f64, f64) {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let squares: f64 = samples.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// Fails where independent `samples` contradict a mean of `expected`, known within `slack`, at a false-alarm rate of 10⁻⁶, two-sided; or
/// where their standard error is above the part `sharp` of what is expected, so that the test would see too little.
#[track_caller]
pub fn agree(what: &str, samples: &[f64], expected: f64, slack: f64, sharp: f64) {
    let (mean, error) = mean_and_error(samples);
    let excess = ((mean - expected).abs() - slack).max(0.0);
    let p = if excess == 0.0 { 1.0 } else { student(excess / error, samples.len() as f64 - 1.0) };
    let line = format!("{what}: {mean:.6e} ± {error:.1e}, expected {expected:.6e} (p = {p:.1e})");
    eprintln!("{line}");
    assert!(p >= 1e-6, "{line}");
    assert!(error <= sharp * expected.abs(), "{line}: too blunt");
}

/// The scene that `text` describes; meshes are those of tests/scenes.
#[track_caller]
pub fn scene(text: &str) -> Scene {
    let source = Source::new("test", text);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    let resolved = parse("test", text).and_then(|d| resolve(&d, &source, &folder));
    resolved.unwrap_or_else(|e| panic!("{e:?}\n{text}"))
}

/// The pixels of passes 0 .. `passes`, one picture after the other.
pub fn pixels(scene: &Scene, algorithm: Algorithm, settings: Settings, passes: u32) -> Vec<Rgb> {
    let prepared = algorithm.prepare(scene, settings);
    (0..passes).flat_map(|i| prepared.pass(i, &Silent).image).collect()
}

/// A key of test `name`.
pub fn key(name: u64) -> Key {
    Key::new(name).purpose(Purpose::Test)
}
