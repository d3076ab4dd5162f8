//! Points of surfaces, with bounds on their rounding errors.

use crate::math::Bounds;
use glam::{DVec3, Vec2, Vec3};

/// Point of a surface with its normals, in world space. For a [`Mesh`](super::Mesh), the point is
/// in the mesh's space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position, rounded to f32.
    pub p: Vec3,
    /// Bound on the error of `p` along each axis \[length].
    ///
    /// The bound also covers the error of intersecting this surface with a next ray that starts at
    /// `p`.
    pub position_error: Vec3,
    /// Geometric unit normal, on the outer side of the shape.
    pub ng: Vec3,
    /// Shading unit normal, in the hemisphere around `ng`.
    pub ns: Vec3,
    /// Numbers that locate `p` on the shape, for [`Shape::pdf`](super::Shape::pdf); zero if the
    /// shape does not need them.
    ///
    /// On a mesh, they are the barycentric weights of the triangle's second and third corner. On
    /// other shapes, they are [`ShapeHit::shape_coords`](crate::accel::ShapeHit::shape_coords) of a
    /// hit at `p`, with 0 for a component that depends on the ray.
    pub shape_coords: Vec2,
}

impl SurfacePoint {
    /// Surface point at `p`, rounded to f32, with an error bound.
    ///
    /// The unit vector `normal` is both the geometric and the shading normal. `scale` bounds the
    /// absolute coordinates of the shape.
    #[inline]
    pub(super) fn from_f64(p: DVec3, normal: DVec3, scale: f64) -> Self {
        let ng = normal.as_vec3();
        let rounded = p.as_vec3();
        Self { p: rounded, position_error: position_error_bound(rounded, scale), ng, ns: ng, shape_coords: Vec2::ZERO }
    }
}

/// Point sampled on a shape, with its pdf per area.
#[derive(Clone, Copy, Debug)]
pub struct ShapeSample {
    /// The point and its normals.
    pub point: SurfacePoint,
    /// Probability density per area \[1/length²].
    pub pdf: f32,
    /// Numbers that locate the point on the shape, for
    /// [`Shape::tex_coord`](super::Shape::tex_coord); zero for shapes whose texture coordinates do
    /// not depend on these numbers.
    pub shape_coords: Vec2,
}

/// A point of a shape, sampled by solid angle as seen from a viewpoint.
#[derive(Clone, Copy, Debug)]
pub struct SolidAngleSample {
    /// The sampled point, with its normals.
    pub point: SurfacePoint,
    /// Unit direction from the viewpoint to the sampled point.
    pub wi: Vec3,
    /// Pdf per solid angle \[1/sr].
    pub pdf: f32,
}

/// Result of sampling a shape by solid angle.
#[derive(Clone, Copy, Debug)]
pub enum SolidAngleSampleResult {
    /// A sampled point on a part of the outer side that faces the viewpoint.
    Sampled(SolidAngleSample),
    /// No part of the outer side faces the viewpoint.
    Invisible,
    /// The shape must be sampled by area instead.
    Unsupported,
}

/// Upper bound on the position error of a hit on a triangle, measured along the ray and divided by
/// the distance from the ray's origin to the hit.
///
/// The triangle test shears the corners and rounds them to f32, which causes the error.
pub const RELATIVE_TRIANGLE_HIT_ERROR: f32 = 4.0 * f32::EPSILON;

/// Bound on the error of the surface point `p` along each axis \[length].
///
/// The bound covers the rounding to f32. It also covers 32 f64 ulps of `scale`, for the
/// intersection test of the next ray. `scale` bounds the coordinates of the shape.
#[inline]
pub(super) fn position_error_bound(p: Vec3, scale: f64) -> Vec3 {
    p.abs() * f32::EPSILON + Vec3::splat((scale * (32.0 * f64::EPSILON)) as f32)
}

/// Minimum distance of surface points from the edges of their face, in units of the position error
/// along an axis.
///
/// The origin of the next ray is off by up to √3 errors. It is then offset along the normal by the
/// same distance. Near an edge of two faces, the origin could end up behind the other face, and the
/// ray would escape. At distance s from an edge with the angle θ between the faces, the origin
/// stays inside if s·sin θ > √3·(1 + cos θ) errors. 16 errors are enough for θ ≥ 12.4°.
pub(super) const EDGE_MARGIN: f64 = 16.0;

/// f32 box that contains the f64 box from `min` to `max`.
pub(super) fn round_outward(min: DVec3, max: DVec3) -> Bounds {
    let down = |x: f64| (x as f32).next_down();
    let up = |x: f64| (x as f32).next_up();
    Bounds { min: Vec3::new(down(min.x), down(min.y), down(min.z)), max: Vec3::new(up(max.x), up(max.y), up(max.z)) }
}
