//! Pixels that stand out from their neighbours.
//!
//! The picture d is a render minus a long reference of another seed. A pixel is *salt* if d differs
//! from the median of its neighbours by more than five standard errors. The reference's passes give
//! the variance of a pixel in one pass. It is at least the median of the neighbours', both in the
//! reference and in the render: pilots divide the work of each render anew, so noise differs
//! between seeds. A standard error is at least a thousandth of the local light.
//!
//! Heavy tails enlarge the standard error. A *firefly* is therefore counted without it: d exceeds
//! the median of its neighbours by more than half the local light.

use crate::arguments::Arguments;
use crate::{read_scene, scenes_folder, settings};
use caustica::color::channel_mean;
use caustica::image::{Image, WriteOptions, write};
use caustica::integrate::{Algorithm, SilentMonitor};
use caustica::plan::{EffectOverrides, Plan};
use caustica::render::Film;
use caustica::scene::{Effect, Scene};
use caustica::stats::cpu_seconds;
use glam::Vec3;
use std::error::Error;

/// A difference from the neighbours of more standard errors than this is salt.
const STANDARD_ERRORS: f64 = 5.0;
/// A firefly is brighter than its neighbours by more than this part of the local light.
const FIREFLY: f64 = 0.5;
/// Passes of the reference over passes of a render.
const REFERENCE: u32 = 16;

/// Mean of the passes, and the variance of the channels' mean in one pass.
struct Rendered {
    pixels: Vec<Vec3>,
    variance: Vec<f64>,
}

fn brightness(pixel: &Vec3) -> f64 {
    f64::from(channel_mean(*pixel))
}

fn render(scene: &Scene, settings: caustica::integrate::Settings, size: (u32, u32), passes: u32) -> Rendered {
    let integrator = Algorithm::Hybrid.prepare(scene, settings);
    if let Some(balance) = integrator.ray_photon_balance() {
        eprintln!("{balance:?}");
    }
    let mut film = Film::new(size.0, size.1);
    let mut moments = vec![[0.0; 2]; (size.0 * size.1) as usize];
    for pass in 0..passes {
        let image = integrator.render_pass(pass, &SilentMonitor).image;
        film.add(&image);
        let n = f64::from(pass + 1);
        for ([mean, squares], pixel) in moments.iter_mut().zip(&image) {
            let before = brightness(pixel) - *mean;
            *mean += before / n;
            *squares += before * (brightness(pixel) - *mean);
        }
    }
    let variance = moments.iter().map(|[_, squares]| squares / f64::from(passes - 1)).collect();
    Rendered { pixels: film.mean_picture(), variance }
}

/// Returns the median of a value over the neighbours of pixel `i`, without the pixel itself.
fn neighbours_median((width, height): (u32, u32), i: usize, value: &[f64]) -> f64 {
    let (x, y) = (i as u32 % width, i as u32 / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    let columns = x.saturating_sub(1)..(x + 2).min(width);
    let all = rows.flat_map(|row| columns.clone().map(move |column| (row * width + column) as usize));
    median(all.filter(|at| *at != i).map(|at| value[at]).collect())
}

/// Returns the median, the mean of the two in the middle if the number is even.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len().is_multiple_of(2) { 0.5 * (values[middle - 1] + values[middle]) } else { values[middle] }
}

/// Kind of a pixel that stands out.
#[derive(Clone, Copy, PartialEq)]
enum OutlierKind {
    Bright,
    Dark,
    Firefly,
}

/// A pixel that stands out from its neighbours.
struct Outlier {
    pixel: usize,
    kind: OutlierKind,
    /// Difference from the neighbours in standard errors.
    standard_errors: f64,
    /// Difference from the neighbours over the local light.
    part: f64,
}

/// Returns the pixels of `picture` that stand out.
fn outliers(picture: &Rendered, passes: u32, reference: &Rendered, long: u32, size: (u32, u32)) -> Vec<Outlier> {
    let light: Vec<f64> = reference.pixels.iter().map(brightness).collect();
    let typical = median(light.clone());
    let difference: Vec<f64> =
        picture.pixels.iter().zip(&light).map(|(pixel, light)| brightness(pixel) - light).collect();
    let mut found = Vec::new();
    for i in 0..light.len() {
        let stands_out = difference[i] - neighbours_median(size, i, &difference);
        let local = light[i].max(neighbours_median(size, i, &light)) + 0.1 * typical;
        let long_variance = reference.variance[i].max(neighbours_median(size, i, &reference.variance));
        let variance = long_variance.max(neighbours_median(size, i, &picture.variance));
        let error = (variance / f64::from(passes) + long_variance / f64::from(long)).sqrt().max(1e-3 * local);
        let (standard_errors, part) = (stands_out / error, stands_out / local);
        let mut add = |kind| found.push(Outlier { pixel: i, kind, standard_errors, part });
        if standard_errors.abs() > STANDARD_ERRORS {
            add(if stands_out > 0.0 { OutlierKind::Bright } else { OutlierKind::Dark });
        }
        if part > FIREFLY {
            add(OutlierKind::Firefly);
        }
    }
    found
}

/// Returns the names of all scenes that have no media.
fn scenes_without_media() -> Result<Vec<String>, Box<dyn Error>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(scenes_folder())? {
        let path = entry?.path();
        let Some(name) = path.file_stem().and_then(|name| name.to_str()) else { continue };
        if path.extension().is_none_or(|extension| extension != "txt") {
            continue;
        }
        let scene = read_scene(name, (4, 3))?.0;
        let plan = Plan::new(&scene, Algorithm::Hybrid.supported_effects(), EffectOverrides::NO_OVERRIDES);
        if !plan.simulated_effects().has(Effect::Media) {
            names.push(name.to_owned());
        }
    }
    names.sort();
    Ok(names)
}

pub fn print(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let names = if arguments.names.is_empty() { scenes_without_media()? } else { arguments.names.clone() };
    let passes = arguments.passes.as_ref().map_or(Algorithm::Hybrid.default_passes(), |passes| passes[0]);
    let (size, seeds) = (arguments.size, arguments.seeds.unwrap_or(4));
    let long = arguments.truth.unwrap_or(REFERENCE * passes);
    println!(
        "| scene | pixels | bright | dark | salt in 2,000 | fireflies | fireflies in 2,000 | s |\n|{}",
        " --- |".repeat(8)
    );
    for name in names {
        let start = cpu_seconds().unwrap_or(0.0);
        let (scene, own_pixels) = read_scene(&name, size)?;
        // As many photons per pixel as in the scene at its own size.
        let part = f64::from(size.0 * size.1) / f64::from(own_pixels);
        let reference = render(&scene, settings(arguments, 1 << 40, part)?, size, long);
        let mut counts = [0u32; 3];
        for seed in 0..seeds {
            let picture = render(&scene, settings(arguments, seed, part)?, size, passes);
            let mut found = outliers(&picture, passes, &reference, long, size);
            found.iter().for_each(|outlier| counts[outlier.kind as usize] += 1);
            list_worst(&format!("{name}, seed {seed}"), &mut found, size.0);
            if let Some(folder) = &arguments.pictures {
                write_picture(folder, &format!("{name}-{seed}"), &picture.pixels, size)?;
                write_picture(folder, &format!("{name}-marks-{seed}"), &marks(&picture.pixels, &found), size)?;
            }
        }
        if let Some(folder) = &arguments.pictures {
            write_picture(folder, &format!("{name}-reference"), &reference.pixels, size)?;
        }
        let pixels = u64::from(size.0 * size.1) * seeds;
        let rate = |count: u32| 2000.0 * f64::from(count) / pixels as f64;
        let [bright, dark, fireflies] = counts;
        println!(
            "| {name} | {pixels} | {bright} | {dark} | {:.2} | {fireflies} | {:.2} | {:.0} |",
            rate(bright + dark),
            rate(fireflies),
            cpu_seconds().unwrap_or(0.0) - start
        );
    }
    Ok(())
}

/// Prints the five pixels that stand out most.
fn list_worst(picture: &str, found: &mut [Outlier], width: u32) {
    found.sort_by(|a, b| b.standard_errors.abs().total_cmp(&a.standard_errors.abs()));
    for outlier in found.iter().filter(|outlier| outlier.kind != OutlierKind::Firefly).take(5) {
        let (x, y) = (outlier.pixel as u32 % width, outlier.pixel as u32 / width);
        let (errors, part) = (outlier.standard_errors, outlier.part);
        eprintln!("{picture}, pixel {x},{y}: {errors:.1} standard errors, {part:.3} of the local light");
    }
}

/// Returns a dim picture with the outliers marked: red if bright, blue if dark, green if fireflies.
fn marks(picture: &[Vec3], found: &[Outlier]) -> Vec<Vec3> {
    let mut marked: Vec<Vec3> = picture.iter().map(|pixel| *pixel * 0.2).collect();
    for outlier in found {
        let color = [Vec3::X, Vec3::Z, Vec3::Y][outlier.kind as usize];
        marked[outlier.pixel] =
            if outlier.kind == OutlierKind::Firefly { marked[outlier.pixel] + color } else { color };
    }
    marked
}

fn write_picture(
    folder: &std::path::Path,
    name: &str,
    pixels: &[Vec3],
    size: (u32, u32),
) -> Result<(), Box<dyn Error>> {
    let image = Image::from_pixels(size.0, size.1, pixels.to_vec())?;
    for extension in ["png", "exr"] {
        write(&folder.join(format!("{name}.{extension}")), &image, &WriteOptions::default())?;
    }
    Ok(())
}
