//! Reports of studies: pages, tables and data.

pub mod effects;
mod html;
mod maps;
pub mod methods;
mod picture;
mod plain;
mod svg;
pub mod text;
