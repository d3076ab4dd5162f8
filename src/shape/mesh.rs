//! Triangle meshes.

use super::SurfacePoint;
use glam::{DVec3, Vec2, Vec3};

/// Corner indices of one triangle.
pub type Triangle = [u32; 3];

/// Triangles over shared corners, in world space.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a corner, or none: flat.
    pub normals: Vec<Vec3>,
    /// Corner indices, counter-clockwise seen from outside.
    pub triangles: Vec<Triangle>,
}

impl Mesh {
    /// The corners of triangle `i`.
    #[inline]
    #[must_use]
    pub fn corners(&self, i: usize) -> [Vec3; 3] {
        self.triangles[i].map(|v| self.positions[v as usize])
    }

    /// Area of triangle `i` \[length²].
    #[must_use]
    pub fn area(&self, i: usize) -> f64 {
        let [a, b, c] = self.corners(i).map(|v| v.as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    }

    /// The surface of triangle `i` at barycentric weights `b` of its second and third corner.
    #[inline]
    #[must_use]
    pub fn surface(&self, i: usize, b: Vec2) -> SurfacePoint {
        let [p0, p1, p2] = self.corners(i).map(|v| v.as_dvec3());
        let (e1, e2) = (p1 - p0, p2 - p0);
        let b = b.as_dvec2();
        let p = (p0 + e1 * b.x + e2 * b.y).as_vec3();
        let mut ng = e1.cross(e2).normalize_or_zero().as_vec3();
        let ns = self.shading_normal(i, b.x, b.y).unwrap_or(ng);
        // Authors' normals say which side is out; winding may disagree.
        if ng.dot(ns) < 0.0 {
            ng = -ng;
        }
        // The f32 triangle test rounds corners relative to the ray's origin: its error is in ulps of the triangle's size.
        let size = e1.abs().max(e2.abs()).max_element() as f32;
        SurfacePoint {
            p,
            error: p.abs() * f32::EPSILON + Vec3::splat(size * (4.0 * f32::EPSILON)),
            ng,
            ns,
            uv: b.as_vec2(),
        }
    }

    #[inline]
    fn shading_normal(&self, i: usize, b1: f64, b2: f64) -> Option<Vec3> {
        if self.normals.is_empty() {
            return None;
        }
        let [n0, n1, n2]: [DVec3; 3] = self.triangles[i].map(|v| self.normals[v as usize].as_dvec3());
        (n0 * (1.0 - b1 - b2) + n1 * b1 + n2 * b2).try_normalize().map(|n| n.as_vec3())
    }
}
