//! Curved shapes at double roots, at profiles that touch their axis, and at patch edges without
//! length.

mod far;
mod profiles;
mod tangents;
