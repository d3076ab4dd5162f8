//! Entry points of the fuzz targets, shared with the corpus replay of the main package's tests.

/// Feeds bytes to each reader, checking that it returns a result or a typed error.
#[path = "../../tests/it/robustness/input/readers.rs"]
pub mod readers;
