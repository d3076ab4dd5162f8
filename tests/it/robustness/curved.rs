//! Curved shapes in difficult cases: double roots, profiles that touch their axis, and patch edges
//! without length.

mod far;
mod profiles;
mod tangents;
