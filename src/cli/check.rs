//! `caustica check`: reads a scene and everything that it names, and renders nothing.

use super::scene::{import_warnings, load_scene_and_file, replace_control_characters, with_thread_pool};
use super::scene_args::SceneArguments;
use super::value_parsers::count_with_noun;
use super::{CommandFailure, Exit};
use crate::format::SceneFile;
use crate::plan::SceneFeatures;
use crate::scene::Scene;
use glam::Vec2;
use std::io::Write;

/// Side length n of the grid of n × n camera rays that test whether the camera sees any object.
const RAYS_PER_SIDE: u32 = 64;

/// Runs `caustica check`: prints one line for each warning, and a summary.
pub(super) fn run(arguments: &SceneArguments) -> Result<Exit, CommandFailure> {
    with_thread_pool(arguments, || {
        let (file, scene) = load_scene_and_file(arguments, &())?;
        let mut lines = import_warnings(&file);
        lines.extend(file.warnings());
        lines.extend(visibility_and_receiver_warnings(&scene, arguments));
        let warnings = count_with_noun(lines.len(), "warning", "warnings");
        lines.push(format!("{}: no error, {warnings}", arguments.scene.display()));
        let mut out = std::io::stdout().lock();
        for line in &lines {
            writeln!(out, "{}", replace_control_characters(line)).map_err(CommandFailure::output_error)?;
        }
        Ok(Exit::Success)
    })
}

/// Returns the scene warnings that `caustica render` prints before it renders, one line each.
///
/// Leaves out two kinds of warnings of `caustica check`. Warnings of one kind need meshes to be
/// read again. The other warning is about a scene without objects: `caustica render` prints it
/// itself.
pub(super) fn quick_scene_warnings(file: &SceneFile, scene: &Scene, arguments: &SceneArguments) -> Vec<String> {
    let mut lines = import_warnings(file);
    lines.extend(file.unused_item_warnings());
    if scene.triangle_count() + scene.analytic_shape_count() > 0 {
        lines.extend(visibility_and_receiver_warnings(scene, arguments));
    }
    lines.iter().map(|line| replace_control_characters(line)).collect()
}

/// Returns up to two warnings, one line each. The first says that the camera sees no object. The
/// second says that no surface or medium can store photons, although the scene has lights and
/// specular objects.
fn visibility_and_receiver_warnings(scene: &Scene, arguments: &SceneArguments) -> Vec<String> {
    let features = SceneFeatures::from_scene(scene);
    let mut warnings = Vec::new();
    if !camera_sees_objects(scene) {
        warnings.push("the camera sees no object: check `center` and `lookAt` or `direction`");
    }
    if features.lights > 0 && features.receivers == 0 && features.scattering_media == 0 && features.casters > 0 {
        warnings.push("no surface and no medium can receive photons: all materials are specular or black");
    }
    let name = arguments.scene.display();
    warnings.into_iter().map(|warning| format!("{name}: warning: {warning}")).collect()
}

/// True if any camera ray of a regular grid over the picture hits an object, or if a medium fills
/// the space outside all objects.
fn camera_sees_objects(scene: &Scene) -> bool {
    let (width, height) = scene.camera().size();
    let position = |i: u32, pixels: u32| (i as f32 + 0.5) / RAYS_PER_SIDE as f32 * pixels as f32;
    let lens = scene.camera().lens().map(|_| Vec2::splat(0.5));
    scene.ambient_medium().is_some()
        || (0..RAYS_PER_SIDE * RAYS_PER_SIDE).any(|i| {
            let point = Vec2::new(position(i % RAYS_PER_SIDE, width), position(i / RAYS_PER_SIDE, height));
            scene.intersect(&scene.camera().generate_ray(point, lens)).is_some()
        })
}
