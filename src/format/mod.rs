//! The scene language: from text to description and back.

pub mod description;
mod error;
mod lexer;
mod map;

pub use error::{SceneError, Source};

/// How deep groups and transforms may nest.
pub const MAX_DEPTH: usize = 512;
