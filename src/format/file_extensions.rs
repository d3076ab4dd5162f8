//! File extensions of scenes and meshes.

use super::IMPORTERS;
use std::path::Path;

/// Extensions of files in the scene language.
pub const SCENE_TEXT_EXTENSIONS: &[&str] = &["txt", "caustica"];

/// Extensions of scene formats of other programs for which there is no importer.
const UNSUPPORTED_SCENE_EXTENSIONS: &[&str] =
    &["usd", "usda", "usdc", "usdz", "blend", "fbx", "dae", "3ds", "abc", "x3d"];

/// Extensions of mesh formats that are not read.
const UNSUPPORTED_MESH_EXTENSIONS: &[&str] = &["stl", "off"];

/// File extensions of the meshes that a scene file can refer to.
const MESH_EXTENSIONS: &[&str] = &["obj", "ply"];

/// True if a file with this extension may hold meshes that a shape cannot read: it is a scene of
/// another program, or a mesh in a format without a reader.
pub(super) fn is_unsupported_mesh_format(extension: &str) -> bool {
    let is_imported = IMPORTERS.iter().any(|importer| importer.extensions().contains(&extension));
    (is_imported && !SCENE_TEXT_EXTENSIONS.contains(&extension))
        || UNSUPPORTED_SCENE_EXTENSIONS.contains(&extension)
        || UNSUPPORTED_MESH_EXTENSIONS.contains(&extension)
}

/// Returns advice to a user who passes a file with this extension as the scene file, if it is a
/// mesh or a scene in an unsupported format.
///
/// `None` for unknown extensions, because their files are read as scene text. `extension` must not
/// be one that an importer reads.
pub(super) fn remedy_for_foreign_scene(extension: &str) -> Option<&'static str> {
    if UNSUPPORTED_SCENE_EXTENSIONS.contains(&extension) {
        Some("export the meshes as OBJ or PLY, and name them in a scene text: `TriangleMesh { file a.obj }`")
    } else if MESH_EXTENSIONS.contains(&extension) || UNSUPPORTED_MESH_EXTENSIONS.contains(&extension) {
        Some("write a scene text that names the mesh: `TriangleMesh { file a.obj }`")
    } else {
        None
    }
}

/// Returns the extension of a path in lower case, without the dot; empty if it has none.
pub(super) fn lowercase_extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
