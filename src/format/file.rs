//! Scene files: reading by the importer of their format, then resolving.

use super::SceneError;
use super::description::SceneDescription;
use super::import::{EmbeddedAssets, ImportedScene, SceneImporter, SceneReadError};
use super::mesh::MeshReadMonitor;
use super::resolve::resolve_with_assets;
use super::scene_text::SceneTextImporter;
use super::{SourceText, warnings};
use crate::scene::Scene;
use crate::stats::MemoryLimit;
use std::path::{Path, PathBuf};

/// Importers of all scene formats. A file of another extension is read as scene text.
pub const IMPORTERS: [&dyn SceneImporter; 1] = [&SceneTextImporter];

/// A scene file that was read but not resolved: its description may still be changed.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The scene.
    pub description: SceneDescription,
    /// The file's text, for errors.
    pub source: SourceText,
    /// Meshes and pictures that the file itself holds.
    pub assets: EmbeddedAssets,
    folder: PathBuf,
}

impl SceneFile {
    /// Reads the file at `path` by the importer of its extension.
    ///
    /// # Errors
    /// [`SceneReadError`].
    pub fn read(path: &Path) -> Result<Self, SceneReadError> {
        Self::read_within_memory(path, MemoryLimit::Unbounded)
    }

    /// Like [`SceneFile::read`], but refuses a file that takes more than `memory` before reading
    /// it.
    ///
    /// # Errors
    /// [`SceneReadError`].
    pub fn read_within_memory(path: &Path, memory: MemoryLimit) -> Result<Self, SceneReadError> {
        let is = |own: &&str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(own));
        let importer = IMPORTERS.into_iter().find(|importer| importer.extensions().iter().any(is));
        let ImportedScene { description, source, assets } =
            importer.unwrap_or(&SceneTextImporter).import(path, memory)?;
        Ok(Self { description, source, assets, folder: path.parent().unwrap_or(Path::new("")).to_owned() })
    }

    /// Resolves the description. Meshes are looked up beside the file and in the folder above.
    ///
    /// # Errors
    /// [`SceneError`].
    pub fn resolve(&self) -> Result<Scene, SceneError> {
        self.resolve_monitored(&(), MemoryLimit::Unbounded)
    }

    /// Like [`SceneFile::resolve`], within `memory`; `monitor` receives the progress of reading
    /// meshes.
    ///
    /// # Errors
    /// [`SceneError`].
    pub fn resolve_monitored(&self, monitor: &dyn MeshReadMonitor, memory: MemoryLimit) -> Result<Scene, SceneError> {
        resolve_with_assets(&self.description, &self.source, &self.folder, &self.assets, monitor, memory)
    }

    /// Returns warnings about the scene, one line each: unused textures and materials, and
    /// defective dielectric meshes. Reads these meshes again.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        warnings::warnings(&self.description, &self.source, &self.folder, &self.assets)
    }

    /// Returns warnings about unused textures and materials, one line each. Reads no file.
    #[must_use]
    pub fn unused_item_warnings(&self) -> Vec<String> {
        warnings::unused_item_warnings(&self.description, &self.source)
    }

    /// Returns the folder that holds the file.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}
