//! The importer of files in the scene language.

use super::assets::EmbeddedAssets;
use super::file_extensions::{SCENE_TEXT_EXTENSIONS, lowercase_extension, remedy_for_foreign_scene};
use super::import::{ImportOptions, ImportedScene, SceneImporter, SceneReadError};
use super::imported_files::check_memory;
use super::language::parse_scene_bytes;
use super::mesh::MeshReadMonitor;
use super::{SceneError, SourceText};
use crate::image::open_file;
use std::io::Read;
use std::path::Path;

/// Estimated memory of the built scene \[bytes per byte of scene text].
///
/// A sphere whose text has 40 letters takes about a kilobyte, mostly in the BVH.
const SCENE_BYTES_PER_TEXT_BYTE: u64 = 32;

/// Importer of texts in the scene language. It also reads files of unknown extensions.
pub(super) struct SceneTextImporter;

impl SceneImporter for SceneTextImporter {
    fn name(&self) -> &'static str {
        "scene text"
    }

    fn extensions(&self) -> &'static [&'static str] {
        SCENE_TEXT_EXTENSIONS
    }

    fn import(
        &self,
        path: &Path,
        _monitor: &dyn MeshReadMonitor,
        options: &ImportOptions,
    ) -> Result<ImportedScene, SceneReadError> {
        let unreadable = |source| SceneReadError::Unreadable { path: path.to_owned(), source };
        let (mut file, length) = open_file(path).map_err(unreadable)?;
        let name = path.display().to_string();
        let extension = lowercase_extension(path);
        if options.format_extension.is_none()
            && let Some(help) = remedy_for_foreign_scene(&extension)
        {
            let message = format!("`.{extension}` is no scene format that is read");
            return Err(SceneError::error_without_position(&name, message, help).into());
        }
        check_memory(path, SCENE_BYTES_PER_TEXT_BYTE * length, options.memory_limit.available_bytes())?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(unreadable)?;
        let description = parse_scene_bytes(&name, &bytes)?;
        let source = SourceText::new(&name, &String::from_utf8_lossy(&bytes));
        Ok(ImportedScene { description, source, assets: EmbeddedAssets::default(), notes: Vec::new() })
    }
}
