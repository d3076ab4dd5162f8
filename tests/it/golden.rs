//! Small renders of every scene in scenes/ against golden images that were inspected once.
//!
//! `CAUSTICA_BLESS=1 cargo test --test it golden` replaces the golden images. Inspect each one
//! before you commit it.
//!
//! Renders have the same bits on all x86-64 machines, if they are built as `.cargo/config.toml`
//! says. On other architectures, the crate kiddo may sum over photons in another order, which
//! changes the last bits. A byte then changes by one level, if the value is at the border of two
//! levels. So a difference of 1 level is allowed in 1 of 200 bytes.

use crate::support::project_path;
use caustica::format::SceneFile;
use caustica::image::{self, Image, Rgb8Image, WriteOptions, metrics};
use caustica::integrate::{Algorithm, CameraPathSettings, Settings, SilentMonitor};
use caustica::render::{RenderResult, StopCriteria, render};
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const SIZE: (u32, u32) = (96, 72);

/// Returns the names, without `extension`, of the files in a folder that have this extension,
/// sorted.
fn stems(folder: &Path, extension: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let paths = entries.map(|e| e.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == extension));
    let mut names: Vec<String> = paths.map(|p| p.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

fn picture(scene: &Path) -> Image {
    let mut file = SceneFile::read(scene).unwrap();
    (file.description.camera.value.width, file.description.camera.value.height) = SIZE;
    let scene = file.resolve().unwrap();
    let settings = Settings {
        allows_ray_photon_balance: false,
        unaimed_paths: 20_000,
        aimed_paths: 20_000,
        camera_paths: CameraPathSettings { samples_per_pixel: Some(2), ..CameraPathSettings::default() },
        ..Settings::default()
    };
    let integrator = Algorithm::Hybrid.prepare(&scene, settings);
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria { max_passes: Some(2), ..StopCriteria::unlimited(&interrupted) };
    let start = RenderResult::without_passes(integrator.as_ref(), SIZE);
    let rendered = render(start, 0..u32::MAX, integrator.as_ref(), &stop, &SilentMonitor, |_| {});
    Image::from_pixels(SIZE.0, SIZE.1, rendered.film.mean_picture()).unwrap()
}

/// Returns a message if the images differ by more than allowed.
fn difference(ours: &Rgb8Image, golden: &Rgb8Image) -> Option<String> {
    let differ = match metrics::compare_bytes(ours, golden) {
        Ok(differ) => differ,
        Err(error) => return Some(error.to_string()),
    };
    let pixels = ours.pixels().iter().zip(golden.pixels()).filter(|(a, b)| a != b).count();
    let harmless = differ.largest <= 1 && differ.count * 200 <= 3 * ours.pixels().len();
    (!harmless).then(|| format!("{pixels} pixels differ in {} bytes, by up to {} levels", differ.count, differ.largest))
}

#[test]
fn scenes_match_golden_images() {
    let (scenes, golden, new) = (project_path("scenes"), project_path("tests/golden"), project_path("target/golden"));
    let bless = std::env::var_os("CAUSTICA_BLESS").is_some();
    fs::create_dir_all(&new).unwrap();
    assert!(!stems(&scenes, "txt").is_empty(), "{} holds no scenes", scenes.display());
    let mut wrong = Vec::new();
    for name in stems(&scenes, "txt") {
        let (kept, made) = (golden.join(format!("{name}.png")), new.join(format!("{name}.png")));
        image::write(&made, &picture(&scenes.join(format!("{name}.txt"))), &WriteOptions::default()).unwrap();
        if bless {
            fs::create_dir_all(&golden).unwrap();
            fs::copy(&made, &kept).unwrap();
        }
        if !kept.exists() {
            wrong.push(format!("{name}: {} is missing: make it with CAUSTICA_BLESS=1", kept.display()));
            continue;
        }
        match difference(&image::read_rgb8(&made).unwrap(), &image::read_rgb8(&kept).unwrap()) {
            Some(difference) => wrong.push(format!("{name}: {difference}; compare {} with it", made.display())),
            None => fs::remove_file(&made).unwrap(),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_golden_image_has_a_scene() {
    let scenes = stems(&project_path("scenes"), "txt");
    for name in stems(&project_path("tests/golden"), "png") {
        assert!(scenes.contains(&name), "tests/golden/{name}.png belongs to no scene: delete it");
    }
}

#[test]
fn only_few_single_level_differences_pass() {
    let base = |width, height| Rgb8Image::from_pixels(width, height, vec![[7; 3]; 200]).unwrap();
    let compare = |change: &dyn Fn(&mut [u8])| {
        let mut changed = base(20, 10);
        change(changed.pixels_mut().as_flattened_mut());
        difference(&changed, &base(20, 10))
    };
    assert_eq!(compare(&|_| {}), None);
    assert_eq!(compare(&|b| (0..3).for_each(|i| b[i] += 1)), None);
    assert_eq!(compare(&|b| (0..4).for_each(|i| b[i] -= 1)).unwrap(), "2 pixels differ in 4 bytes, by up to 1 levels");
    assert_eq!(compare(&|b| b[5] += 2).unwrap(), "1 pixels differ in 1 bytes, by up to 2 levels");
    assert!(difference(&base(20, 10), &base(10, 20)).unwrap().contains("20 × 10"));
}
