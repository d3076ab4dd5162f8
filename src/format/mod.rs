//! The scene language: from text to description and back.

pub mod description;
mod map;

/// How deep groups and transforms may nest.
pub const MAX_DEPTH: usize = 512;
