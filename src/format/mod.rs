//! The scene language: from text to description and back, and from description to the resolved scene.

pub mod description;
mod error;
mod file;
pub mod grid;
mod lexer;
mod map;
pub mod mesh;
pub mod mtl;
mod obj;
mod parser;
mod ply;
mod print;
mod problem;
mod resolve;
#[cfg(test)]
mod tests;

pub use error::{SceneError, Source};
pub use file::{ReadError, SceneFile};
pub use parser::{parse, parse_bytes};
pub use problem::LineError;
pub use resolve::{resolve, resolve_watched};

/// How deep groups and transforms may nest.
pub const MAX_DEPTH: usize = 512;
