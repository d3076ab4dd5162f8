//! What fills the wine glass to where it is widest.

use glam::dvec2;

use super::mesh::Mesh;
use super::profile::Profile;

/// The wine, in the place of the glass of `goblet.obj`; a film of air keeps it from the wall, for no surface is both's.
pub fn wine() -> Mesh {
    profile().revolve(Mesh::new("Wine for the wine glass", 5, 4), 64)
}

fn profile() -> Profile {
    Profile::new(0.0, 0.935)
        .cubic_to(dvec2(0.334, 0.935), dvec2(0.525, 1.144), dvec2(0.525, 1.36), 16)
        .line_to(0.0, 1.36, 1)
}
