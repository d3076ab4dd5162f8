//! Refraction at the critical angle, at equal indices, between bodies that share a face, and a
//! thousand times in a row.

mod index_matched;
mod inside;
mod interface;
mod shared;
mod trapped;
