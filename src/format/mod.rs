//! Scene files: importers, the scene language, and resolving a description into a scene.
//!
//! Meshes, material libraries and density grids have readers and writers of their own.

mod aim;
mod assets;
mod camera;
mod convert;
mod default_camera;
pub mod description;
mod error;
mod file;
mod file_extensions;
mod file_stamp;
pub mod gltf;
pub mod grid;
mod import;
mod import_notes;
mod imported_environment;
mod imported_files;
mod imported_materials;
mod imported_metals;
mod imported_objects;
mod imported_textures;
mod language;
mod lights;
mod line_error;
mod materials;
mod media;
pub mod mesh;
pub mod mitsuba;
pub mod mtl;
mod parallelogram;
pub mod pbrt;
mod resolve;
mod resolve_scene;
mod scene_text;
mod shapes;
mod span;
#[cfg(test)]
mod tests;
mod textured_value;
mod textures;
mod transform_step;
pub mod tungsten;
mod warnings;

pub use assets::EmbeddedAssets;
pub use convert::ConvertedScene;
pub use error::{SceneError, SourceText};
pub use file::SceneFile;
pub use file_extensions::SCENE_TEXT_EXTENSIONS;
pub use file_stamp::FileStamp;
pub use import::{ImportNote, ImportOptions, ImportedScene, SceneImporter, SceneReadError};
pub use language::{parse, parse_scene_bytes, update_reference_tables};
pub use line_error::LineError;
pub use resolve::scene_meshes::SceneMeshes;
pub use resolve_scene::{ResolvedScene, resolve, resolve_monitored};

/// Importers of all scene formats. A file whose extension no importer lists is read as scene text.
///
/// The values of the flag `--format` and their help come from this list.
pub const IMPORTERS: &[&dyn SceneImporter] = &[
    &scene_text::SceneTextImporter,
    &gltf::GltfImporter,
    &mitsuba::MitsubaImporter,
    &pbrt::PbrtImporter,
    &tungsten::TungstenImporter,
];

/// Greatest depth of nested groups and transforms in a scene file.
pub const MAX_NESTING_DEPTH: usize = 512;
