//! What studies found, as pages, tables and data.

pub mod effects;
mod html;
mod picture;
pub mod text;
