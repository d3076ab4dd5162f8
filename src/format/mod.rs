//! Scene files: importers, the scene language, and resolving a description into a scene.
//!
//! Meshes, material libraries and density grids have readers and writers of their own.

mod convert;
pub mod description;
mod error;
mod file;
mod framing;
pub mod gltf;
pub mod grid;
mod import;
mod import_notes;
mod language;
mod line_error;
pub mod mesh;
pub mod mitsuba;
pub mod mtl;
pub mod pbrt;
mod resolve;
mod scene_text;
#[cfg(test)]
mod tests;
mod transform_step;
mod warnings;

pub use convert::ConvertedScene;
pub use error::{SceneError, SourceText};
pub use file::{IMPORTERS, SceneFile};
pub use import::{EmbeddedAssets, ImportNote, ImportOptions, ImportedScene, SceneImporter, SceneReadError};
pub use language::{parse, parse_scene_bytes, update_reference_tables};
pub use line_error::LineError;
pub use resolve::{resolve, resolve_monitored};

/// Greatest depth of nested groups and transforms in a scene file.
pub const MAX_NESTING_DEPTH: usize = 512;
