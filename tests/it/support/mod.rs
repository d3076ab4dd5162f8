//! Test rigs: scenes, passes, statistics, the command line and a headless browser.

pub mod browser;
pub mod shell;
mod statistics;
mod transport;

use caustica::color::Rgb;
use caustica::format::{SceneFile, Source, parse, resolve};
use caustica::integrate::{Algorithm, Integrator, Settings, Silent};
use caustica::sampling::{Key, Purpose};
use caustica::scene::Scene;
pub use statistics::*;
use std::path::{Path, PathBuf};
pub use transport::*;

/// Returns the path of a file or folder, given relative to the repository's root.
pub fn project(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Builds the scene of `text`. File names in it are relative to `tests/scenes`.
#[track_caller]
pub fn scene(text: &str) -> Scene {
    scene_in("tests/scenes", text)
}

/// Builds the scene of `text`. File names in it are relative to `folder`, a folder of the repository.
#[track_caller]
pub fn scene_in(folder: &str, text: &str) -> Scene {
    let source = Source::new("test", text);
    let resolved = parse("test", text).and_then(|d| resolve(&d, &source, &project(folder)));
    resolved.unwrap_or_else(|e| panic!("{e:?}\n{text}"))
}

/// Builds the scene of a file of the repository, with an image of `width` × `height` pixels.
pub fn file(name: &str, (width, height): (u32, u32)) -> Scene {
    let mut file = SceneFile::read(&project(name)).unwrap();
    (file.description.camera.value.width, file.description.camera.value.height) = (width, height);
    file.resolve().unwrap()
}

/// Renders passes 0 to `passes` − 1 and returns their pixels, one image after the other.
pub fn pixels(scene: &Scene, algorithm: Algorithm, settings: Settings, passes: u32) -> Vec<Rgb> {
    let prepared = algorithm.prepare(scene, settings);
    (0..passes).flat_map(|i| image(&*prepared, i)).collect()
}

/// Renders one pass and returns its pixels. Fails if the pass rejected a sample or a photon.
///
/// The renderer drops non-finite samples and photons, and counts them. The pixels alone would hide such an error.
#[track_caller]
pub fn image(integrator: &dyn Integrator, pass: u32) -> Vec<Rgb> {
    let pass = integrator.pass(pass, &Silent);
    let rejected = (pass.counters.rejected_samples, pass.counters.rejected_photons);
    assert_eq!(rejected, (0, 0), "rejected samples and photons");
    pass.image
}

/// Returns the random key of the test with this number.
pub fn key(number: u64) -> Key {
    Key::new(number).purpose(Purpose::Test)
}
