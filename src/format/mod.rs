//! The scene language: from text to description and back.

pub mod description;
mod error;
mod lexer;
mod map;
pub mod obj;
mod parser;
mod print;
#[cfg(test)]
mod tests;

pub use error::{SceneError, Source};
pub use parser::{parse, parse_bytes};

/// How deep groups and transforms may nest.
pub const MAX_DEPTH: usize = 512;
