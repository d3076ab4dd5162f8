//! Scale and place: scenes that are huge, tiny, far away or turned show the same picture.

mod ends;
mod floor;
mod paired;
mod similar;

use crate::support::image;
use caustica::color::Rgb;
use caustica::format::SceneFile;
use caustica::format::description::{Group, Item, Object, Shape};
use caustica::integrate::{Algorithm, EyeSettings, FinalGathering, Settings, VolumeEstimate};
use caustica::photon::{PhotonPass, PhotonSource, StoreMask};
use caustica::sampling::{Key, Purpose};
use caustica::scene::Scene;
use glam::DVec3;
use paired::{ROUNDING, objection, summary};
use rayon::prelude::*;
use similar::Similarity;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

const SIZE: (u32, u32) = (32, 24);

/// Passes that are compared: 15 degrees of freedom.
const PASSES: u32 = 16;

/// What a comparison must tell from rounding, as part of the brightest channel of a scene; between scenes whose random
/// numbers stand for other paths twice as much.
const SEEN: f64 = 0.15;

/// Passes whose bits are compared.
const EQUAL_PASSES: u32 = 4;

/// A tenth of a millimetre for a metre, and 2²⁷ times as much: ten and more kilometres.
const SMALL: f64 = 1e-4;
const LARGE: f64 = SMALL * 134_217_728.0;

/// A way that no axis goes, and no axis at all.
const AWAY: DVec3 = DVec3::new(0.71, -0.43, 0.56);
const ASKEW: (DVec3, f64) = (DVec3::new(1.0, 2.0, -1.0), 57.0);

/// The files of scenes/, in the order of their names.
fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let paths = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut found: Vec<PathBuf> = paths.filter(|p| p.extension().is_some_and(|e| e == "txt")).collect();
    found.sort();
    assert!(!found.is_empty(), "scenes/ holds no scenes");
    found
}

fn read(path: &Path) -> SceneFile {
    let mut file = SceneFile::read(path).unwrap();
    (file.description.camera.value.width, file.description.camera.value.height) = SIZE;
    file
}

fn named(name: &str) -> SceneFile {
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("txt"))
}

fn placed(file: &SceneFile, by: &Similarity) -> Scene {
    let mut file = file.clone();
    file.description = by.of(file.description);
    file.resolve().unwrap()
}

/// Fails with what is wrong in any scene; `check` gets its number and its file.
fn each(check: impl Fn(usize, &SceneFile) -> Option<String> + Sync) {
    let name = |path: &Path| path.file_stem().unwrap().to_string_lossy().into_owned();
    let one = |(i, path): (usize, &PathBuf)| Some(format!("{}: {}", name(path), check(i, &read(path))?));
    let wrong: Vec<String> = scenes().par_iter().enumerate().filter_map(one).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn few() -> Settings {
    Settings {
        balance: false,
        photons: 2000,
        caustic_photons: 2000,
        eye: EyeSettings { samples: Some(1), ..EyeSettings::default() },
        ..Settings::default()
    }
}

fn pictures(scene: &Scene, algorithm: Algorithm, settings: Settings, passes: u32) -> Vec<Vec<Rgb>> {
    let integrator = algorithm.prepare(scene, settings);
    (0..passes).map(|pass| image(&*integrator, pass)).collect()
}

fn summaries(images: &[Vec<Rgb>]) -> Vec<Vec<f64>> {
    images.iter().map(|image| summary(image, SIZE)).collect()
}

/// Pixels of which two renders have other bits.
fn differ(a: &[Vec<Rgb>], b: &[Vec<Rgb>]) -> usize {
    let bits = |v: &Rgb| v.to_array().map(f32::to_bits);
    a.iter().flatten().zip(b.iter().flatten()).filter(|(a, b)| bits(a) != bits(b)).count()
}

/// The scene 10⁶ times its size away, and how far its eye may come to lie from where it was. In f64 a coordinate there is rounded by
/// 10⁶·2⁻⁵³ = 1.1·10⁻¹⁰ of the size: in a product of maps, a point under it, a corner of its box, the middle of all, the eye, and what is
/// between them. Single precision rounds by 2⁻²⁴ = 6·10⁻⁸ once the scene is back in its own middle.
fn far_away(file: &SceneFile, scene: &Scene) -> (Scene, f64) {
    let distance = 1e6 * 2.0 * f64::from(scene.domain().radius);
    let moved = placed(file, &Similarity { shift: AWAY * distance, ..Similarity::NONE });
    (moved, 6.0 * AWAY.length() * distance * f64::EPSILON / 2.0)
}

/// SMALL and LARGE are a power of two apart, which changes exponents and no digit: these two are equal to the bit. From the scene as it
/// is they differ by rounding, and by paths that rounding sends another way.
#[test]
fn scaled_and_moved_scenes_give_same_image() {
    each(|number, file| {
        let scene = placed(file, &Similarity::NONE);
        // Pilots of radii take as long as all else: nine of ten scenes go without.
        let radius = |scene: &Scene| (number % 10 > 0).then(|| scene.domain().radius * 0.01);
        let passes =
            |scene: &Scene, n: u32| pictures(scene, Algorithm::Hybrid, Settings { radius: radius(scene), ..few() }, n);
        let render = |scene: &Scene| passes(scene, PASSES);
        let here = summaries(&render(&scene));
        let small = render(&placed(file, &Similarity::scaled(SMALL)));
        let differ = differ(&small, &passes(&placed(file, &Similarity::scaled(LARGE)), EQUAL_PASSES));
        if differ > 0 {
            return Some(format!("{differ} pixels are other bits at 2²⁷ times the scale"));
        }
        if let Some(o) = objection(&summaries(&small), &here, ROUNDING, SEEN) {
            return Some(format!("scaled: {o}"));
        }
        let (moved, left) = far_away(file, &scene);
        let off = moved.camera().center().distance(scene.camera().center());
        if off > left {
            return Some(format!("moved: the eye is {off} off, more than {left}"));
        }
        objection(&summaries(&render(&moved)), &here, ROUNDING, SEEN).map(|o| format!("moved: {o}"))
    });
}

/// Other algorithms and settings, each on a scene that asks much of it.
#[test]
fn no_integrator_depends_on_length_unit() {
    let (eye, base) = (few().eye, few());
    let gauged = EyeSettings { estimate_error: true, adaptive: true, samples: Some(2), ..eye };
    let importance = Settings { final_gathering: FinalGathering::Importance, ..base.clone() };
    let volume = |volume| Settings { volume, ..base.clone() };
    let cases = [
        ("cabinet", Algorithm::Sppm, base.clone()),
        ("garden-pool", Algorithm::Ppm, Settings { eye: gauged.clone(), ..base.clone() }),
        ("still-life", Algorithm::Pm, importance),
        ("lens-in-fog", Algorithm::Pm, volume(VolumeEstimate::Points)),
        ("lens-in-fog", Algorithm::Sppm, volume(VolumeEstimate::Beams)),
        ("smoke", Algorithm::Path, base.clone()),
        ("marbles", Algorithm::Distributed, base.clone()),
        ("textures", Algorithm::Whitted, base.clone()),
        ("matte", Algorithm::Raycast, base.clone()),
        ("goblet", Algorithm::Hybrid, Settings { balance: true, eye: EyeSettings { samples: None, ..gauged }, ..base }),
    ];
    cases.into_par_iter().for_each(|(name, algorithm, settings)| {
        let file = named(name);
        let render = |by| pictures(&placed(&file, &Similarity::scaled(by)), algorithm, settings.clone(), 2);
        let (small, large) = (render(1.0 / 8192.0), render(8192.0));
        let differ = differ(&small, &large);
        assert_eq!(differ, 0, "{name} by {}: pixels of other bits", algorithm.name());
        assert!(small.iter().flatten().any(|v| *v != Rgb::ZERO), "{name} is black");
    });
}

/// Frames of directions, boxes and trees lie otherwise in a turned scene, so other paths are drawn: the same flux in the mean.
#[test]
fn rotated_scenes_have_same_flux_and_radiance() {
    let dark = AtomicU32::new(0);
    each(|_, file| {
        let here = placed(file, &Similarity::NONE);
        let turn = Similarity { turn: (ASKEW.0.normalize(), ASKEW.1), ..Similarity::NONE };
        let there = placed(file, &turn);
        let near =
            if unbounded(&file.description.root) { 0.5 * f64::from(here.domain().radius) } else { f64::INFINITY };
        let middle = here.middle() + here.domain().center.as_dvec3();
        let stored =
            objection(&fluxes(&there, turn.place(middle), near), &fluxes(&here, middle, near), ROUNDING, 2.0 * SEEN);
        // Lamps behind glass are found by chance alone, and media make noise: what is asked of lights shows the same walks.
        let seen = |scene: &Scene| summaries(&pictures(scene, Algorithm::Distributed, few(), PASSES));
        let seen = || {
            let (here, there) = (seen(&here), seen(&there));
            if here.iter().chain(&there).flatten().all(|x| *x == 0.0) {
                dark.fetch_add(1, Relaxed);
                return None;
            }
            objection(&there, &here, ROUNDING, 2.0 * SEEN).map(|o| format!("seen: {o}"))
        };
        stored.map(|o| format!("stored: {o}")).or_else(seen)
    });
    // The rainbow is light through drops alone, which no connection finds.
    assert_eq!(dark.into_inner(), 1, "scenes that show nothing");
}

/// Flux that passes store on surfaces \[W]. Light from infinity lights more of an unbounded plane where the box around the rest is larger, so in
/// scenes with such a plane that counts which comes straight from lights and lies `near` the `middle`.
fn fluxes(scene: &Scene, middle: DVec3, near: f64) -> Vec<Vec<f64>> {
    let source = PhotonSource::everywhere(scene).unwrap();
    let pass =
        PhotonPass { scene, source: &source, mask: StoreMask::ALL, max_bounces: if near.is_finite() { 0 } else { 50 } };
    let one = |index: u32| {
        let key = Key::new(7).purpose(Purpose::Test).with(index.into());
        let traced = pass.trace(key, 4096, &|_| {});
        let inside = traced.photons.iter().filter(|p| (p.position.as_dvec3() + scene.middle()).distance(middle) < near);
        inside.map(|p| p.data.flux().as_dvec3()).sum::<DVec3>().to_array().to_vec()
    };
    (0..PASSES).into_par_iter().map(one).collect()
}

/// Whether there is an unbounded plane.
fn unbounded(group: &Group) -> bool {
    fn is(object: &Object) -> bool {
        match object {
            Object::Group(group) => unbounded(group),
            Object::Transform { object, .. } | Object::Moving { object, .. } => is(object),
            Object::Shape { shape, .. } => matches!(shape, Shape::Plane { .. }),
        }
    }
    group.items.iter().any(|item| matches!(item, Item::Object(object) if is(object)))
}
