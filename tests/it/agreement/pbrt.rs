//! Path tracing of imported scenes against pictures by pbrt-v4, by tiles.
//!
//! Scenes and pictures lie outside the repository: see [`crate::support::world_data_folder`].

use super::compare::{Estimate, Grid, Renders, compare};
use super::spotfog::{Fog, spotfog_picture};
use crate::support::{render_one_pass, world_data_folder};
use caustica::camera::{Filter, FilterKind};
use caustica::color::Rgb;
use caustica::format::SceneFile;
use caustica::image::{self, Image};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings};
use glam::{DVec3, Vec3};
use std::path::Path;

/// Number of passes of each picture, with [`SAMPLES`] camera rays per pixel each.
const PASSES: u32 = 24;
const SAMPLES: u32 = 1;

/// Number of tiles along the width of a picture.
const TILES: usize = 4;

/// Least brightness to which the relative tolerance of tiles applies, as a fraction of the mean of
/// all tiles. Darker tiles have the tolerance of this brightness, because their light comes from
/// few paths.
const MIN_TOLERANCE_BRIGHTNESS: f64 = 0.1;

/// Brightness above which a pixel shows a lamp, relative to the median.
const LAMP_BRIGHTNESS: f64 = 20.0;

/// A picture by pbrt-v4.
struct Reference {
    /// Folder of the scene, and name of scene and picture.
    scene: (&'static str, &'static str),
    /// Greatest number of bounces: pbrt's `maxdepth` − 1.
    max_bounces: u32,
    /// Allowed relative deviation of the mean and of tiles, due to approximations of the importer.
    tolerance: [f64; 2],
}

/// Diffuse surfaces and metals deviate because pbrt renders spectra. Layered surfaces have pbrt's
/// albedo under diffuse light, and deviate for single directions of light.
const REFERENCES: [Reference; 5] = [
    Reference { scene: ("killeroos", "killeroo-diffuse-ref"), max_bounces: 4, tolerance: [0.02, 0.02] },
    Reference { scene: ("killeroos", "killeroo-gold-notex-ref"), max_bounces: 4, tolerance: [0.02, 0.02] },
    Reference { scene: ("figures", "f7-19a-ref"), max_bounces: 0, tolerance: [0.02, 0.1] },
    Reference { scene: ("killeroos", "killeroo-simple-ref"), max_bounces: 0, tolerance: [0.02, 0.1] },
    Reference { scene: ("simple", "teapot-area-light-ref"), max_bounces: 0, tolerance: [0.05, 0.1] },
];

fn luminance(pixel: Vec3) -> f32 {
    pixel.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns pixels whose channels are all the luminance.
fn gray(pixels: &[Vec3]) -> Vec<Rgb> {
    pixels.iter().map(|pixel| Rgb::splat(luminance(*pixel))).collect()
}

/// Returns the picture of a scene, and the pictures of two halves of its samples.
fn read_reference(folder: &Path, name: &str) -> [Image; 3] {
    ["", ".half1", ".half2"].map(|suffix| {
        let path = folder.join(format!("reference/{name}{suffix}.exr"));
        image::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    })
}

/// Returns the grid of a picture, without the pixels that show a lamp.
fn grid(picture: &Image) -> Grid {
    let mut sorted: Vec<f32> = gray(picture.pixels()).iter().map(|pixel| pixel.x).collect();
    sorted.sort_by(f32::total_cmp);
    let limit = LAMP_BRIGHTNESS * f64::from(sorted[sorted.len() / 2]);
    let kept = picture.pixels().iter().map(|pixel| f64::from(luminance(*pixel)) <= limit).collect();
    Grid { kept, ..Grid::new((picture.width(), picture.height()), picture.width() as usize / TILES) }
}

/// Returns the means of the tiles of a gray picture.
fn tile_means(image: &Image, grid: &Grid) -> Vec<DVec3> {
    let pixels = gray(image.pixels());
    let sums = grid.window_sums(pixels.iter().map(|pixel| pixel.as_dvec3()));
    sums.iter().map(|(sum, count)| sum / count.max(1.0)).collect()
}

/// Returns the means of the `tiles`, or of the whole picture, with a relative `tolerance`.
///
/// The relative error of tiles is pooled over all of them, from both halves of the samples.
fn estimate([picture, first, second]: &[Image; 3], tiles: &Grid, is_whole: bool, tolerance: f64) -> Estimate {
    let [means, first, second] = [picture, first, second].map(|image| tile_means(image, tiles));
    let count = means.len() as f64;
    let square = |v: DVec3| v * v;
    let noise: DVec3 = first.iter().zip(&second).map(|(a, b)| square(0.5 * (*a - *b))).sum();
    let squares: DVec3 = means.iter().map(|mean| square(*mean)).sum();
    let level = means.iter().sum::<DVec3>() / count;
    let (mean, variance) = if is_whole {
        (tile_means(picture, &tiles.single_window()), vec![noise / (count * count)])
    } else {
        let variance = means.iter().map(|mean| square(*mean) * noise / squares).collect();
        (means, variance)
    };
    let bias = mean.iter().map(|mean| mean.max(MIN_TOLERANCE_BRIGHTNESS * level) * tolerance).collect();
    Estimate { mean, variance, bias, dof: count }
}

/// Renders passes of a pbrt scene with Caustica. Returns their luminance as gray pictures.
fn our_passes(path: &Path, max_bounces: u32) -> Vec<Vec<Rgb>> {
    let file = SceneFile::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let scene = file.resolve().unwrap();
    let camera_paths = CameraPathSettings {
        samples_per_pixel: Some(SAMPLES),
        max_bounces,
        filter: Filter::new(FilterKind::Box),
        ..CameraPathSettings::default()
    };
    let prepared = Algorithm::Path.prepare(&scene, Settings { camera_paths, ..Settings::default() });
    (0..PASSES).map(|i| gray(&render_one_pass(&*prepared, i))).collect()
}

#[test]
#[ignore = "long: renders of imported scenes"]
fn imported_scenes_match_pictures_of_pbrt() {
    let Some(folder) = world_data_folder("pbrt-v4") else { return };
    for Reference { scene: (group, name), max_bounces, tolerance: [of_mean, of_tiles] } in REFERENCES {
        let theirs = read_reference(&folder, name);
        let scene = folder.join(format!("upgraded/{group}/{name}.pbrt"));
        let ours = Renders::of_images(name, our_passes(&scene, max_bounces));
        let tiles = grid(&theirs[0]);
        let expected = estimate(&theirs, &tiles, false, of_tiles);
        compare(&format!("{name}, tiles"), &ours.over(&tiles), &expected, of_tiles + 0.04);
        let expected = estimate(&theirs, &tiles, true, of_mean);
        compare(&format!("{name}, whole"), &ours.over(&tiles.single_window()), &expected, of_mean + 0.01);
    }
}

/// The fog on the back of sheets explains how Caustica's picture of `spotfog` differs from pbrt's.
///
/// In pbrt, light that leaves the back of a sheet travels through its inner medium. All walls of
/// this scene turn their back to the camera, so no fog dims the light that they reflect. An
/// independent path tracer confirms this. With pbrt's rule, it gives pbrt's picture; with fog on
/// both sides, it gives Caustica's.
#[test]
#[ignore = "long: renders of an imported scene"]
fn fog_behind_sheets_explains_spotfog() {
    let Some(folder) = world_data_folder("pbrt-v4") else { return };
    let theirs = read_reference(&folder, "spotfog-ref");
    let size = (theirs[0].width(), theirs[0].height());
    let independent = |fog: Fog| {
        let images = (0..PASSES).map(|i| gray(&spotfog_picture(size, 8, fog, u64::from(i)))).collect();
        Renders::of_images("independent path tracer", images)
    };
    let tiles = Grid::new(size, size.0 as usize / TILES);
    let by_rule = independent(Fog::InFrontOfSheets);
    compare("spotfog, rule of pbrt", &by_rule.over(&tiles), &estimate(&theirs, &tiles, false, 0.01), 0.06);
    let ours = Renders::of_images("ours", our_passes(&folder.join("upgraded/simple/spotfog-ref.pbrt"), 7));
    let everywhere = independent(Fog::Everywhere);
    for grid in [&tiles, &tiles.single_window()] {
        compare("spotfog, fog everywhere", &ours.over(grid), &everywhere.over(grid), 0.06);
    }
}
