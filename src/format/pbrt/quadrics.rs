//! Converts quadrics of pbrt, such as parts of spheres and cones, to triangle meshes.

use super::files::ReadResult;
use super::parameters::Parameters;
use crate::format::mesh::TriangleMesh;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// Number of straight segments by which a mesh approximates a full turn about the z axis.
const TURN_SEGMENTS: f64 = 64.0;

/// Number of segments along the generatrix (the profile line of a surface of revolution) if it is
/// curved, or if it is the line of a hyperboloid. Any other straight line has one segment.
const CURVE_SEGMENTS: u32 = 32;

/// Generatrix of a surface of revolution about the z axis: a polyline with a tangent at each point.
///
/// The parameter v goes from 0 to 1 along the polyline. Tangents point towards larger v, and have
/// any length.
struct Generatrix {
    points: Vec<DVec3>,
    tangents: Vec<DVec3>,
}

impl Generatrix {
    /// Returns a polyline of `segments` pieces. `at` returns the point and tangent of the curve at
    /// v.
    fn new(segments: u32, at: impl Fn(f64) -> (DVec3, DVec3)) -> Self {
        let (points, tangents) = (0..=segments).map(|i| at(f64::from(i) / f64::from(segments))).unzip();
        Self { points, tangents }
    }

    /// Returns the straight line from `start` to `end`.
    fn line(start: DVec3, end: DVec3, segments: u32) -> Self {
        Self::new(segments, |v| (start.lerp(end, v), end - start))
    }

    /// Returns the surface that the curve sweeps when it turns about the z axis by `phi_max`
    /// \[radians].
    ///
    /// Texture coordinates are u = φ / `phi_max`, and v along the curve. Normals are ∂p/∂u × ∂p/∂v.
    fn surface_of_revolution(&self, phi_max: f64) -> TriangleMesh {
        let columns = (TURN_SEGMENTS * phi_max / (2.0 * PI)).ceil().max(1.0) as u32;
        let rows = self.points.len() as u32;
        let mut mesh = TriangleMesh::default();
        let (mut normals, mut texcoords) = (Vec::new(), Vec::new());
        for column in 0..=columns {
            let u = f64::from(column) / f64::from(columns);
            let turn = DMat3::from_rotation_z(u * phi_max);
            for row in 0..rows {
                let (point, tangent) = (self.points[row as usize], self.tangents[row as usize]);
                // A point on the axis does not move: use the direction in which its neighbor moves.
                let neighbor = self.points[if row == 0 { 1 } else { row as usize - 1 }];
                let off_axis = if point.truncate() == DVec2::ZERO { neighbor } else { point };
                let turn_direction = DVec3::Z.cross(off_axis).normalize_or(DVec3::Y);
                mesh.positions.push(turn * point);
                normals.push((turn * turn_direction.cross(tangent)).normalize_or(DVec3::Z));
                texcoords.push(DVec2::new(u, f64::from(row) / f64::from(rows - 1)));
            }
        }
        for column in 0..columns {
            for row in 0..rows - 1 {
                let vertex = |i: u32, j: u32| (column + i) * rows + row + j;
                mesh.triangles.push([vertex(0, 0), vertex(1, 0), vertex(1, 1)]);
                mesh.triangles.push([vertex(0, 0), vertex(1, 1), vertex(0, 1)]);
            }
        }
        // Drop triangles with an edge on the axis: the edge has no length.
        let positions = &mesh.positions;
        mesh.triangles.retain(|triangle| {
            let [a, b, c] = triangle.map(|i| positions[i as usize]);
            a != b && b != c && c != a
        });
        (mesh.normals, mesh.texcoords) = (Some(normals), Some(texcoords));
        mesh
    }
}

/// Returns the mesh of the pbrt quadric `kind`; `None` for any other kind of shape.
pub(super) fn quadric_mesh(kind: &str, parameters: &Parameters) -> ReadResult<Option<TriangleMesh>> {
    let place = &parameters.place;
    let number = |name: &str, default: f64| parameters.number_or(name, default);
    let radius = number("radius", 1.0);
    let phi_max = number("phimax", 360.0).clamp(0.0, 360.0).to_radians();
    if !(radius > 0.0 && phi_max > 0.0) {
        return Err(place.error("`radius` and `phimax` are not above 0", "correct the shape"));
    }
    let empty = || place.error("the shape has no extent", "give different ends");
    let straight = |from: [f64; 2], to: [f64; 2]| {
        let point = |[radius, z]: [f64; 2]| DVec3::new(radius, 0.0, z);
        if from == to { Err(empty()) } else { Ok(Generatrix::line(point(from), point(to), 1)) }
    };
    let generatrix = match kind {
        "sphere" => {
            let ends = [number("zmin", -radius), number("zmax", radius)];
            let angle = |z: f64| libm::acos((z / radius).clamp(-1.0, 1.0));
            let (low, high) = (angle(ends[0].min(ends[1])), angle(ends[0].max(ends[1])));
            if low == high {
                return Err(empty());
            }
            Generatrix::new(CURVE_SEGMENTS, |v| {
                let theta = low + (high - low) * v;
                // The poles lie on the axis exactly.
                let sin = if theta == 0.0 || theta == PI { 0.0 } else { libm::sin(theta) };
                let cos = libm::cos(theta);
                (radius * DVec3::new(sin, 0.0, cos), DVec3::new(-cos, 0.0, sin))
            })
        }
        "cylinder" => {
            let (low, high) = (number("zmin", -1.0), number("zmax", 1.0));
            straight([radius, low.min(high)], [radius, low.max(high)])?
        }
        "disk" => {
            let height = number("height", 0.0);
            straight([radius, height], [number("innerradius", 0.0).max(0.0), height])?
        }
        "cone" => straight([radius, 0.0], [0.0, number("height", 1.0)])?,
        "paraboloid" => {
            let (low, high) = (number("zmin", 0.0), number("zmax", 1.0));
            let (low, high) = (low.min(high), low.max(high));
            if !(low >= 0.0 && high > low) {
                return Err(place.error("the paraboloid has no height above 0", "give 0 ≤ `zmin` < `zmax`"));
            }
            Generatrix::new(CURVE_SEGMENTS, |v| {
                let z = low + (high - low) * v;
                let r = radius * (z / high).sqrt();
                (DVec3::new(r, 0.0, z), DVec3::new(radius * radius / high, 0.0, 2.0 * r))
            })
        }
        "hyperboloid" => {
            let end = |name: &str, default: f64| parameters.point(name).unwrap_or(DVec3::splat(default));
            let (start, end) = (end("p1", 0.0), end("p2", 1.0));
            if start == end {
                return Err(empty());
            }
            Generatrix::line(start, end, CURVE_SEGMENTS)
        }
        _ => return Ok(None),
    };
    Ok(Some(generatrix.surface_of_revolution(phi_max)))
}

#[cfg(test)]
mod tests;
