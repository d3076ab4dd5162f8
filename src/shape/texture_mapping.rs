//! Texture coordinates of surfaces, and their gradients in world space.

use crate::math::Transform;
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{FRAC_1_PI, TAU};

/// Texture coordinates at a surface point, with their gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexCoord {
    /// Texture coordinates u and v.
    pub uv: DVec2,
    /// Gradient of u in world space \[1/length]; its part along the surface normal has no meaning.
    pub grad_u: DVec3,
    /// Gradient of v in world space \[1/length]; its part along the surface normal has no meaning.
    pub grad_v: DVec3,
}

impl TexCoord {
    /// Texture coordinates `uv`, with gradients computed from the tangents of the surface point
    /// p(u, v).
    ///
    /// `along_u` is ∂p/∂u and `along_v` is ∂p/∂v, in world space.
    #[must_use]
    pub(super) fn from_derivatives(uv: Vec2, along_u: DVec3, along_v: DVec3) -> Self {
        let cross = along_u.cross(along_v);
        // A collapsed edge has unbounded gradients; the maximum prevents a division by zero.
        let n2 = cross.length_squared().max(f64::MIN_POSITIVE);
        Self { uv: uv.as_dvec2(), grad_u: along_v.cross(cross) / n2, grad_v: cross.cross(along_u) / n2 }
    }
}

/// Function that maps object-space points to texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TextureMappingKind {
    /// Longitude u and latitude v around `center`, both scaled to \[0, 1].
    ///
    /// The polar axis is parallel to y. u is ½ at +z and ¾ at +x; v runs from 0 at −y to 1 at +y.
    Spherical {
        /// Object-space point from which longitude and latitude are measured.
        center: DVec3,
    },
    /// Planar projection: u and v are the dot products of p − `origin` with the vectors in `rows`.
    Planar {
        /// Object-space point at which u and v are 0.
        origin: DVec3,
        /// Object-space gradients of u and v \[1/length].
        rows: [DVec3; 2],
    },
    /// Texture coordinates of the shape itself, such as those of mesh vertices.
    Uv,
}

/// Mapping from surface points of an object to texture coordinates, defined in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMapping {
    kind: TextureMappingKind,
    to_world: Transform,
}

/// Unit directions of increasing u and v on a plane with the outer normal `normal`.
///
/// A picture on a wall appears upright to a viewer on the outer side: u points right, and v is as
/// near to +y as possible. On a horizontal plane, u is +x. `normal` and the results are in the same
/// space.
#[must_use]
pub fn upright_texture_axes(normal: DVec3) -> [DVec3; 2] {
    let n = normal.normalize_or(DVec3::Y);
    let right = DVec3::Y.cross(n);
    // For a horizontal plane, `right` is only a rounding error.
    let u = if right.length() > 1e-9 { right.normalize() } else { DVec3::X };
    [u, n.cross(u)]
}

impl TextureMappingKind {
    /// Mapping of a plane with the outer normal `normal`.
    ///
    /// u and v are distances from the object-space origin, along the directions of
    /// [`upright_texture_axes`].
    #[must_use]
    pub fn plane_mapping(normal: DVec3) -> Self {
        Self::Planar { origin: DVec3::ZERO, rows: upright_texture_axes(normal) }
    }

    /// Mapping of a disc to the disc inscribed in the unit square of texture coordinates.
    ///
    /// A picture appears upright to a viewer on the outer side, as [`upright_texture_axes`] defines
    /// it.
    #[must_use]
    pub fn disc_mapping(center: DVec3, normal: DVec3, radius: f64) -> Self {
        let [u, v] = upright_texture_axes(normal);
        Self::Planar { origin: center - (u + v) * radius, rows: [u / (2.0 * radius), v / (2.0 * radius)] }
    }

    /// Mapping of a parallelogram to the unit square: from `corner`, u grows along `e0` and v along
    /// `e1`.
    #[must_use]
    pub fn rectangle_mapping(corner: DVec3, e0: DVec3, e1: DVec3) -> Self {
        let cross = e0.cross(e1);
        let n2 = cross.length_squared();
        Self::Planar { origin: corner, rows: [e1.cross(cross) / n2, cross.cross(e0) / n2] }
    }
}

impl Default for TextureMapping {
    fn default() -> Self {
        Self::new(TextureMappingKind::Uv, Transform::IDENTITY)
    }
}

impl TextureMapping {
    /// Mapping of `kind` for an object whose object-to-world transform is `to_world`.
    #[must_use]
    pub fn new(kind: TextureMappingKind, to_world: Transform) -> Self {
        Self { kind, to_world }
    }

    /// Mapping for the object after its translation by the world-space vector `by`.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..*self }
    }

    /// Transforms the world-space point `p` to object space.
    #[must_use]
    pub fn point_to_object_space(&self, p: Vec3) -> DVec3 {
        self.to_world.inverse().transform_point3(p.as_dvec3())
    }

    /// Transforms the world-space vector `step` to object space, without normalisation.
    #[must_use]
    pub fn vector_to_object_space(&self, step: DVec3) -> DVec3 {
        self.to_world.inverse().transform_vector3(step)
    }

    /// Texture coordinates at the object-space point `p`, with gradients in world space.
    ///
    /// `own` returns the texture coordinates of the shape itself. It is called only for
    /// [`TextureMappingKind::Uv`].
    #[must_use]
    pub fn tex_coord_at(&self, p: DVec3, own: impl FnOnce() -> TexCoord) -> TexCoord {
        let world = |row: DVec3| self.to_world.transform_normal(row);
        match self.kind {
            TextureMappingKind::Spherical { center } => {
                let d = p - center;
                // At the poles, u is arbitrary and its gradient is unbounded. The lower bounds
                // prevent divisions by zero.
                let around2 = (d.x * d.x + d.z * d.z).max(1e-30 * d.y * d.y).max(f64::MIN_POSITIVE);
                let (around, r2) = (around2.sqrt(), d.length_squared().max(f64::MIN_POSITIVE));
                let u = 0.5 + libm::atan2(d.x, d.z) / TAU;
                let v = 0.5 + libm::atan2(d.y, around) * FRAC_1_PI;
                let du = DVec3::new(d.z, 0.0, -d.x) / (around2 * TAU);
                let outward = -d.y / (around * r2);
                let dv = DVec3::new(d.x * outward, around / r2, d.z * outward) * FRAC_1_PI;
                TexCoord { uv: DVec2::new(u, v), grad_u: world(du), grad_v: world(dv) }
            }
            TextureMappingKind::Planar { origin, rows: [u, v] } => {
                let d = p - origin;
                TexCoord { uv: DVec2::new(u.dot(d), v.dot(d)), grad_u: world(u), grad_v: world(v) }
            }
            TextureMappingKind::Uv => own(),
        }
    }
}

#[cfg(test)]
mod tests;
