//! A tube along a trefoil knot.

use std::f64::consts::TAU;

use glam::DVec3;

use super::mesh::Mesh;

/// Radii of the torus about the y-axis that carries the knot. With the tube's radius they reach
/// .98.
const MAJOR: f64 = 0.56;
const MINOR: f64 = 0.26;
const TUBE: f64 = 0.16;
const ALONG: usize = 320;
const AROUND: usize = 40;

/// Returns the trefoil (2, 3) about the origin.
pub fn knot() -> Mesh {
    let mut mesh = Mesh::new("Trefoil knot, a smooth tube", 5, 4);
    let mut corners = Vec::new();
    for i in 0..ALONG {
        let t = TAU * i as f64 / ALONG as f64;
        let (sin2, cos2) = libm::sincos(2.0 * t);
        let (sin3, cos3) = libm::sincos(3.0 * t);
        let radius = MAJOR + MINOR * cos3;
        let centre = DVec3::new(radius * cos2, MINOR * sin3, radius * sin2);
        let tangent = DVec3::new(
            -3.0 * MINOR * sin3 * cos2 - 2.0 * radius * sin2,
            3.0 * MINOR * cos3,
            -3.0 * MINOR * sin3 * sin2 + 2.0 * radius * cos2,
        );
        // The torus's normal is perpendicular to every curve on it. So it frames the tube, which
        // closes without a twist.
        let normal = DVec3::new(cos3 * cos2, sin3, cos3 * sin2);
        let binormal = tangent.normalize().cross(normal);
        for j in 0..AROUND {
            let (sin, cos) = libm::sincos(TAU * j as f64 / AROUND as f64);
            let spoke = normal * cos + binormal * sin;
            corners.push((mesh.position(centre + spoke * TUBE), mesh.normal(spoke)));
        }
    }
    let at = |i: usize, j: usize| corners[(i % ALONG) * AROUND + j % AROUND];
    for i in 0..ALONG {
        for j in 0..AROUND {
            mesh.smooth_face(&[at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh
}
