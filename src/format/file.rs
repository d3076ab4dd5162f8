//! Reads a scene file by the importer of its format, and builds the scene.

use super::assets::EmbeddedAssets;
use super::camera::resolve_camera;
use super::description::{SceneDescription, Span};
use super::file_extensions::lowercase_extension;
use super::import::{ImportNote, ImportOptions, ImportedScene, SceneReadError};
use super::language::parse;
use super::mesh::MeshReadMonitor;
use super::resolve_scene::{ResolvedScene, resolve_with_assets};
use super::scene_text::SceneTextImporter;
use super::{IMPORTERS, SceneError, SourceText, warnings};
use crate::camera::Camera;
use crate::scene::Scene;
use crate::stats::MemoryLimit;
use std::path::{Path, PathBuf};

/// Parsed scene file. [`resolve`](SceneFile::resolve) builds a [`Scene`] from it; before that, the
/// description may be edited.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// Description of the scene.
    pub description: SceneDescription,
    /// Text that the spans of the description refer to.
    pub source: SourceText,
    /// Meshes, pictures and density grids that the scene file itself contains.
    pub assets: EmbeddedAssets,
    /// Messages of the importer about content that it ignored, approximated or added.
    pub notes: Vec<ImportNote>,
    folder: PathBuf,
}

impl SceneFile {
    /// Reads the scene file at `path`. The extension of `path` selects the importer; a file with an
    /// unknown extension is read as scene text.
    ///
    /// # Errors
    /// [`SceneReadError`].
    pub fn read(path: &Path) -> Result<Self, SceneReadError> {
        Self::read_with_options(path, &(), &ImportOptions::default())
    }

    /// Reads the scene file at `path`. The extension in `options.format_extension` selects the
    /// importer; if it is `None`, the extension of `path` does.
    ///
    /// Refuses a scene that would exceed the memory limit in `options`. `monitor` receives the
    /// paths of other files that the importer opens.
    ///
    /// # Errors
    /// [`SceneReadError`].
    pub fn read_with_options(
        path: &Path,
        monitor: &dyn MeshReadMonitor,
        options: &ImportOptions,
    ) -> Result<Self, SceneReadError> {
        let extension = options.format_extension.clone().unwrap_or_else(|| lowercase_extension(path));
        let importer = IMPORTERS.iter().copied().find(|importer| importer.extensions().contains(&&*extension));
        let ImportedScene { description, source, assets, notes } =
            importer.unwrap_or(&SceneTextImporter).import(path, monitor, options)?;
        Ok(Self { description, source, assets, notes, folder: path.parent().unwrap_or(Path::new("")).to_owned() })
    }

    /// Reads scene text, as from a file named `name` in `folder`.
    ///
    /// Error messages print `name`. Files that the text names are looked up in `folder`, then in
    /// its parent folder.
    ///
    /// # Errors
    /// Up to 20 errors as one [`SceneError`], each with its position and remedy.
    ///
    /// ```
    /// let text = "PerspectiveCamera { center 0 0 5  direction 0 0 -1  angle 30 }
    ///     Group { Sphere { center 0 0 0  radius 1 } }";
    /// let file = caustica::SceneFile::from_text("ball", text, "scenes".as_ref())?;
    /// assert_eq!(file.resolve()?.analytic_shape_count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_text(name: &str, text: &str, folder: &Path) -> Result<Self, SceneError> {
        Ok(Self {
            description: parse(name, text)?,
            source: SourceText::new(name, text),
            assets: EmbeddedAssets::default(),
            notes: Vec::new(),
            folder: folder.to_owned(),
        })
    }

    /// Builds the scene. Files that the description names are looked up in the folder of the scene
    /// file, then in the parent of this folder.
    ///
    /// # Errors
    /// [`SceneError`].
    pub fn resolve(&self) -> Result<Scene, SceneError> {
        self.resolve_monitored(&(), MemoryLimit::Unbounded)
    }

    /// Builds the scene. Fails if the scene would take more memory than `memory` allows.
    ///
    /// `monitor` receives the paths of files that the scene needs, and the progress of reading
    /// meshes. Looks up files in the same folders as [`SceneFile::resolve`].
    ///
    /// # Errors
    /// [`SceneError`].
    pub fn resolve_monitored(&self, monitor: &dyn MeshReadMonitor, memory: MemoryLimit) -> Result<Scene, SceneError> {
        Ok(self.resolve_incrementally(None, monitor, memory)?.scene)
    }

    /// Builds the scene as [`SceneFile::resolve_monitored`] does, and reuses unchanged meshes and
    /// BVHs of `earlier`, a previous version of the scene.
    ///
    /// A mesh file with an unchanged [`FileStamp`](super::FileStamp) is not read again, and a BVH
    /// over equal geometry is not built again. Apart from the time taken, the result does not
    /// depend on `earlier`: the scene has the same bits.
    ///
    /// # Errors
    /// [`SceneError`].
    pub fn resolve_incrementally(
        &self,
        earlier: Option<&ResolvedScene>,
        monitor: &dyn MeshReadMonitor,
        memory: MemoryLimit,
    ) -> Result<ResolvedScene, SceneError> {
        resolve_with_assets(&self.description, &self.source, &self.folder, &self.assets, earlier, monitor, memory)
    }

    /// Returns the camera of the description.
    ///
    /// # Errors
    /// [`SceneError`] if the field of view or the lens is too extreme for single precision, or if
    /// the up direction is parallel to the view direction.
    pub fn resolve_camera(&self) -> Result<Camera, SceneError> {
        resolve_camera(&self.description.camera, &self.source)
    }

    /// Returns warnings about unused textures and materials, and about dielectric meshes that do
    /// not bound a solid body, for example because they are open.
    ///
    /// Each warning is one line. The files of dielectric meshes are read again. The messages of the
    /// importer are not included.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        warnings::scene_warnings(&self.description, &self.source, &self.folder, &self.assets)
    }

    /// Returns the messages of the importer as warnings, one line each.
    #[must_use]
    pub fn import_warnings(&self) -> Vec<String> {
        self.notes.iter().map(|note| self.source.warning_at_span(Span::default(), &note.message)).collect()
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

#[cfg(test)]
mod tests {
    use super::super::file_extensions::remedy_for_foreign_scene;
    use super::IMPORTERS;
    use std::collections::HashSet;

    #[test]
    fn importers_share_no_extension() {
        let mut known = HashSet::new();
        for importer in IMPORTERS {
            for extension in importer.extensions() {
                assert!(known.insert(extension), "{extension} is read by two importers");
                assert_eq!(**extension, extension.to_ascii_lowercase());
                let remedy = remedy_for_foreign_scene(extension);
                assert_eq!(remedy, None, "{extension} is read, and listed as unread or as a mesh");
            }
        }
    }
}
