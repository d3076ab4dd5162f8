//! `caustica check`: reads a scene and everything that it names, and renders nothing.

use super::args::SceneArguments;
use super::plan::count_with_noun;
use super::scene::{in_pool, load_with_file};
use super::{Exit, Failure};
use crate::format::SceneFile;
use crate::plan::SceneFeatures;
use crate::scene::Scene;
use glam::Vec2;
use std::io::Write;

/// Camera rays along each side of the picture that look for objects.
const RAYS: u32 = 64;

/// Prints warnings, one line each, and a summary.
pub(super) fn run(arguments: &SceneArguments) -> Result<Exit, Failure> {
    in_pool(arguments, || {
        let (file, scene) = load_with_file(arguments, &())?;
        let mut lines = file.warnings();
        lines.extend(scene_warnings(&scene, arguments));
        let warnings = count_with_noun(lines.len(), "warning", "warnings");
        lines.push(format!("{}: no error, {warnings}", arguments.scene.display()));
        let mut out = std::io::stdout().lock();
        for line in &lines {
            writeln!(out, "{}", printable(line)).map_err(Failure::output)?;
        }
        Ok(Exit::Success)
    })
}

/// Returns the warnings that need no mesh to be read again, one line each; none about a scene
/// without objects, which `render` notes itself.
pub(super) fn cheap_warnings(file: &SceneFile, scene: &Scene, arguments: &SceneArguments) -> Vec<String> {
    let mut lines = file.unused_item_warnings();
    if scene.triangle_count() + scene.shape_count() > 0 {
        lines.extend(scene_warnings(scene, arguments));
    }
    lines.iter().map(|line| printable(line)).collect()
}

/// Returns `line` with control characters replaced.
fn printable(line: &str) -> String {
    line.replace(char::is_control, "\u{fffd}")
}

/// Returns warnings that need the resolved scene, one line each.
fn scene_warnings(scene: &Scene, arguments: &SceneArguments) -> Vec<String> {
    let features = SceneFeatures::from_scene(scene);
    let mut warnings = Vec::new();
    if !sees_objects(scene) {
        warnings.push("the camera sees no object: check `center` and `lookAt` or `direction`");
    }
    if features.lights > 0 && features.receivers == 0 && features.scattering_media == 0 && features.casters > 0 {
        warnings.push("no surface and no medium can receive photons: all materials are specular or black");
    }
    let name = arguments.scene.display();
    warnings.into_iter().map(|warning| format!("{name}: warning: {warning}")).collect()
}

/// True if a ray of a regular grid over the picture hits an object, or a medium fills the scene.
fn sees_objects(scene: &Scene) -> bool {
    let (width, height) = scene.camera().size();
    let position = |i: u32, pixels: u32| (i as f32 + 0.5) / RAYS as f32 * pixels as f32;
    let lens = scene.camera().lens().map(|_| Vec2::splat(0.5));
    scene.ambient_medium().is_some()
        || (0..RAYS * RAYS).any(|i| {
            let point = Vec2::new(position(i % RAYS, width), position(i / RAYS, height));
            scene.intersect(&scene.camera().ray(point, lens)).is_some()
        })
}
