//! Frames of a turntable: their arguments and their renders.

use super::render_scene;
use super::series::render_series;
use crate::cli::frames::{FrameNameError, Turntable, frame_path};
use crate::cli::progress::ProgressDisplay;
use crate::cli::{CommandFailure, Exit, FrameRange, RenderArguments};
use crate::format::description::CameraDescription;
use crate::scene::Scene;
use std::time::Instant;

/// Renders the frames `range` of the turntable around `scene`, and writes all their outputs. Ends
/// early if a frame fails or is interrupted. A frame that cannot be written does not end the
/// series.
///
/// `camera` is the camera of frame 0 as the scene describes it.
pub(super) fn render_frames(
    arguments: &RenderArguments,
    range: FrameRange,
    scene: &Scene,
    camera: &CameraDescription,
    progress: &ProgressDisplay,
) -> Result<Exit, CommandFailure> {
    let turntable = Turntable::new(scene, camera, arguments.turn.unwrap_or(range.end));
    let turntable = turntable.map_err(CommandFailure::usage_error)?;
    render_series(range.numbers(), |frame| {
        progress.print_line(&format!("frame {frame} of {} to {}", range.first, range.end - 1));
        let arguments = frame_arguments(arguments, frame).map_err(CommandFailure::usage_error)?;
        let turned = turntable.camera(frame).map(|camera| scene.with_camera(&camera));
        render_scene(
            &arguments,
            turned.as_ref().unwrap_or(scene),
            None,
            Instant::now(),
            progress,
            #[cfg(feature = "view")]
            None,
        )
    })
}

/// Returns the arguments of one frame of `--frames`. Each frame has its own output files, and its
/// own seed, so that the noise differs from frame to frame.
pub(super) fn frame_arguments(arguments: &RenderArguments, frame: u32) -> Result<RenderArguments, FrameNameError> {
    let mut of_frame = arguments.clone();
    of_frame.method.seed = arguments.method.seed.wrapping_add(frame.into());
    let paths = of_frame.output.iter_mut().map(|path| ("-o", path));
    let paths = paths.chain(of_frame.aov.iter_mut().map(|path| ("--aov", path)));
    for (flag, path) in paths.chain(of_frame.stats.iter_mut().map(|path| ("--stats", path))) {
        *path = frame_path(flag, path, frame)?;
    }
    Ok(of_frame)
}
