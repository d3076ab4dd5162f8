//! Triangle meshes: positions, normals, texture coordinates and triangles.

use super::surface_point::{EDGE_MARGIN, SurfacePoint};
use super::texture_mapping::TexCoord;
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Vertex indices of one triangle, counter-clockwise seen from outside.
pub type TriangleIndices = [u32; 3];

/// Triangle mesh with shared vertices. All positions and normals are in one space, such as the
/// object space of an instance.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals per vertex; empty for flat shading.
    pub normals: Vec<Vec3>,
    /// Texture coordinates per vertex; empty if there are none.
    pub texcoords: Vec<Vec2>,
    /// Triangles of the mesh.
    pub triangles: Vec<TriangleIndices>,
}

impl Mesh {
    /// Corner positions of triangle `i`, in the order of its vertex indices.
    #[inline]
    #[must_use]
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        self.triangles[i].map(|v| self.positions[v as usize])
    }

    /// Area of triangle `i` \[length²].
    #[must_use]
    pub fn triangle_area(&self, i: usize) -> f64 {
        let [a, b, c] = self.corners(i).map(|v| v.as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    }

    /// Surface point of triangle `i`, in the mesh's space, at the barycentric weights `b`.
    ///
    /// `b` holds the weights of the second and third corner. A point close to an edge is moved away
    /// from it, so that a ray that starts there cannot escape through the edge.
    #[inline]
    #[must_use]
    pub fn surface_point(&self, i: usize, b: Vec2) -> SurfacePoint {
        let [p0, p1, p2] = self.corners(i).map(|v| v.as_dvec3());
        let (e1, e2) = (p1 - p0, p2 - p0);
        let b = b.as_dvec2();
        let cross = e1.cross(e2);
        let mut p = p0 + e1 * b.x + e2 * b.y;
        // Sixteen position errors ([`EDGE_MARGIN`]). A position error is the rounding of `p` to
        // f32, plus the error of the triangle test. The test rounds the corners, relative to the
        // ray's origin, to f32. For a ray that starts near the triangle, its error is a few f32
        // ulps of the triangle's size; four are allowed.
        let size = e1.abs().max(e2.abs()).max_element();
        let min_edge_distance = EDGE_MARGIN * f64::from(f32::EPSILON) * (p.abs().max_element() + 4.0 * size);
        // The distance of the point from an edge is a barycentric weight times |e1 × e2| over the
        // edge's length. No edge is longer than √12 times `size`.
        let least = b.x.min(b.y).min(1.0 - b.x - b.y).max(0.0);
        let bound = min_edge_distance * size;
        if least * least * cross.length_squared() < 12.0 * bound * bound {
            let kept = move_weights_off_edges(b, min_edge_distance / cross.length(), [e1, e2]);
            p = p0 + e1 * kept.x + e2 * kept.y;
        }
        let p = p.as_vec3();
        let mut ng = cross.normalize_or_zero().as_vec3();
        let ns = self.shading_normal(i, b.x, b.y).unwrap_or(ng);
        // Authored normals define the outer side; the winding may disagree.
        if ng.dot(ns) < 0.0 {
            ng = -ng;
        }
        let size = size as f32;
        SurfacePoint {
            p,
            position_error: p.abs() * f32::EPSILON + Vec3::splat(size * (4.0 * f32::EPSILON)),
            ng,
            ns,
            shape_coords: b.as_vec2(),
        }
    }

    /// Texture coordinates of triangle `i`, with gradients in the mesh's space.
    ///
    /// `b` holds the barycentric weights of the second and third corner. Gradients are zero if the
    /// mesh has no texture coordinates or the triangle has no area.
    #[must_use]
    pub fn tex_coord(&self, i: usize, b: Vec2) -> TexCoord {
        if self.texcoords.is_empty() {
            return TexCoord::default();
        }
        let [t0, t1, t2]: [DVec2; 3] = self.triangles[i].map(|v| self.texcoords[v as usize].as_dvec2());
        let (t1, t2, b) = (t1 - t0, t2 - t0, b.as_dvec2());
        let uv = t0 + t1 * b.x + t2 * b.y;
        let [p0, p1, p2] = self.corners(i).map(|v| v.as_dvec3());
        let (e1, e2) = (p1 - p0, p2 - p0);
        let cross = e1.cross(e2);
        let n2 = cross.length_squared();
        if n2 == 0.0 {
            return TexCoord { uv, ..TexCoord::default() };
        }
        // Gradients of the weights of the second and third corner.
        let (w1, w2) = (e2.cross(cross) / n2, cross.cross(e1) / n2);
        TexCoord { uv, grad_u: w1 * t1.x + w2 * t2.x, grad_v: w1 * t1.y + w2 * t2.y }
    }

    /// Unit shading normal of triangle `i`, interpolated between its vertex normals.
    ///
    /// `b1` and `b2` are the barycentric weights of the second and third corner. `None` if the mesh
    /// has no shading normals or their weighted sum is zero.
    #[inline]
    fn shading_normal(&self, i: usize, b1: f64, b2: f64) -> Option<Vec3> {
        if self.normals.is_empty() {
            return None;
        }
        let [n0, n1, n2]: [DVec3; 3] = self.triangles[i].map(|v| self.normals[v as usize].as_dvec3());
        (n0 * (1.0 - b1 - b2) + n1 * b1 + n2 * b2).try_normalize().map(|n| n.as_vec3())
    }
}

/// Moves a point of a triangle away from the triangle's edges, if it is too close to one.
///
/// `b` and the result are the point's barycentric weights of the second and third corner. `e1` and
/// `e2` are the vectors from the first corner to these corners. `distance_per_double_area` is the
/// minimum distance to an edge, divided by twice the triangle's area. The move raises no weight
/// above ¼. [`EDGE_MARGIN`] explains why points are moved.
#[cold]
fn move_weights_off_edges(b: DVec2, distance_per_double_area: f64, [e1, e2]: [DVec3; 2]) -> DVec2 {
    let least = [e2 - e1, e2, e1].map(|edge| (distance_per_double_area * edge.length()).min(0.25));
    let mut weights = [1.0 - b.x - b.y, b.x, b.y];
    let largest = if weights[0] >= b.x.max(b.y) { 0 } else { 1 + usize::from(b.y > b.x) };
    for (w, least) in weights.iter_mut().zip(least) {
        *w = w.max(least);
    }
    // The largest weight shrinks so that the sum stays 1. It keeps at least ¼.
    weights[largest] = 1.0 - (0..3).filter(|i| *i != largest).map(|i| weights[i]).sum::<f64>();
    DVec2::new(weights[1], weights[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_coordinates_interpolate_the_corners() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0)],
            texcoords: vec![Vec2::new(0.5, 0.25), Vec2::new(1.0, 0.25), Vec2::new(0.5, 1.0)],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        assert_eq!(mesh.tex_coord(0, Vec2::ZERO).uv, DVec2::new(0.5, 0.25));
        let m = mesh.tex_coord(0, Vec2::new(0.5, 0.5));
        assert_eq!(m.uv, DVec2::new(0.75, 0.625));
        let along = |x: DVec3| DVec2::new(m.grad_u.dot(x), m.grad_v.dot(x));
        // Coordinates are affine: along an edge they change by the difference of the corners.
        assert!((along(DVec3::new(2.0, 0.0, 0.0)) - DVec2::new(0.5, 0.0)).length() < 1e-12);
        assert!((along(DVec3::new(1.0, 1.0, 0.0)) - DVec2::new(0.0, 0.75)).length() < 1e-12);
    }
}
