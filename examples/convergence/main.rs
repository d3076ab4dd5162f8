//! Convergence of the default integrator: light in foci, and pixels that stand out.
//!
//! ```sh
//! cargo run --release --example convergence -- foci [FOCUS …] [--passes N,…] [--seeds N]
//!     [--truth PASSES] [--photons N]
//! cargo run --release --example convergence -- outliers [SCENE …] [--passes N] [--seeds N]
//!     [--truth PASSES] [--size WxH] [--pictures FOLDER]
//! ```
//!
//! Both take `--without TECHNIQUE,…` with `light-tracing`, `prefix-rays` or `indirect-photons`.

mod arguments;
mod foci;
mod focus;
mod outliers;

use arguments::Arguments;
use caustica::format::SceneFile;
use caustica::integrate::Settings;
use caustica::scene::Scene;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Folder of the scenes.
fn scenes_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// Returns a scene of the folder `scenes` at another size (width, height), and the number of pixels
/// that its file asks for.
fn read_scene(name: &str, size: (u32, u32)) -> Result<(Scene, u32), Box<dyn Error>> {
    let mut file = SceneFile::read(&scenes_folder().join(format!("{name}.txt"))).map_err(|e| format!("{e:?}"))?;
    let camera = &mut file.description.camera.value;
    let pixels = camera.width * camera.height;
    (camera.width, camera.height) = size;
    Ok((file.resolve().map_err(|e| format!("{e:?}"))?, pixels))
}

/// Returns the default settings with `part` of the photon paths.
fn settings(arguments: &Arguments, seed: u64, part: f64) -> Result<Settings, String> {
    let mut settings = Settings::default();
    let scaled = |count: u32| (f64::from(count) * part).round() as u32;
    (settings.unaimed_paths, settings.aimed_paths) = (scaled(settings.unaimed_paths), scaled(settings.aimed_paths));
    settings.camera_paths.seed = seed;
    arguments.turn_off(&mut settings)?;
    Ok(settings)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse(std::env::args().skip(1))?;
    match arguments.measurement.as_str() {
        "foci" => foci::print(&arguments),
        "outliers" => outliers::print(&arguments),
        other => Err(format!("`{other}` is no measurement: choose foci or outliers").into()),
    }
}
