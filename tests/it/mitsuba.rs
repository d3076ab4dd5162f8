//! Scenes in Mitsuba's format: pictures against Mitsuba's own, and conversion.
//!
//! Scenes by other people may not be distributed, so they are outside the repository: see
//! [`crate::support::world_data_folder`].

use crate::support::{FALSE_ALARM_RATE, mean_and_error, student_t_tail, world_data_folder};
use caustica::camera::{Filter, FilterKind};
use caustica::format::grid::{self, GridEncoding};
use caustica::format::mesh::MeshFormat;
use caustica::format::{ConvertedScene, ImportOptions, SceneFile, parse};
use caustica::image::{self, WriteOptions};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings, SilentMonitor};
use caustica::scene::Scene;
use glam::{DVec3, Vec3};
use std::fs;
use std::path::{Path, PathBuf};

/// Files that are not tested: parts that other scenes include, and scenes whose textures are
/// missing.
const NO_SCENES: [&str; 4] = ["fragments", "include", "sphere_pt.xml", "plane_pt.xml"];

/// Largest scenes, which only the long test renders.
const LARGE: [&str; 2] = ["staircase2", "matpreview"];

/// Default number of samples per pixel of Mitsuba's test references. The true number of each
/// reference is not recorded.
const REFERENCE_SAMPLES: f64 = 32_000.0;

/// A picture by Mitsuba, with tolerances for Caustica's picture of the same scene.
struct Reference {
    /// Path of the scene in the folder of Mitsuba's tests, without the extension.
    scene: &'static str,
    /// Name of the reference, in the folder `refs` beside the scene.
    reference: &'static str,
    /// Smallest and largest limit of bounces that can correspond to Mitsuba's limit of path edges.
    ///
    /// A path with n edges has n − 2 bounces. The largest limit is higher if there are thin walls
    /// in media, which Mitsuba does not count.
    bounces: [u32; 2],
    /// Allowed deviation of the mean due to approximations, relative to the mean.
    slack: f64,
}

impl Reference {
    const fn new(scene: &'static str, reference: &'static str, bounces: [u32; 2], slack: f64) -> Self {
        Self { scene, reference, bounces, slack }
    }
}

/// Number of passes of each picture, with [`SAMPLES`] camera rays per pixel each.
const PASSES: u64 = 12;
const SAMPLES: u32 = 8;

/// Greatest standard error of a mean, relative to the mean.
const MAX_RELATIVE_ERROR: f64 = 0.01;

/// Pictures of Mitsuba's own tests. `docs/measurements/mitsuba.md` lists further ones, which
/// deviate more, with reasons.
///
/// Rows of an environment map lie half a pixel further from the poles than in Mitsuba. That
/// explains deviations below 1 %.
const REFERENCES: [Reference; 6] = [
    Reference::new("infinite_mirrors/scene_path", "scene", [6, 6], 0.01),
    Reference::new("instancing/test_instancing_path", "test_instancing", [0, 0], 0.002),
    Reference::new("participating_media/test_hetero_sigmat_volpath", "test_hetero_sigmat", [4, 4], 0.01),
    Reference::new("participating_media/test_homo_null_envmap_volpath", "test_homo_null_envmap", [4, 4], 0.01),
    Reference::new(
        "participating_media/test_homo_spectral_sigmat_volpathmis",
        "test_homo_spectral_sigmat",
        [4, 4],
        0.01,
    ),
    Reference::new("participating_media/test_homo_area_light_volpath", "test_homo_area_light", [4, 20], 0.0),
];

fn read(path: &Path) -> SceneFile {
    let options = ImportOptions { allows_outside_files: true, ..ImportOptions::default() };
    SceneFile::read_with_options(path, &(), &options).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Returns the scene files of the folder, without parts of scenes; empty if the data may be absent.
fn world_scenes() -> Vec<PathBuf> {
    let Some(folder) = world_data_folder("mitsuba") else { return Vec::new() };
    let (mut scenes, mut folders) = (Vec::new(), vec![folder]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let excluded = NO_SCENES.iter().any(|part| path.ends_with(part));
            if path.is_dir() && !excluded {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "xml") && !excluded {
                scenes.push(path);
            }
        }
    }
    scenes.sort();
    assert!(scenes.len() >= 24, "{scenes:?}");
    scenes
}

/// Renders one pass of a small picture.
fn small_picture(mut file: SceneFile) -> Vec<Vec3> {
    (file.description.camera.value.width, file.description.camera.value.height) = (30, 24);
    let scene = file.resolve().unwrap_or_else(|error| panic!("{error}"));
    Algorithm::Path.prepare(&scene, Settings::default()).render_pass(0, &SilentMonitor).image
}

/// Writes a scene as text with its files, as `caustica convert` does, and reads the text again.
fn converted(scene: &SceneFile, output: &Path) -> SceneFile {
    let converted = ConvertedScene::new(scene, output);
    fs::write(output, converted.text).unwrap();
    converted.meshes.iter().for_each(|(path, mesh)| mesh.write(path, MeshFormat::PlyBinary, &[]).unwrap());
    converted.grids.iter().for_each(|(path, values)| grid::write(path, values, GridEncoding::F32).unwrap());
    for (path, picture) in &converted.pictures {
        image::write(path, picture, &WriteOptions::default()).unwrap();
    }
    SceneFile::read(output).unwrap()
}

fn check_conversion(scenes: impl Iterator<Item = PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    for path in scenes {
        let imported = read(&path);
        let printed = imported.description.to_string();
        let again = parse("printed.txt", &printed).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(again == imported.description, "{}: {printed}", path.display());
        let text = converted(&imported, &folder.path().join("converted.txt"));
        let picture = small_picture(imported);
        assert!(picture.iter().all(|pixel| pixel.is_finite()), "{}", path.display());
        assert!(small_picture(text) == picture, "{}", path.display());
    }
}

fn is_large(path: &Path) -> bool {
    LARGE.iter().any(|name| path.to_string_lossy().contains(name))
}

#[test]
#[ignore = "long: conversions of many scenes"]
fn converted_mitsuba_scenes_render_to_the_same_bits() {
    check_conversion(world_scenes().into_iter().filter(|path| !is_large(path)));
}

#[test]
#[ignore = "long: reads a million triangles"]
fn large_mitsuba_scenes_convert_to_the_same_bits() {
    check_conversion(world_scenes().into_iter().filter(|path| is_large(path)));
}

#[test]
fn scenes_without_their_textures_are_refused() {
    let Some(folder) = world_data_folder("mitsuba/specular-manifold-sampling") else { return };
    for name in ["sphere_pt.xml", "plane_pt.xml"] {
        let error = SceneFile::read(&folder.join("Figure_14_15_MainComparison").join(name)).unwrap_err();
        assert!(error.to_string().contains("Tiles71_col.jpg` does not exist"), "{error}");
    }
}

/// Returns the mean luminance of a picture.
fn mean_luminance(pixels: &[Vec3]) -> f64 {
    let luminance = |pixel: &Vec3| pixel.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722));
    pixels.iter().map(luminance).sum::<f64>() / pixels.len() as f64
}

/// Returns the mean luminance of each pass of a scene, with at most `max_bounces` bounces.
fn pass_means(scene: &Scene, max_bounces: u32) -> Vec<f64> {
    let pass = |seed: u64| {
        let camera_paths = CameraPathSettings {
            samples_per_pixel: Some(SAMPLES),
            max_bounces,
            seed,
            filter: Filter::new(FilterKind::Box),
            ..CameraPathSettings::default()
        };
        let settings = Settings { camera_paths, ..Settings::default() };
        mean_luminance(&Algorithm::Path.prepare(scene, settings).render_pass(0, &SilentMonitor).image)
    };
    (0..PASSES).map(pass).collect()
}

/// Fails if the mean luminance of a reference is outside the range of Caustica's means.
///
/// The range is from the mean with the smaller limit of bounces to the mean with the larger one.
/// The false-alarm rate is [`FALSE_ALARM_RATE`] for each mean.
fn compare_mean(folder: &Path, reference: &Reference) {
    let Reference { scene: name, reference: picture, bounces, slack } = reference;
    let path = folder.join(format!("{name}.xml"));
    let file = |suffix: &str| path.with_file_name(format!("refs/{picture}_{suffix}.exr"));
    let (expected, variance) = (image::read(&file("ref_rgb")).unwrap(), image::read(&file("ref_rgb_var")).unwrap());
    let theirs = mean_luminance(expected.pixels());
    let noise = (mean_luminance(variance.pixels()) / REFERENCE_SAMPLES / expected.pixels().len() as f64).sqrt();
    let mut file = read(&path);
    (file.description.camera.value.width, file.description.camera.value.height) = (expected.width(), expected.height());
    let scene = file.resolve().unwrap();
    for (max_bounces, sign) in bounces.iter().zip([1.0, -1.0]) {
        let samples = pass_means(&scene, *max_bounces);
        let (mean, error) = mean_and_error(&samples);
        let excess = (sign * (mean - theirs) - slack * theirs - 5.0 * noise).max(0.0);
        let p = if excess == 0.0 { 1.0 } else { student_t_tail(excess / error, samples.len() as f64 - 1.0) };
        let ratio = format!("ratio {:.4} ± {:.4}", mean / theirs, error / theirs);
        let line = format!("{name}, {max_bounces} bounces: {ratio} (p = {p:.1e})");
        eprintln!("{line}");
        assert!(p >= FALSE_ALARM_RATE, "{line}");
        assert!(error <= MAX_RELATIVE_ERROR * theirs, "{line}: too blunt");
    }
}

#[test]
#[ignore = "long: renders every reference scene"]
fn means_agree_with_pictures_of_mitsuba() {
    let Some(folder) = world_data_folder("mitsuba/mitsuba-data/tests/scenes") else { return };
    REFERENCES.iter().for_each(|reference| compare_mean(&folder, reference));
}
