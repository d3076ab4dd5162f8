//! Scenes that are huge, tiny, distant or rotated give the same image.

mod ends;
mod floor;
mod paired;
mod similar;

use crate::support::render_one_pass;
use caustica::color::Rgb;
use caustica::format::SceneFile;
use caustica::format::description::{GroupItem, ObjectDescription, ObjectGroup, ShapeDescription};
use caustica::integrate::{Algorithm, CameraPathSettings, FinalGathering, Settings, VolumeEstimator};
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::sampling::{Key, Purpose};
use caustica::scene::Scene;
use glam::DVec3;
use paired::{ROUNDING, mean_difference, summary};
use rayon::prelude::*;
use similar::Similarity;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

const SIZE: (u32, u32) = (32, 24);

/// Number of compared passes: 19 degrees of freedom.
const PASSES: u32 = 20;

/// Number of compared passes of each scene of scenes/, which gives 39 degrees of freedom.
///
/// In the scene cut-stone, light that many facets refract is noisy.
const SCENE_PASSES: u32 = 40;

/// Difference that each comparison must be able to detect, relative to the brightest channel of a
/// scene.
///
/// It is doubled for scenes in which the same random numbers give other paths.
const DETECTABLE: f64 = 0.15;

/// Number of passes whose bits are compared.
const EQUAL_PASSES: u32 = 4;

/// Small scale factor: a tenth of a millimetre per metre.
///
/// [`LARGE`] is 2²⁷ times as much, more than ten kilometres per metre.
const SMALL: f64 = 1e-4;
const LARGE: f64 = SMALL * 134_217_728.0;

/// A direction that is parallel to no axis.
const AWAY: DVec3 = DVec3::new(0.71, -0.43, 0.56);
/// Axis, of any length, and angle \[degrees] of a rotation that maps no axis to an axis.
const OBLIQUE_ROTATION: (DVec3, f64) = (DVec3::new(1.0, 2.0, -1.0), 57.0);

/// Returns the files of scenes/, sorted by name.
fn scene_paths() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let paths = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut found: Vec<PathBuf> = paths.filter(|p| p.extension().is_some_and(|e| e == "txt")).collect();
    found.sort();
    assert!(!found.is_empty(), "scenes/ holds no scenes");
    found
}

fn read_scene_file(path: &Path) -> SceneFile {
    let mut file = SceneFile::read(path).unwrap();
    (file.description.camera.value.width, file.description.camera.value.height) = SIZE;
    file
}

fn scene_file_by_name(name: &str) -> SceneFile {
    read_scene_file(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("txt"))
}

fn transformed_scene(file: &SceneFile, by: &Similarity) -> Scene {
    let mut file = file.clone();
    file.description = by.of(file.description);
    file.resolve().unwrap()
}

/// Calls `check` with each scene and its number; fails with all messages that it returns.
fn check_each_scene(check: impl Fn(usize, &SceneFile) -> Option<String> + Sync) {
    let name = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
    let one = |(i, path): (usize, &PathBuf)| Some(format!("{}: {}", name(path), check(i, &read_scene_file(path))?));
    let wrong: Vec<String> = scene_paths().par_iter().enumerate().filter_map(one).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn low_cost_settings() -> Settings {
    Settings {
        allows_ray_photon_balance: false,
        unaimed_paths: 2000,
        aimed_paths: 2000,
        camera_paths: CameraPathSettings { samples_per_pixel: Some(1), ..CameraPathSettings::default() },
        ..Settings::default()
    }
}

fn pictures(scene: &Scene, algorithm: Algorithm, settings: Settings, passes: u32) -> Vec<Vec<Rgb>> {
    let integrator = algorithm.prepare(scene, settings);
    (0..passes).map(|pass| render_one_pass(&*integrator, pass)).collect()
}

fn summaries(images: &[Vec<Rgb>]) -> Vec<Vec<f64>> {
    images.iter().map(|image| summary(image, SIZE)).collect()
}

/// Returns the number of pixels whose bits differ between two renders.
fn count_differing_pixels(a: &[Vec<Rgb>], b: &[Vec<Rgb>]) -> usize {
    let bits = |v: &Rgb| v.to_array().map(f32::to_bits);
    a.iter().flatten().zip(b.iter().flatten()).filter(|(a, b)| bits(a) != bits(b)).count()
}

/// Returns the scene moved away by 10⁶ times its size. Also returns how far rounding may have moved
/// its camera.
///
/// A coordinate at that distance rounds in f64 by 10⁶·2⁻⁵³ = 1.1·10⁻¹⁰ of the size. This happens
/// several times: in transforms, points, the bounding box, the center, the camera, and their
/// differences. After the scene is recentered, single precision rounds by 2⁻²⁴ = 6·10⁻⁸.
fn far_away(file: &SceneFile, scene: &Scene) -> (Scene, f64) {
    let distance = 1e6 * 2.0 * f64::from(scene.photon_domain().radius);
    let moved = transformed_scene(file, &Similarity { shift: AWAY * distance, ..Similarity::NONE });
    (moved, 6.0 * AWAY.length() * distance * f64::EPSILON / 2.0)
}

/// Scenes that are scaled or moved far away give the same image.
///
/// [`SMALL`] and [`LARGE`] differ by a power of two, which changes exponents only. So both images
/// are equal bit for bit. They differ from the original by rounding, and by paths that rounding
/// redirects.
#[test]
#[ignore = "long: every scene at four scales"]
fn scaled_and_moved_scenes_give_same_image() {
    check_each_scene(|number, file| {
        let scene = transformed_scene(file, &Similarity::NONE);
        // Pilots that find gather radii take as long as all passes. So nine of ten scenes have a
        // fixed radius.
        let radius = |scene: &Scene| (number % 10 > 0).then(|| scene.photon_domain().radius * 0.01);
        let passes = |scene: &Scene, n: u32| {
            pictures(
                scene,
                Algorithm::Hybrid,
                Settings { initial_gather_radius: radius(scene), ..low_cost_settings() },
                n,
            )
        };
        let render = |scene: &Scene| passes(scene, SCENE_PASSES);
        let here = summaries(&render(&scene));
        let small = render(&transformed_scene(file, &Similarity::scaled(SMALL)));
        let differ =
            count_differing_pixels(&small, &passes(&transformed_scene(file, &Similarity::scaled(LARGE)), EQUAL_PASSES));
        if differ > 0 {
            return Some(format!("{differ} pixels are other bits at 2²⁷ times the scale"));
        }
        if let Some(o) = mean_difference(&summaries(&small), &here, ROUNDING, DETECTABLE) {
            return Some(format!("scaled: {o}"));
        }
        let (moved, left) = far_away(file, &scene);
        let off = moved.camera().center().distance(scene.camera().center());
        if off > left {
            return Some(format!("moved: the eye is {off} off, more than {left}"));
        }
        mean_difference(&summaries(&render(&moved)), &here, ROUNDING, DETECTABLE).map(|o| format!("moved: {o}"))
    });
}

/// No integrator or setting depends on the unit of length. Each is tested with a demanding scene.
#[test]
fn no_integrator_depends_on_length_unit() {
    let (eye, base) = (low_cost_settings().camera_paths, low_cost_settings());
    let estimated = CameraPathSettings { estimate_error: true, adaptive: true, samples_per_pixel: Some(2), ..eye };
    let importance = Settings { final_gathering: FinalGathering::Importance, ..base.clone() };
    let volume = |volume| Settings { volume_estimator: volume, ..base.clone() };
    let cases = [
        ("cabinet", Algorithm::Sppm, base.clone()),
        ("garden-pool", Algorithm::Ppm, Settings { camera_paths: estimated.clone(), ..base.clone() }),
        ("still-life", Algorithm::Pm, importance),
        ("lens-in-fog", Algorithm::Pm, volume(VolumeEstimator::Points)),
        ("lens-in-fog", Algorithm::Sppm, volume(VolumeEstimator::Beams)),
        ("smoke", Algorithm::Path, base.clone()),
        ("marbles", Algorithm::Distributed, base.clone()),
        ("textures", Algorithm::Whitted, base.clone()),
        ("matte", Algorithm::Raycast, base.clone()),
        (
            "goblet",
            Algorithm::Hybrid,
            Settings {
                allows_ray_photon_balance: true,
                camera_paths: CameraPathSettings { samples_per_pixel: None, ..estimated },
                ..base
            },
        ),
    ];
    cases.into_par_iter().for_each(|(name, algorithm, settings)| {
        let file = scene_file_by_name(name);
        let render = |by| pictures(&transformed_scene(&file, &Similarity::scaled(by)), algorithm, settings.clone(), 2);
        let (small, large) = (render(1.0 / 8192.0), render(8192.0));
        let differ = count_differing_pixels(&small, &large);
        assert_eq!(differ, 0, "{name} by {}: pixels of other bits", algorithm.name());
        assert!(small.iter().flatten().any(|v| *v != Rgb::ZERO), "{name} is black");
    });
}

/// Rotated scenes have the same mean flux and radiance.
///
/// Frames of directions, bounding boxes and trees differ in a rotated scene, so other paths are
/// sampled.
#[test]
#[ignore = "long: t-tests of every scene"]
fn rotated_scenes_have_same_flux_and_radiance() {
    let dark = AtomicU32::new(0);
    check_each_scene(|_, file| {
        let here = transformed_scene(file, &Similarity::NONE);
        let turn = Similarity { turn: (OBLIQUE_ROTATION.0.normalize(), OBLIQUE_ROTATION.1), ..Similarity::NONE };
        let there = transformed_scene(file, &turn);
        let near = if unbounded(&file.description.root) {
            0.5 * f64::from(here.photon_domain().radius)
        } else {
            f64::INFINITY
        };
        let middle = here.origin() + here.photon_domain().center.as_dvec3();
        let stored = mean_difference(
            &stored_fluxes(&there, turn.place(middle), near),
            &stored_fluxes(&here, middle, near),
            ROUNDING,
            2.0 * DETECTABLE,
        );
        // Only direct light is compared in images. Path tracing finds lights behind glass only by
        // chance, and media are noisy.
        let seen = |scene: &Scene| summaries(&pictures(scene, Algorithm::Distributed, low_cost_settings(), PASSES));
        let seen = || {
            let (here, there) = (seen(&here), seen(&there));
            if here.iter().chain(&there).flatten().all(|x| *x == 0.0) {
                dark.fetch_add(1, Relaxed);
                return None;
            }
            mean_difference(&there, &here, ROUNDING, 2.0 * DETECTABLE).map(|o| format!("seen: {o}"))
        };
        stored.map(|o| format!("stored: {o}")).or_else(seen)
    });
    // One scene shows no direct light: all light of the rainbow passes through drops, which
    // next-event estimation cannot do.
    assert_eq!(dark.into_inner(), 1, "scenes that show nothing");
}

/// Returns the flux that each pass stores on surfaces \[W].
///
/// Light from infinity reaches more of an unbounded plane if the bounding box of the other objects
/// is larger. So in scenes with such a plane, only direct light within `near` of `middle` counts.
fn stored_fluxes(scene: &Scene, middle: DVec3, near: f64) -> Vec<Vec<f64>> {
    let source = PhotonSource::emitting_in_all_directions(scene).unwrap();
    let tracer = PhotonTracer {
        scene,
        source: &source,
        mask: StoreMask::ALL,
        max_bounces: if near.is_finite() { 0 } else { 50 },
    };
    let one = |index: u32| {
        let key = Key::new(7).purpose_key(Purpose::Test).child_key(index.into());
        let traced = tracer.trace(key, 4096, &|_| {});
        let inside = traced
            .deposits
            .surface_photons
            .iter()
            .filter(|p| (p.position.as_dvec3() + scene.origin()).distance(middle) < near);
        inside.map(|p| p.attributes.flux().as_dvec3()).sum::<DVec3>().to_array().to_vec()
    };
    (0..PASSES).into_par_iter().map(one).collect()
}

/// Returns true if the group holds an unbounded plane.
fn unbounded(group: &ObjectGroup) -> bool {
    fn is(object: &ObjectDescription) -> bool {
        match object {
            ObjectDescription::Group(group) => unbounded(group),
            ObjectDescription::Transform { object, .. } | ObjectDescription::Moving { object, .. } => is(object),
            ObjectDescription::Shape { shape, .. } => matches!(shape, ShapeDescription::Plane(_)),
        }
    }
    group.items.iter().any(|item| matches!(item, GroupItem::Object(object) if is(object)))
}
