//! The seam for scene formats: the importer trait, and what an importer returns.

use super::description::SceneDescription;
use super::mesh::TriangleMesh;
use super::{SceneError, SourceText};
use crate::image::Image;
use crate::stats::{MemoryLimit, format_bytes};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads scenes of one file format.
///
/// A new format is a type that implements this trait in a folder of its own, and one line in
/// [`IMPORTERS`](super::IMPORTERS).
pub trait SceneImporter: Sync {
    /// Returns the format's name for messages.
    fn name(&self) -> &'static str;

    /// Returns the file extensions of the format, in lower case and without the dot.
    fn extensions(&self) -> &'static [&'static str];

    /// Reads the file at `path`, which takes at most `memory`.
    ///
    /// # Errors
    /// [`SceneReadError`]; its [`SceneError`] may lack a position and may carry further errors.
    fn import(&self, path: &Path, memory: MemoryLimit) -> Result<ImportedScene, SceneReadError>;
}

/// A scene as an importer read it.
#[derive(Clone, Debug)]
pub struct ImportedScene {
    /// The scene.
    pub description: SceneDescription,
    /// The text that the description's spans refer to; empty if the format is not text.
    pub source: SourceText,
    /// Meshes and pictures that the file itself holds.
    pub assets: EmbeddedAssets,
}

/// Meshes and pictures in memory, by the paths that the description names them with.
///
/// A path that is listed here is not looked up in the file system.
#[derive(Clone, Debug, Default)]
pub struct EmbeddedAssets {
    /// Meshes of `TriangleMesh` shapes.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// Pictures of textures and environments, in linear values.
    pub pictures: BTreeMap<String, Arc<Image>>,
}

impl EmbeddedAssets {
    /// True if `path` names a mesh or picture in memory.
    #[must_use]
    pub fn contains(&self, path: &str) -> bool {
        self.meshes.contains_key(path) || self.pictures.contains_key(path)
    }
}

/// Reason why a scene file could not be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SceneReadError {
    /// The file could not be opened or read.
    #[error("cannot read the scene `{}`", path.display())]
    #[diagnostic(help("check the path and its permissions"))]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The file exceeds the memory limit.
    #[error("the scene `{}` takes about {} of memory, and {} are free", path.display(), format_bytes(*needed), format_bytes(*free))]
    #[diagnostic(help("put large parts into meshes, or allow more memory (--memory)"))]
    Memory {
        /// Path of the file.
        path: PathBuf,
        /// Bytes that the scene takes.
        needed: u64,
        /// Bytes that are free.
        free: u64,
    },
    /// The content of the file has errors.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Language(#[from] SceneError),
}
