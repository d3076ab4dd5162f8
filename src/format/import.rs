//! The interface of scene importers: trait, result and errors.

use super::assets::EmbeddedAssets;
use super::description::SceneDescription;
use super::mesh::MeshReadMonitor;
use super::{SceneError, SourceText};
use crate::stats::{MemoryLimit, format_bytes};
use std::path::{Path, PathBuf};

/// Reader of scenes in one file format.
///
/// To add a format, implement this trait. Then add the type to [`IMPORTERS`](super::IMPORTERS), and
/// remove its extensions from the lists of unread formats in `file_extensions.rs`.
///
/// An importer makes the checks that the parser of the scene language makes. Values lie in the
/// ranges that [`description`](super::description) states, and groups nest at most
/// [`MAX_NESTING_DEPTH`](super::MAX_NESTING_DEPTH) deep. An embedded asset takes the place of a
/// file of the same path, so the paths in [`EmbeddedAssets`] must differ from those of files.
/// `import_notes.rs` collects messages about unsupported content. `imported_files.rs` opens files
/// and checks permission and memory. `imported_materials.rs` gives materials unique names, and
/// checks mixes. `imported_metals.rs` finds metals by their chemical symbols.
/// `imported_environment.rs` resamples environment maps. `default_camera.rs` makes a camera for a
/// file that has none.
///
/// Each importer has three tests of malformed files:
///
/// - a function in `tests/it/robustness/input/readers.rs`,
/// - a folder in `tests/corpus/`, which `tests/it/robustness/input/corpus.rs` lists,
/// - a fuzz target in `fuzz/fuzz_targets/`, which `fuzz/Cargo.toml` lists.
pub trait SceneImporter: Sync {
    /// Returns the name of the scene format, for messages.
    fn name(&self) -> &'static str;

    /// Returns the file extensions of the format, in lower case and without the dot.
    fn extensions(&self) -> &'static [&'static str];

    /// Reads the scene file at `path`, and returns the scene as a description.
    ///
    /// An importer that opens further files, such as buffers or included scenes, reports each to
    /// [`MeshReadMonitor::on_input_file_found`] before it reads the file. The program then refuses
    /// an output that would overwrite the file.
    ///
    /// # Errors
    /// [`SceneReadError`] if a file is malformed, if the scene would exceed the memory limit of
    /// `options`, or if the scene names a file outside its own folder and `options` do not allow
    /// this. The [`SceneError`] of a binary format may lack a position.
    fn import(
        &self,
        path: &Path,
        monitor: &dyn MeshReadMonitor,
        options: &ImportOptions,
    ) -> Result<ImportedScene, SceneReadError>;
}

/// Settings for reading a scene file.
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// Limit of the memory that the scene may take.
    pub memory_limit: MemoryLimit,
    /// File extension that selects the importer, in lower case and without the dot; `None` for the
    /// extension of the file itself.
    pub format_extension: Option<String>,
    /// True if a scene file of another program's format may name files outside its own folder.
    pub allows_outside_files: bool,
}

/// Message to the user about content of a scene file that was ignored, approximated or added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportNote {
    /// The message: what was found, how often, and what was done.
    pub message: String,
    /// True if the file asks for something that is ignored or approximated. False if the file
    /// leaves something out, such as a camera.
    pub concerns_unsupported_content: bool,
}

/// A scene that an importer read from a file.
#[derive(Clone, Debug)]
pub struct ImportedScene {
    /// Description of the scene.
    pub description: SceneDescription,
    /// Text that the spans of the description refer to; empty for a binary format.
    pub source: SourceText,
    /// Meshes, pictures and density grids that the scene file itself contains.
    pub assets: EmbeddedAssets,
    /// Messages about content that was ignored, approximated or added.
    pub notes: Vec<ImportNote>,
}

/// Reason why a scene file could not be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SceneReadError {
    /// The scene file, or a file that it names, could not be opened or read.
    #[error("cannot read `{}`", path.display())]
    #[diagnostic(help("check the path and its permissions"))]
    Unreadable {
        /// Path of the file: the scene file, or a file that it names.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The scene would exceed the memory limit.
    #[error("`{}` takes about {} of memory, and {} are free", path.display(), format_bytes(*needed), format_bytes(*free))]
    #[diagnostic(help("put large parts into meshes, or allow more memory (--memory)"))]
    OutOfMemory {
        /// Path of the scene file, or of a file that it names.
        path: PathBuf,
        /// Estimated memory of the scene \[bytes].
        needed: u64,
        /// Free memory \[bytes].
        free: u64,
    },
    /// The content of the file has errors.
    #[error(transparent)]
    #[diagnostic(transparent)]
    InvalidContent(#[from] SceneError),
}

/// Result of reading a part of a scene.
pub(super) type ReadResult<T> = Result<T, SceneReadError>;
