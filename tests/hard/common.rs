//! Scenes, renders and statistics that the groups share.

#[path = "../statistics/mod.rs"]
mod statistics;

use caustica::color::Rgb;
use caustica::format::{Source, parse, resolve};
use caustica::integrate::{Algorithm, Integrator, Settings, Silent};
use caustica::sampling::{Key, Purpose};
use caustica::scene::Scene;
pub use statistics::*;
use std::path::Path;

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
    (0..passes).flat_map(|i| image(&*prepared, i)).collect()
}

/// The picture of a pass. Samples and photons that are not finite are left out and counted, so a picture is finite, or black, whatever went
/// wrong: there must have been none.
#[track_caller]
pub fn image(integrator: &dyn Integrator, pass: u32) -> Vec<Rgb> {
    let pass = integrator.pass(pass, &Silent);
    let out = (pass.counters.rejected_samples, pass.counters.rejected_photons);
    assert_eq!(out, (0, 0), "samples and photons that were left out");
    pass.image
}

/// A key of test `name`.
pub fn key(name: u64) -> Key {
    Key::new(name).purpose(Purpose::Test)
}
