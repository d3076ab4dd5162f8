//! A biconvex lens of two spherical caps and a narrow rim.

use glam::dvec2;

use super::mesh::Mesh;
use super::profile::Profile;

/// Radius of the two spheres. The lens has radius 1.
const SPHERE: f64 = 2.5;
/// Half the height of the rim.
const HALF_RIM: f64 = 0.02;

/// Returns the lens about the origin, with its axis along y.
pub fn lens() -> Mesh {
    profile().revolve(Mesh::new("Biconvex lens, spheres of radius 2.5, aperture radius 1", 6, 6), 120)
}

fn profile() -> Profile {
    let half_angle = libm::asin(1.0 / SPHERE);
    // The centers lie so that the caps end at r = 1 on the rim.
    let centre = SPHERE * libm::cos(half_angle) - HALF_RIM;
    let steps = 22;
    Profile::new(0.0, centre - SPHERE).arc(dvec2(0.0, centre), half_angle, steps).line_to(1.0, HALF_RIM, 1).arc(
        dvec2(0.0, -centre),
        half_angle,
        steps,
    )
}
