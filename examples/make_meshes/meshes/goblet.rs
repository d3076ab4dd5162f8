//! A wine glass: foot, stem and a bowl with a wall.

use std::f64::consts::PI;

use glam::dvec2;

use super::mesh::Mesh;
use super::profile::Profile;

/// Returns the glass, standing on y = 0, about 2 high, as one closed smooth surface.
pub fn goblet() -> Mesh {
    profile().revolve(Mesh::new("Wine glass, one closed surface with a wall", 5, 4), 112)
}

fn profile() -> Profile {
    let outside = Profile::new(0.0, 0.0)
        .line_to(0.56, 0.0, 2)
        .arc(dvec2(0.56, 0.02), PI, 6)
        .cubic_to(dvec2(0.30, 0.04), dvec2(0.06, 0.10), dvec2(0.055, 0.32), 10)
        .cubic_to(dvec2(0.055, 0.42), dvec2(0.05, 0.52), dvec2(0.05, 0.62), 3)
        .cubic_to(dvec2(0.05, 0.76), dvec2(0.13, 0.80), dvec2(0.24, 0.86), 7)
        .cubic_to(dvec2(0.394, 0.944), dvec2(0.56, 1.14), dvec2(0.56, 1.38), 10)
        .cubic_to(dvec2(0.56, 1.62), dvec2(0.47, 1.82), dvec2(0.44, 1.99), 8);
    // The rim is a half circle between the outer and the inner wall.
    let (rim, up) = outside.end();
    let half_wall = 0.012;
    let inner_rim = rim + up.perp() * (2.0 * half_wall);
    outside
        .arc(rim + up.perp() * half_wall, PI, 6)
        .cubic_to(inner_rim - up * 0.17, dvec2(0.53, 1.62), dvec2(0.53, 1.38), 8)
        .cubic_to(dvec2(0.53, 1.12), dvec2(0.33, 0.93), dvec2(0.0, 0.93), 14)
}
