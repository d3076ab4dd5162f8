//! Refraction in extreme cases: at the critical angle, at equal indices, between bodies that share
//! a face, and after a thousand reflections.

mod index_matched;
mod inside;
mod interface;
mod shared;
mod trapped;
