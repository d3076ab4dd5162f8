//! A finger ring: light inside it forms a nephroid.

use std::f64::consts::FRAC_PI_2;

use glam::dvec2;

use super::mesh::Mesh;
use super::profile::Profile;

const INNER: f64 = 1.0;
const OUTER: f64 = 1.08;
const HEIGHT: f64 = 0.8;
const EDGE_RADIUS: f64 = 0.02;

/// Returns the band around the y-axis, standing on y = 0, with rounded edges.
pub fn ring() -> Mesh {
    profile().revolve(Mesh::new("Band with rounded edges", 6, 6), 512)
}

fn profile() -> Profile {
    let e = EDGE_RADIUS;
    Profile::new(OUTER, e)
        .line_to(OUTER, HEIGHT - e, 1)
        .arc(dvec2(OUTER - e, HEIGHT - e), FRAC_PI_2, 2)
        .line_to(INNER + e, HEIGHT, 1)
        .arc(dvec2(INNER + e, HEIGHT - e), FRAC_PI_2, 2)
        .line_to(INNER, e, 1)
        .arc(dvec2(INNER + e, e), FRAC_PI_2, 2)
        .line_to(OUTER - e, 0.0, 1)
        .arc(dvec2(OUTER - e, e), FRAC_PI_2, 2)
}
