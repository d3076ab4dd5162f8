//! Reports of studies: HTML pages, tables and data files.

mod csv_and_markdown;
pub mod effects;
mod html;
mod maps;
pub mod methods;
mod picture;
mod svg;
pub mod text;
