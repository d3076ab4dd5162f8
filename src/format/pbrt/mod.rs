//! Imports scenes in pbrt's text format, in the syntax of pbrt-v4 or pbrt-v3.

mod camera;
mod content;
mod environment;
mod files;
mod graphics_state;
mod interpreter;
mod lights;
mod materials;
mod media;
mod objects;
mod parameters;
mod pictures;
mod quadrics;
mod settings;
mod shape_properties;
mod shapes;
mod spectra;
mod subdivision;
#[cfg(test)]
mod tests;
mod textures;
mod tokens;

use super::import::{ImportOptions, ImportedScene, SceneImporter, SceneReadError};
use super::mesh::MeshReadMonitor;
use files::PbrtSceneFiles;
use interpreter::Interpreter;
use std::path::Path;

/// Importer of pbrt scenes.
pub(super) struct PbrtImporter;

impl SceneImporter for PbrtImporter {
    fn name(&self) -> &'static str {
        "pbrt"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["pbrt"]
    }

    fn import(
        &self,
        path: &Path,
        monitor: &dyn MeshReadMonitor,
        options: &ImportOptions,
    ) -> Result<ImportedScene, SceneReadError> {
        let files = PbrtSceneFiles::new(path, monitor, options);
        let bytes = files.read_file(path)?;
        import_bytes(&files, &bytes)
    }
}

/// Imports the bytes of a `.pbrt` file.
///
/// Errors name `path`. Files that the scene names are looked up in the folder of `path`.
///
/// # Errors
/// [`SceneReadError`] at the first defect, or at content that cannot be imported.
pub fn decode(path: &Path, bytes: &[u8], options: &ImportOptions) -> Result<ImportedScene, SceneReadError> {
    import_bytes(&PbrtSceneFiles::new(path, &(), options), bytes)
}

fn import_bytes(files: &PbrtSceneFiles<'_>, bytes: &[u8]) -> Result<ImportedScene, SceneReadError> {
    let mut interpreter = Interpreter::new(files);
    interpreter.run(bytes)?;
    interpreter.finish()
}
