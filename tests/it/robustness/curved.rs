//! Curved shapes where a root is double, a profile meets its axis or an edge of a patch has no length.

mod far;
mod profiles;
mod tangents;
