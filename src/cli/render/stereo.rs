//! The two pictures of `--stereo`: their arguments, their cameras and their renders.

use super::render_scene;
use super::series::render_series;
use crate::cli::progress::ProgressDisplay;
use crate::cli::{CommandFailure, Exit, RenderArguments};
use crate::format::description::CameraDescription;
use crate::scene::Scene;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Suffixes of the output file names of the left and of the right picture.
const NAME_SUFFIXES: [&str; 2] = ["-left", "-right"];

/// Error: the camera of a stereo pair moves while the shutter is open.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--stereo cannot move a camera that moves while the shutter is open")]
#[diagnostic(help("remove Moving around the camera"))]
struct MovingStereoCameraError;

/// Error: the camera of a stereo pair is orthographic or a panorama.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--stereo needs a perspective camera")]
#[diagnostic(help("use PerspectiveCamera: a shift of other cameras shows no depth"))]
struct StereoProjectionError;

/// Renders the pictures of the left and of the right eye, and writes all their outputs. If the left
/// picture fails or is interrupted, the right one is not rendered. If only the writing of the left
/// picture fails, the right one is still rendered.
///
/// The cameras are parallel and `distance` apart \[scene units]. `camera` is the camera midway
/// between the eyes, in the coordinates of the scene description.
pub(super) fn render_stereo_pair(
    arguments: &RenderArguments,
    distance: f32,
    scene: &Scene,
    camera: &CameraDescription,
    progress: &ProgressDisplay,
) -> Result<Exit, CommandFailure> {
    if !camera.motion.is_empty() {
        return Err(CommandFailure::usage_error(MovingStereoCameraError));
    }
    let cameras = scene.camera_in_description().stereo_pair(distance.into());
    let cameras = cameras.ok_or_else(|| CommandFailure::usage_error(StereoProjectionError))?;
    let eyes = ["left", "right"].iter().zip(arguments_of_eyes(arguments)).zip(cameras);
    render_series(eyes, |((eye, arguments), camera)| {
        progress.print_line(&format!("picture of the {eye} eye"));
        render_scene(
            &arguments,
            &scene.with_camera(&camera),
            None,
            Instant::now(),
            progress,
            #[cfg(feature = "view")]
            None,
        )
    })
}

/// Returns the arguments of the left and of the right picture, each with its own output files and
/// seed. With equal seeds, both eyes would see equal noise, which would look like a surface.
pub(super) fn arguments_of_eyes(arguments: &RenderArguments) -> [RenderArguments; 2] {
    let mut of_eyes = [arguments.clone(), arguments.clone()];
    of_eyes[1].method.seed = arguments.method.seed.wrapping_add(1);
    for (of_eye, suffix) in of_eyes.iter_mut().zip(NAME_SUFFIXES) {
        for path in of_eye.output.iter_mut().chain(&mut of_eye.aov).chain(&mut of_eye.stats) {
            *path = path_with_suffix(path, suffix);
        }
    }
    of_eyes
}

/// Returns `path` with `suffix` after the name of the file, before its extension.
fn path_with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(suffix);
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}
