//! Switching off unneeded effects changes no bit of pictures of the repository's and the course's
//! scenes.

use super::compare::{RenderSettings, difference};
use crate::support::{self, project_path};
use caustica::format::SceneFile;
use caustica::integrate::Algorithm;
use caustica::plan::{EffectOverrides, Plan};
use caustica::scene::{Effect, Scene};
use std::fs;
use std::path::{Path, PathBuf};

const SIZE: (u32, u32) = (16, 12);

/// Returns the scene files of a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let paths = entries.map(|e| e.unwrap().path());
    let mut files: Vec<PathBuf> = paths.filter(|p| p.extension().is_some_and(|e| e == "txt")).collect();
    files.sort();
    assert!(!files.is_empty(), "{} holds no scenes", folder.display());
    files
}

fn read(path: &Path) -> Result<Scene, String> {
    let mut file = SceneFile::read(path).map_err(|e| e.to_string())?;
    (file.description.camera.value.width, file.description.camera.value.height) = SIZE;
    file.resolve().map_err(|e| e.to_string())
}

/// Renders a scene with each integrator, as planned and with all effects on.
///
/// Returns a message for each integrator whose pictures differ.
fn differences(path: &Path, scene: &Scene, algorithms: &[Algorithm]) -> Vec<String> {
    let bounces = |algorithm| if algorithm == Algorithm::Sppm { 1 } else { 100 };
    let how = |algorithm| RenderSettings { max_bounces: bounces(algorithm), ..RenderSettings::new(algorithm) };
    let found = algorithms.iter().filter_map(|a| difference(scene, &how(*a), EffectOverrides::ALL_FORCED_ON));
    found.map(|d| format!("{}: {d}", path.display())).collect()
}

/// Pictures of the repository's scenes have the same bits with all effects on.
///
/// Pilots of large meshes take most of the time. So each scene is rendered only by the default
/// integrator and one other.
#[test]
#[ignore = "long: renders of many scenes"]
fn shipped_scenes_match_with_all_effects_on() {
    let mut wrong = Vec::new();
    let paths = ["scenes", "tests/scenes"].into_iter().flat_map(|folder| files(&project_path(folder)));
    for (i, path) in paths.enumerate() {
        let scene = read(&path).unwrap();
        let others = &Algorithm::ALL[1..];
        wrong.extend(differences(&path, &scene, &[Algorithm::Hybrid, others[i % others.len()]]));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// Returns the course's scenes; none if they are absent and may be skipped.
fn course() -> Vec<(PathBuf, Scene)> {
    let Some(folder) = support::course_data_folder("testcases") else { return Vec::new() };
    let scene = |path: PathBuf| match read(&path) {
        Ok(scene) => (path, scene),
        Err(error) => panic!("{}: {error}", path.display()),
    };
    let scenes: Vec<(PathBuf, Scene)> = files(&folder).into_iter().map(scene).collect();
    assert_eq!(scenes.len(), 10, "the course has ten scenes");
    scenes
}

#[test]
#[ignore = "long: renders of many scenes"]
fn course_scenes_match_with_all_effects_on() {
    let wrong: Vec<String> =
        course().iter().flat_map(|(path, scene)| differences(path, scene, &Algorithm::ALL)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// Effects, each with words of the scene language. A scene needs the effect only if its text has
/// one of these words.
const NEEDS: [(Effect, &[&str]); 12] = [
    (Effect::Specular, &["Mirror", "Dielectric", "Thin", "Conductor"]),
    (Effect::Caustics, &["Mirror", "Dielectric", "Thin", "Conductor"]),
    (Effect::CausticBounces, &["Mirror", "Dielectric", "Thin", "Conductor"]),
    (Effect::Interiors, &["Dielectric"]),
    (Effect::SoftShadows, &["SphereLight", "DiscLight", "RectangleLight", "EnvironmentLight", "emission"]),
    (Effect::Environment, &["EnvironmentLight"]),
    (Effect::Lens, &["aperture", "fNumber"]),
    (Effect::Motion, &["Moving"]),
    (Effect::Textures, &["Textures", "texture"]),
    (Effect::Bump, &["bump", "normalMap"]),
    (Effect::Media, &["medium"]),
    (Effect::Dispersion, &["glass", "abbe", "cauchy", "sellmeier"]),
];

#[test]
fn course_plans_match_scene_text() {
    for (path, scene) in course() {
        let text = fs::read_to_string(&path).unwrap();
        for algorithm in Algorithm::ALL {
            let plan = Plan::new(&scene, algorithm.supported_effects(), EffectOverrides::NO_OVERRIDES);
            for decision in plan.decisions {
                let needs = NEEDS.iter().find(|(effect, _)| *effect == decision.effect).map(|(_, words)| *words);
                // In the course's scenes, each of these words causes its effect, unless the scene
                // has no object.
                if needs.is_none() && scene.object_summaries().next().is_none() {
                    continue;
                }
                let there = needs.is_none_or(|words| words.iter().any(|w| text.contains(w)));
                let expected = there && algorithm.supported_effects().has(decision.effect);
                let name = path.file_name().unwrap().to_string_lossy();
                assert_eq!(decision.is_simulated, expected, "{name}, {}: {}", algorithm.name(), decision.effect);
            }
        }
    }
}
