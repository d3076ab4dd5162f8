//! Refraction at the critical angle, at equal indices, between bodies that share a face, and a
//! thousand times in a row.

mod inside;
mod interface;
mod nothing;
mod shared;
mod trapped;
