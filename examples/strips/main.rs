//! Renders the strips of docs/accuracy-strips.md and writes the page:
//!
//! ```sh
//! cargo run --release --example strips -- [SCENE …]
//! ```
//!
//! With names it renders only those scenes. Files of measurements beside the images describe the
//! others. The name `none` renders no scene.

mod measure;
mod page;
mod scenes;

use caustica::image::metrics::relative_error;
use caustica::render::error_estimate::MIN_ERROR_ESTIMATE_PASSES;
use caustica::{Algorithm, Image, SceneFile, WriteOptions, write_image};
use glam::Vec3;
use measure::{MethodRender, PassSize, Stage, TARGETS, processor_time};
use page::{SceneMeasurements, Trial, caption, page};
use scenes::{ENTRIES, Entry};
use std::error::Error;
use std::fs;
use std::path::Path;

/// Smallest target.
const LAST_TARGET: f64 = TARGETS[TARGETS.len() - 1];

/// Folder of the strips and of their measurements.
const FOLDER: &str = "docs/images/strips";

/// Width and height of the pictures.
const SIZE: (u32, u32) = (160, 120);

/// Width and height of the crop that a strip shows.
const CROP: (u32, u32) = (66, 50);

/// Width and height of a square of the strip that shows one pixel.
const SCALE: u32 = 3;

/// Width of the white gap between two pictures of a strip.
const GAP: u32 = 6;

/// Processor time after which a render of the default method ends, loading and pilots included
/// \[s].
const LIMIT: f64 = 120.0;

/// Processor time after which a render of another method ends \[s].
const OTHER_LIMIT: f64 = 60.0;

/// Target that decides which other method is compared.
const TRIAL_TARGET: f64 = 0.05;

/// Processor time of the trial of each other method \[s].
const TRIAL_LIMIT: f64 = 15.0;

/// Largest difference from the default method's picture, divided by the target. A method with a
/// larger difference did not find all light, so its error estimate is wrong.
const DIFFERENCE_FACTOR: f64 = 1.5;

fn main() -> Result<(), Box<dyn Error>> {
    // Paths of scenes and images are relative to the repository's root.
    std::env::set_current_dir(env!("CARGO_MANIFEST_DIR"))?;
    fs::create_dir_all(FOLDER)?;
    // One thread, so that processor time is the time of one core.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let names: Vec<String> = std::env::args().skip(1).collect();
    let is_known = |name: &str| name == "none" || ENTRIES.iter().any(|entry| entry.name == name);
    if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
        return Err(format!("no strip is called `{unknown}`").into());
    }
    for entry in ENTRIES.iter().filter(|entry| names.is_empty() || names.iter().any(|name| name == entry.name)) {
        let measured = measure_scene(entry)?;
        fs::write(measurements_path(entry), serde_json::to_string_pretty(&measured)? + "\n")?;
    }
    let measured = |entry| -> Result<_, Box<dyn Error>> {
        let text = fs::read_to_string(measurements_path(entry))?;
        Ok((entry, serde_json::from_str(&text)?))
    };
    let is_measured = |entry: &&Entry| Path::new(&measurements_path(entry)).exists();
    let all =
        ENTRIES.iter().filter(is_measured).map(measured).collect::<Result<Vec<(&Entry, SceneMeasurements)>, _>>()?;
    for (entry, measured) in &all {
        eprintln!("{}: {}", entry.name, caption(&measured.default));
    }
    fs::write("docs/accuracy-strips.md", page(&all))?;
    Ok(())
}

fn measurements_path(entry: &Entry) -> String {
    format!("{FOLDER}/{}.json", entry.name)
}

/// Renders the scene of `entry` by the default method, and by the other method that reaches
/// [`TRIAL_TARGET`] first. Writes the strip.
fn measure_scene(entry: &Entry) -> Result<SceneMeasurements, Box<dyn Error>> {
    let start = processor_time();
    let mut file = SceneFile::read(Path::new(&entry.scene())).map_err(|e| format!("{e:?}"))?;
    (file.description.camera.value.width, file.description.camera.value.height) = SIZE;
    let scene = file.resolve().map_err(|e| format!("{e:?}"))?;
    let loading = processor_time() - start;

    // The default method.
    let mut render = MethodRender::prepare(Algorithm::Hybrid, &scene, PassSize::Default, loading);
    let setup_seconds = render.cpu_seconds();
    render.render_until(LAST_TARGET, LIMIT)?;
    render.finish()?;
    let mut small = MethodRender::prepare(Algorithm::Hybrid, &scene, PassSize::Small, loading);
    if let Some(target) = last_immediate_target(&render) {
        small.render_until(target, LIMIT)?;
    }
    let (default, pictures) = cheaper_stages(render, &small);
    print_stages(entry, &default);
    let strip = strip(&pictures, entry.corner)?;
    write_image(Path::new(&format!("{FOLDER}/{}.png", entry.name)), &strip, &WriteOptions::default())?;
    let reference = pictures.last().ok_or("no picture")?;

    // Trials of the other methods.
    let mut trials = Vec::new();
    let mut best: Option<(f64, Algorithm, MethodRender<'_>)> = None;
    for algorithm in [Algorithm::Path, Algorithm::Sppm] {
        let mut trial = MethodRender::prepare(algorithm, &scene, PassSize::Small, loading);
        let is_reached = trial.render_until(TRIAL_TARGET, TRIAL_LIMIT)?;
        let difference = trial.difference(reference)?;
        let finds_all_light = difference <= DIFFERENCE_FACTOR * TRIAL_TARGET;
        // Methods that fail are ordered by their differences, after all methods that succeed.
        let order = if is_reached && finds_all_light { trial.cpu_seconds() } else { TRIAL_LIMIT * (2.0 + difference) };
        trials.push(Trial {
            algorithm: algorithm.name().to_owned(),
            is_reached,
            cpu_seconds: trial.cpu_seconds(),
            difference,
        });
        if best.as_ref().is_none_or(|(least, ..)| order < *least) {
            best = Some((order, algorithm, trial));
        }
    }
    eprintln!("{trials:?}");

    // The best of them.
    let (_, algorithm, small) = best.ok_or("no other method")?;
    let mut render = MethodRender::prepare(algorithm, &scene, PassSize::Default, loading);
    render.render_until(LAST_TARGET, OTHER_LIMIT)?;
    render.finish()?;
    let (mut other, pictures) = cheaper_stages(render, &small);
    for (stage, picture) in other.iter_mut().zip(&pictures) {
        stage.difference = Some(relative_error(picture, reference)?);
    }
    print_stages(entry, &other);
    Ok(SceneMeasurements { setup_seconds, default, trials, other_algorithm: algorithm.name().to_owned(), other })
}

/// Returns the smallest target that the first error estimate of `render` met already.
fn last_immediate_target(render: &MethodRender<'_>) -> Option<f64> {
    let is_immediate = |stage: &&Stage| stage.is_reached && stage.passes == MIN_ERROR_ESTIMATE_PASSES;
    render.stages.iter().rfind(is_immediate).map(|stage| stage.target)
}

/// Returns the stages of `render`, and their pictures. Small passes replace a stage if they reach
/// its target in less time.
fn cheaper_stages(render: MethodRender<'_>, small: &MethodRender<'_>) -> (Vec<Stage>, Vec<Image>) {
    let (mut stages, mut pictures) = (render.stages, render.pictures);
    for (i, stage) in small.stages.iter().enumerate() {
        if stage.is_reached && (stage.cpu_seconds < stages[i].cpu_seconds || !stages[i].is_reached) {
            (stages[i], pictures[i]) = (stage.clone(), small.pictures[i].clone());
        }
    }
    (stages, pictures)
}

fn print_stages(entry: &Entry, stages: &[Stage]) {
    eprintln!("{}", entry.name);
    stages.iter().for_each(|stage| eprintln!("  {stage:?}"));
}

/// Returns the crops of `pictures` at `corner`, enlarged and side by side.
fn strip(pictures: &[Image], corner: (u32, u32)) -> Result<Image, Box<dyn Error>> {
    let step = CROP.0 * SCALE + GAP;
    let (width, height) = (step * pictures.len() as u32 - GAP, CROP.1 * SCALE);
    let pixel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let (column, picture) = (x % step / SCALE, &pictures[(x / step) as usize]);
        if column >= CROP.0 {
            return Vec3::ONE;
        }
        picture.pixels()[((corner.1 + y / SCALE) * picture.width() + corner.0 + column) as usize]
    };
    Ok(Image::from_pixels(width, height, (0..width * height).map(pixel).collect())?)
}
