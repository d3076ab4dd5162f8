//! Refraction at the critical angle, without a change of index, between bodies that share a face, and a thousand times over.

mod inside;
mod interface;
mod nothing;
mod shared;
mod trapped;
