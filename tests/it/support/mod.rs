//! Helpers of tests: scenes, passes, statistics, the command line and headless browsers.

pub mod browser;
mod data;
pub mod devtools;
pub mod shell;
mod statistics;
mod transport;

use caustica::color::Rgb;
use caustica::format::{SceneFile, SourceText, parse, resolve};
use caustica::image::{self, Image};
use caustica::integrate::{Algorithm, Integrator, Settings, SilentMonitor};
use caustica::sampling::{Key, Purpose};
use caustica::scene::Scene;
pub use statistics::*;
use std::path::{Path, PathBuf};
use std::time::Duration;
pub use transport::*;

/// Time limit of one command or one wait. After it, the command counts as hung. On a loaded
/// machine, a command of a test can take more than a minute.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// Returns the absolute path of a file or folder that is given relative to the repository's root.
pub fn project_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Returns a subfolder of the course's data, which may not be distributed with the program.
///
/// `CAUSTICA_COURSE` names the data's folder; the default is `../shared/course`. If the data is
/// absent, the test panics. With `CAUSTICA_SKIP_MISSING`, it prints a line and returns `None`
/// instead.
pub fn course_data_folder(subfolder: &str) -> Option<PathBuf> {
    shared_data_folder("CAUSTICA_COURSE", "../shared/course", subfolder)
}

/// Returns a subfolder of scenes by other people, which are not distributed with the program.
///
/// `CAUSTICA_WORLD` names the folder of these scenes; the default is the folder `world` beside that
/// of the course. [`course_data_folder`] says what happens if it is absent.
pub fn world_data_folder(subfolder: &str) -> Option<PathBuf> {
    let beside = std::env::var_os("CAUSTICA_COURSE").map(|course| PathBuf::from(course).join("../world"));
    let default = beside.unwrap_or_else(|| PathBuf::from("../shared/world"));
    shared_data_folder("CAUSTICA_WORLD", default, subfolder)
}

/// Returns a subfolder of the folder that the environment variable `variable` names, or of
/// `default`.
///
/// [`course_data_folder`] says what happens if it is absent.
fn shared_data_folder(variable: &str, default: impl AsRef<Path>, subfolder: &str) -> Option<PathBuf> {
    let root = std::env::var_os(variable).map_or_else(|| project_path("").join(default), PathBuf::from);
    let folder = root.join(subfolder);
    if folder.is_dir() {
        return Some(folder);
    }
    let skip = std::env::var_os("CAUSTICA_SKIP_MISSING").is_some();
    assert!(
        skip,
        "{} is absent: name the data's folder by {variable}, or set CAUSTICA_SKIP_MISSING=1 to skip its tests",
        folder.display()
    );
    eprintln!("SKIPPED: {} is absent", folder.display());
    None
}

/// Reads a reference image of `tests/data`.
pub fn reference_image(name: &str) -> Image {
    let path = project_path("tests/data").join(name);
    image::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Builds the scene of `text`. File names in the text are relative to `tests/scenes`.
#[track_caller]
pub fn scene_from_text(text: &str) -> Scene {
    scene_from_text_in("tests/scenes", text)
}

/// Builds the scene of `text`. File names in the text are relative to `folder` of the repository.
#[track_caller]
pub fn scene_from_text_in(folder: &str, text: &str) -> Scene {
    let source = SourceText::new("test", text);
    let resolved = parse("test", text).and_then(|d| resolve(&d, &source, &project_path(folder)));
    resolved.unwrap_or_else(|e| panic!("{e:?}\n{text}"))
}

/// Builds the scene of a file of the repository, with an image of `width` × `height` pixels.
pub fn scene_from_file(name: &str, (width, height): (u32, u32)) -> Scene {
    let mut file = SceneFile::read(&project_path(name)).unwrap();
    (file.description.camera.value.width, file.description.camera.value.height) = (width, height);
    file.resolve().unwrap()
}

/// Renders passes 0 to `passes` − 1. Returns their pixels, one image after the other.
pub fn render_passes(scene: &Scene, algorithm: Algorithm, settings: Settings, passes: u32) -> Vec<Rgb> {
    let prepared = algorithm.prepare(scene, settings);
    (0..passes).flat_map(|i| render_one_pass(&*prepared, i)).collect()
}

/// Renders one pass and returns its pixels. Panics if the pass rejected a sample or a photon.
///
/// The renderer drops non-finite samples and photons, and counts them. The pixels alone would hide
/// such an error.
#[track_caller]
pub fn render_one_pass(integrator: &dyn Integrator, pass: u32) -> Vec<Rgb> {
    let pass = integrator.render_pass(pass, &SilentMonitor);
    let rejected = (pass.counters.rejected_samples, pass.counters.rejected_photons);
    assert_eq!(rejected, (0, 0), "rejected samples and photons");
    pass.image
}

/// Returns the random key of test `number`.
pub fn test_key(number: u64) -> Key {
    Key::new(number).purpose_key(Purpose::Test)
}
