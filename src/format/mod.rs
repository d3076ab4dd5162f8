//! Scene files: from text to description and back, and from description to the resolved scene.

mod convert;
pub mod description;
mod error;
mod file;
pub mod grid;
mod import;
mod language;
pub mod mesh;
pub mod mtl;
mod problem;
mod resolve;
#[cfg(test)]
mod tests;
mod text;
mod transform_step;
mod warnings;

pub use convert::Conversion;
pub use error::{SceneError, SourceText};
pub use file::{IMPORTERS, SceneFile};
pub use import::{Assets, Imported, ReadError, SceneImporter};
pub use language::{parse, parse_bytes, with_reference};
pub use problem::LineError;
pub use resolve::{resolve, resolve_watched};

/// Greatest depth of nested groups and transforms.
pub const MAX_DEPTH: usize = 512;
