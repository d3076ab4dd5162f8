//! Reports of studies: HTML pages, tables and data files.

pub mod effects;
mod html;
mod maps;
pub mod methods;
mod picture;
mod plain;
mod svg;
pub mod text;
