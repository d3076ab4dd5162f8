//! The importer of the scene language.

use super::import::{EmbeddedAssets, ImportedScene, SceneImporter, SceneReadError};
use super::language::parse_scene_bytes;
use super::{SceneError, SourceText};
use crate::image::open_file;
use crate::stats::MemoryLimit;
use std::io::Read;
use std::path::Path;

/// Bytes of memory for each byte of a scene text, read, described and resolved.
///
/// A sphere of 40 letters takes about a kilobyte for shape, boxes and hierarchy.
const PER_BYTE: u64 = 32;

/// Formats that users may take for scenes, with what to do.
const FOREIGN: [(&[&str], &str); 2] = [
    (
        &["glb", "gltf", "usd", "usda", "usdc", "usdz", "blend", "fbx", "dae", "pbrt", "xml", "3ds", "abc"],
        "export the meshes as OBJ or PLY, and name them in a scene text: `TriangleMesh { file a.obj }`",
    ),
    (&["obj", "ply", "stl", "off"], "write a scene text that names the mesh: `TriangleMesh { file a.obj }`"),
];

/// Importer of texts in the scene language; it takes any extension that no other format has.
pub(super) struct SceneTextImporter;

impl SceneImporter for SceneTextImporter {
    fn name(&self) -> &'static str {
        "scene text"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["txt", "caustica"]
    }

    fn import(&self, path: &Path, memory: MemoryLimit) -> Result<ImportedScene, SceneReadError> {
        let unreadable = |source| SceneReadError::Unreadable { path: path.to_owned(), source };
        let (mut file, length) = open_file(path).map_err(unreadable)?;
        let name = path.display().to_string();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if let Some((_, help)) = FOREIGN.iter().find(|(extensions, _)| extensions.contains(&extension.as_str())) {
            let message = format!("`.{extension}` is no scene format that is read");
            return Err(SceneError::without_position(&name, message, *help).into());
        }
        let needed = PER_BYTE * length;
        if let Some(free) = memory.available_bytes().filter(|free| needed > *free) {
            return Err(SceneReadError::Memory { path: path.to_owned(), needed, free });
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(unreadable)?;
        let description = parse_scene_bytes(&name, &bytes)?;
        let source = SourceText::new(&name, &String::from_utf8_lossy(&bytes));
        Ok(ImportedScene { description, source, assets: EmbeddedAssets::default() })
    }
}
