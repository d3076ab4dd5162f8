//! How texture coordinates lie on surfaces.

use crate::math::Transform;
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{FRAC_1_PI, TAU};

/// Coordinates at a point of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexCoord {
    /// The coordinates.
    pub uv: DVec2,
    /// What u grows by along a step in world space \[1/length]; what it holds across the surface means nothing.
    pub du: DVec3,
    /// The same of v.
    pub dv: DVec3,
}

impl TexCoord {
    /// Texture coordinates from the derivatives ∂p/∂u and ∂p/∂v of the surface.
    #[must_use]
    pub(super) fn from_derivatives(uv: Vec2, along_u: DVec3, along_v: DVec3) -> Self {
        let cross = along_u.cross(along_v);
        // Where an edge has collapsed, coordinates turn without bounds.
        let n2 = cross.length_squared().max(f64::MIN_POSITIVE);
        Self { uv: uv.as_dvec2(), du: along_v.cross(cross) / n2, dv: cross.cross(along_u) / n2 }
    }
}

/// What coordinates follow, in the space of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MappingKind {
    /// A globe: u goes once around the y axis, eastward, and is ½ at +z; v goes from 0 at −y to 1 at +y.
    Spherical {
        /// Its middle.
        center: DVec3,
    },
    /// A flat sheet: (p − origin) · rows.
    Planar {
        /// Where both are 0.
        origin: DVec3,
        /// What u and v grow by along a step \[1/length].
        rows: [DVec3; 2],
    },
    /// What the surface itself says: the corners of a mesh, the parameters of a patch.
    Uv,
}

/// How texture coordinates lie on an object, and where it stands in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureMapping {
    form: MappingKind,
    to_world: Transform,
}

/// The directions of growing u and v on a sheet across `normal`, as of a picture that hangs upright on a wall: u to the right of who
/// faces its outer side, v upwards by y; on a level sheet u is x.
#[must_use]
pub fn upright(normal: DVec3) -> [DVec3; 2] {
    let n = normal.normalize_or(DVec3::Y);
    // No more than rounding away from level.
    let right = DVec3::Y.cross(n);
    let u = if right.length() > 1e-9 { right.normalize() } else { DVec3::X };
    [u, n.cross(u)]
}

impl MappingKind {
    /// A plane through `on`: coordinates are lengths from the origin of the object's space.
    #[must_use]
    pub fn plane(normal: DVec3) -> Self {
        Self::Planar { origin: DVec3::ZERO, rows: upright(normal) }
    }

    /// A disc, which touches the unit square from inside.
    #[must_use]
    pub fn disc(center: DVec3, normal: DVec3, radius: f64) -> Self {
        let [u, v] = upright(normal);
        Self::Planar { origin: center - (u + v) * radius, rows: [u / (2.0 * radius), v / (2.0 * radius)] }
    }

    /// A parallelogram, which fills the unit square: u along `e0`, v along `e1`, which are not parallel.
    #[must_use]
    pub fn rectangle(corner: DVec3, e0: DVec3, e1: DVec3) -> Self {
        let cross = e0.cross(e1);
        let n2 = cross.length_squared();
        Self::Planar { origin: corner, rows: [e1.cross(cross) / n2, cross.cross(e0) / n2] }
    }
}

impl Default for TextureMapping {
    fn default() -> Self {
        Self::new(MappingKind::Uv, Transform::IDENTITY)
    }
}

impl TextureMapping {
    /// Coordinates after `form` on an object that `to_world` places.
    #[must_use]
    pub fn new(form: MappingKind, to_world: Transform) -> Self {
        Self { form, to_world }
    }

    /// The chart of the object moved by a vector in world space.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        Self { to_world: self.to_world.translated(by), ..*self }
    }

    /// World point `p` in the object's space.
    #[must_use]
    pub fn in_object(&self, p: Vec3) -> DVec3 {
        self.to_world.inverse().transform_point3(p.as_dvec3())
    }

    /// A step of world space in the object's space.
    #[must_use]
    pub fn step_in_object(&self, step: DVec3) -> DVec3 {
        self.to_world.inverse().transform_vector3(step)
    }

    /// Coordinates at `p` of the object's space; `own` is what the surface itself says.
    #[must_use]
    pub fn at(&self, p: DVec3, own: impl FnOnce() -> TexCoord) -> TexCoord {
        let world = |row: DVec3| self.to_world.normal(row);
        match self.form {
            MappingKind::Spherical { center } => {
                let d = p - center;
                // At the poles u is any, and turns without bounds.
                let around2 = (d.x * d.x + d.z * d.z).max(1e-30 * d.y * d.y).max(f64::MIN_POSITIVE);
                let (around, r2) = (around2.sqrt(), d.length_squared().max(f64::MIN_POSITIVE));
                let u = 0.5 + libm::atan2(d.x, d.z) / TAU;
                let v = 0.5 + libm::atan2(d.y, around) * FRAC_1_PI;
                let du = DVec3::new(d.z, 0.0, -d.x) / (around2 * TAU);
                let outward = -d.y / (around * r2);
                let dv = DVec3::new(d.x * outward, around / r2, d.z * outward) * FRAC_1_PI;
                TexCoord { uv: DVec2::new(u, v), du: world(du), dv: world(dv) }
            }
            MappingKind::Planar { origin, rows: [u, v] } => {
                let d = p - origin;
                TexCoord { uv: DVec2::new(u.dot(d), v.dot(d)), du: world(u), dv: world(v) }
            }
            MappingKind::Uv => own(),
        }
    }
}

#[cfg(test)]
mod tests;
