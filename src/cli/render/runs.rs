//! The renders that one command line asks for, each with its own files: one render, or those of
//! `--frames` or `--stereo`.

use super::stereo::arguments_of_eyes;
use super::turntable::frame_arguments;
use crate::cli::outputs::FileWithRole;
use crate::cli::{CommandFailure, RenderArguments};

/// Returns the arguments of each render that the command line asks for: one per frame of
/// `--frames`, one per eye of `--stereo`, or else a copy of `arguments`.
pub(super) fn arguments_of_renders(arguments: &RenderArguments) -> Result<Vec<RenderArguments>, CommandFailure> {
    if let Some(range) = arguments.frames {
        let frames = range.numbers().map(|frame| frame_arguments(arguments, frame));
        return frames.map(|arguments| arguments.map_err(CommandFailure::usage_error)).collect();
    }
    match arguments.stereo {
        Some(_) => Ok(arguments_of_eyes(arguments).into()),
        None => Ok(vec![arguments.clone()]),
    }
}

/// Returns the output files of all renders that the command line asks for.
pub(super) fn output_files(arguments: &RenderArguments) -> Result<Vec<FileWithRole>, CommandFailure> {
    let files = |arguments: &RenderArguments| -> Vec<FileWithRole> {
        let pictures = arguments.output.iter().map(|path| FileWithRole::new("-o", path));
        let layers = arguments.aov.iter().map(|path| FileWithRole::new("--aov", path));
        let report = arguments.stats.iter().map(|path| FileWithRole::new("--stats", path));
        let film = arguments.film.iter().map(|path| FileWithRole::new("--film", path));
        pictures.chain(layers).chain(report).chain(film).collect()
    };
    Ok(arguments_of_renders(arguments)?.iter().flat_map(files).collect())
}

/// Returns the input files that the command line names: the scene file and `--reference`.
pub(super) fn named_inputs(arguments: &RenderArguments) -> Vec<FileWithRole> {
    let scene = FileWithRole::new("the scene file", &arguments.scene.scene);
    #[cfg(feature = "view")]
    let reference = arguments.reference.iter().map(|path| FileWithRole::new("--reference", path));
    #[cfg(not(feature = "view"))]
    let reference = std::iter::empty();
    std::iter::once(scene).chain(reference).collect()
}
