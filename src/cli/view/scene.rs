//! Reads the scene of `caustica view`, with its text and errors for the page.

use super::ViewArguments;
use super::watch::{WatchedFileCollector, WatchedFiles};
use crate::cli::CommandFailure;
use crate::cli::check::quick_scene_warnings;
use crate::cli::scene::{read_resized_scene_file, resolve_scene_file_incrementally};
use crate::format::description::SceneDescription;
use crate::format::{ResolvedScene, SceneError, SceneFile, SceneReadError};
use crate::view::{SceneProblem, SceneSource};
use glam::DVec3;
use miette::Report;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// Largest length \[bytes] of a scene text that the page shows. Longer texts are not shown.
const MAX_SOURCE_BYTES: u64 = 1 << 20;

/// A scene that was read without an error, with its files.
pub(super) struct LoadedScene {
    pub resolved: ResolvedScene,
    pub description: SceneDescription,
    /// The scene file and the files that it names, with their modification times and lengths before
    /// reading.
    pub files: WatchedFiles,
}

impl LoadedScene {
    /// Returns the up vector of the camera, in the coordinates of the scene file.
    pub fn up_vector(&self) -> DVec3 {
        self.description.camera.up
    }
}

/// Result of reading a scene: its text and errors, its files, and the scene itself if it has no
/// error.
pub(super) struct SceneReadResult {
    pub source: SceneSource,
    pub files: WatchedFiles,
    pub loaded: Option<Arc<LoadedScene>>,
}

/// Reads and builds the scene that the command line names.
///
/// Unchanged parts are shared with the `previous` scene: everything but the camera if only the
/// camera differs (see [`scene_with_new_camera`]), or else unchanged meshes and bounding volume
/// hierarchies.
pub(super) fn read_scene(arguments: &ViewArguments, previous: Option<&LoadedScene>) -> SceneReadResult {
    let path = &arguments.scene.scene;
    let name = path.display().to_string();
    let monitor = WatchedFileCollector::new(path);
    let read = read_resized_scene_file(&arguments.scene, &monitor).and_then(|file| {
        if let Some((resolved, previous)) =
            previous.and_then(|previous| Some((scene_with_new_camera(&file, previous)?, previous)))
        {
            return Ok((file, resolved, Some(&previous.files)));
        }
        let earlier = previous.map(|previous| &previous.resolved);
        let resolved = resolve_scene_file_incrementally(earlier, &file, &arguments.scene, &monitor)?;
        Ok((file, resolved, None))
    });
    let mut files = monitor.into_files();
    match read {
        Ok((file, resolved, reused)) => {
            reused.into_iter().for_each(|reused| files.add_all(reused));
            let text = file.source.scene_text();
            let text = if text.len() as u64 <= MAX_SOURCE_BYTES { text } else { "" };
            let warnings = quick_scene_warnings(&file, &resolved.scene, &arguments.scene);
            let source = SceneSource { path: name, text: text.into(), problems: Vec::new(), warnings };
            let loaded = LoadedScene { resolved, description: file.description, files: files.clone() };
            SceneReadResult { source, files, loaded: Some(Arc::new(loaded)) }
        }
        Err(CommandFailure { reports, .. }) => {
            let problems = reports.iter().flat_map(problems_of_report).collect();
            let source = SceneSource { path: name, text: text_of_file(path).into(), problems, warnings: Vec::new() };
            SceneReadResult { source, files, loaded: None }
        }
    }
}

/// Returns the scene of `previous` with the camera of `file`, if only the camera has changed.
///
/// Returns `None` if one of these holds:
/// - More than the camera of the scene description has changed.
/// - A file that the scene names has changed.
/// - The camera moves while the shutter is open, or is invalid.
/// - `file` embeds meshes, pictures or grids.
fn scene_with_new_camera(file: &SceneFile, previous: &LoadedScene) -> Option<ResolvedScene> {
    let mut old = previous.description.clone();
    old.camera.clone_from(&file.description.camera);
    let is_still = file.description.camera.motion.is_empty();
    if !is_still || !file.assets.is_empty() || old != file.description || !previous.files.has_unchanged_inputs() {
        return None;
    }
    let camera = file.resolve_camera().ok()?;
    let ResolvedScene { scene, meshes } = &previous.resolved;
    Some(ResolvedScene { scene: scene.with_camera(&camera), meshes: meshes.clone() })
}

/// Returns the text of a file; empty if it cannot be read, is longer than [`MAX_SOURCE_BYTES`], or
/// is not UTF-8.
fn text_of_file(path: &Path) -> String {
    let is_short = fs::metadata(path).is_ok_and(|data| data.is_file() && data.len() <= MAX_SOURCE_BYTES);
    if is_short { fs::read_to_string(path).unwrap_or_default() } else { String::new() }
}

/// Returns one [`SceneProblem`] for each error that `report` holds. Only errors in the content of a
/// scene file have a position in the file.
fn problems_of_report(report: &Report) -> Vec<SceneProblem> {
    let error = match report.downcast_ref::<SceneReadError>() {
        Some(SceneReadError::InvalidContent(error)) => Some(error),
        Some(SceneReadError::Unreadable { .. } | SceneReadError::OutOfMemory { .. }) => None,
        None => report.downcast_ref::<SceneError>(),
    };
    let Some(first) = error else { return vec![problem_of_report(report)] };
    let problem = |error: &SceneError| SceneProblem {
        line: error.line(),
        column: error.column(),
        message: error.message().to_owned(),
        remedy: error.remedy().to_owned(),
    };
    std::iter::once(first).chain(first.further_errors()).map(problem).collect()
}

/// Converts an error report to a [`SceneProblem`] that has no position in the scene file.
pub(super) fn problem_of_report(report: &Report) -> SceneProblem {
    let causes: Vec<String> = report.chain().map(ToString::to_string).collect();
    let remedy = report.help().map_or(String::new(), |help| help.to_string());
    SceneProblem { line: 0, column: 0, message: causes.join(": "), remedy }
}
