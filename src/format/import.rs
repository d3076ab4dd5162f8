//! The interface of scene importers: trait, result, embedded assets and errors.

use super::description::SceneDescription;
use super::grid::DensityGrid;
use super::mesh::{MeshReadMonitor, TriangleMesh};
use super::{SceneError, SourceText};
use crate::image::Image;
use crate::stats::{MemoryLimit, format_bytes};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reader of scenes in one file format.
///
/// To add a format, implement this trait. Then add the type to [`IMPORTERS`](super::IMPORTERS). A
/// file goes to the first importer that lists its extension.
pub trait SceneImporter: Sync {
    /// Returns the name of the scene format, for messages.
    fn name(&self) -> &'static str;

    /// Returns the file extensions of the format, in lower case and without the dot.
    fn extensions(&self) -> &'static [&'static str];

    /// Reads the file at `path`.
    ///
    /// Refuses it if the scene would exceed the memory of `options`. Also refuses it if it names a
    /// file outside its own folder and `options` do not allow this.
    ///
    /// An importer that opens further files, such as buffers or included scenes, reports each to
    /// [`MeshReadMonitor::on_input_file_found`] before it reads the file. The program then refuses
    /// an output that would overwrite the file.
    ///
    /// # Errors
    /// [`SceneReadError`]. The [`SceneError`] of a binary format may lack a position.
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
    pub memory: MemoryLimit,
    /// File extension that selects the importer, in lower case and without the dot; `None` for the
    /// extension of the file itself.
    pub format: Option<String>,
    /// True if a scene file of another program's format may name files outside its own folder.
    pub allows_outside_files: bool,
}

/// Message of an importer about the content of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportNote {
    /// The message: what was found, how often, and what was done.
    pub message: String,
    /// True if the file asks for something that is ignored or approximated. False if the file
    /// leaves something out, such as a camera.
    pub is_unsupported: bool,
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

/// Meshes, pictures and grids that a scene file itself contains, with the paths by which its
/// description names them.
///
/// A path that is listed here is not looked up in the file system.
#[derive(Clone, Debug, Default)]
pub struct EmbeddedAssets {
    /// Meshes of `TriangleMesh` shapes.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// Pictures of textures and lights; their values are linear.
    pub pictures: BTreeMap<String, Arc<Image>>,
    /// Density grids of media.
    pub grids: BTreeMap<String, Arc<DensityGrid>>,
}

impl EmbeddedAssets {
    /// True if `path` names an embedded mesh, picture or grid.
    #[must_use]
    pub fn contains(&self, path: &str) -> bool {
        self.meshes.contains_key(path) || self.pictures.contains_key(path) || self.grids.contains_key(path)
    }
}

/// Error of reading a scene file.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SceneReadError {
    /// The file could not be opened or read.
    #[error("cannot read the scene `{}`", path.display())]
    #[diagnostic(help("check the path and its permissions"))]
    Unreadable {
        /// Path of the scene file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The scene would exceed the memory limit.
    #[error("the scene `{}` takes about {} of memory, and {} are free", path.display(), format_bytes(*needed), format_bytes(*free))]
    #[diagnostic(help("put large parts into meshes, or allow more memory (--memory)"))]
    Memory {
        /// Path of the scene file.
        path: PathBuf,
        /// Estimated memory of the scene \[bytes].
        needed: u64,
        /// Free memory \[bytes].
        free: u64,
    },
    /// The content of the file has errors.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Language(#[from] SceneError),
}

/// Extensions of other programs' scene formats. Meshes in such files are not read.
///
/// Importers are asked first, so the list may contain extensions of importers.
const FOREIGN_SCENE_EXTENSIONS: &[&str] =
    &["glb", "gltf", "usd", "usda", "usdc", "usdz", "blend", "fbx", "dae", "pbrt", "xml", "3ds", "abc", "x3d"];

/// Extensions of mesh formats that are not read.
const UNREAD_MESH_EXTENSIONS: &[&str] = &["stl", "off"];

/// File extensions of the meshes that a scene file can refer to.
const MESH_EXTENSIONS: &[&str] = &["obj", "ply"];

/// True if the extension belongs to a known format from which no meshes are read.
pub(super) fn is_unread_mesh_format(extension: &str) -> bool {
    FOREIGN_SCENE_EXTENSIONS.contains(&extension) || UNREAD_MESH_EXTENSIONS.contains(&extension)
}

/// Returns advice to a user who gives a file with this extension as a scene; `None` if the file may
/// be scene text.
pub(super) fn remedy_for_foreign_scene(extension: &str) -> Option<&'static str> {
    if FOREIGN_SCENE_EXTENSIONS.contains(&extension) {
        Some("export the meshes as OBJ or PLY, and name them in a scene text: `TriangleMesh { file a.obj }`")
    } else if MESH_EXTENSIONS.contains(&extension) || UNREAD_MESH_EXTENSIONS.contains(&extension) {
        Some("write a scene text that names the mesh: `TriangleMesh { file a.obj }`")
    } else {
        None
    }
}

/// Returns the extension of a path in lower case, without the dot; empty if it has none.
pub(super) fn lowercase_extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
