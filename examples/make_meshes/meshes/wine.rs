//! The wine that fills the glass up to its widest height.

use glam::dvec2;

use super::mesh::Mesh;
use super::profile::Profile;

/// Returns the wine, placed like the glass of `goblet.obj`. A film of air separates it from the
/// glass, so that no surface belongs to both.
pub fn wine() -> Mesh {
    profile().revolve(Mesh::new("Wine for the wine glass", 5, 4), 64)
}

fn profile() -> Profile {
    Profile::new(0.0, 0.935)
        .cubic_to(dvec2(0.334, 0.935), dvec2(0.525, 1.144), dvec2(0.525, 1.36), 16)
        .line_to(0.0, 1.36, 1)
}
