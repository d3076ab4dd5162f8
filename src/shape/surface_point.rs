//! Points on surfaces, with bounds on their rounding errors.

use crate::math::Bounds;
use glam::{DVec3, Vec2, Vec3};

/// Point of a surface with its normals, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position.
    pub p: Vec3,
    /// Bound on the position error along each axis; it includes the error of the next ray's
    /// intersection test.
    pub error: Vec3,
    /// Geometric unit normal, on the outer side of the shape.
    pub ng: Vec3,
    /// Shading unit normal, in the hemisphere around `ng`.
    pub ns: Vec3,
    /// Coordinates whose meaning depends on the shape.
    pub uv: Vec2,
}

impl SurfacePoint {
    /// Flat-shaded point from an f64 solution on a shape whose coordinates have magnitudes up to
    /// `scale`.
    #[inline]
    pub(super) fn from_f64(p: DVec3, normal: DVec3, scale: f64) -> Self {
        let ng = normal.as_vec3();
        let rounded = p.as_vec3();
        Self { p: rounded, error: rounding_error(rounded, scale), ng, ns: ng, uv: Vec2::ZERO }
    }
}

/// Point sampled on a shape, with its pdf per area.
#[derive(Clone, Copy, Debug)]
pub struct ShapeSample {
    /// The point and its normals.
    pub point: SurfacePoint,
    /// Probability density per area \[1/length²].
    pub pdf: f32,
    /// Coordinates of a [`ShapeHit`](super::ShapeHit) at the point.
    pub uv: Vec2,
}

/// A point of a shape sampled by solid angle, as seen from another point.
#[derive(Clone, Copy, Debug)]
pub struct SolidAngleSample {
    /// The sampled point, with its normals.
    pub point: SurfacePoint,
    /// Unit direction towards the sampled point.
    pub wi: Vec3,
    /// Pdf per solid angle \[1/sr].
    pub pdf: f32,
}

/// The result of sampling a shape by solid angle.
#[derive(Clone, Copy, Debug)]
pub enum SolidAngleSampling {
    /// A visible point.
    Sampled(SolidAngleSample),
    /// The outer side of the shape is invisible.
    Invisible,
    /// The shape must be sampled by area instead.
    Unsupported,
}

/// Error of the position at which a ray hits a distant triangle, relative to the ray's length.
///
/// The shear of the triangle test rounds a few times in f32.
pub const TRIANGLE_HIT_ERROR: f32 = 4.0 * f32::EPSILON;

/// Bound on the error of `p`: half an ulp of f32 per coordinate, and 32 ulps of f64 at `scale` for
/// the next test.
#[inline]
pub(super) fn rounding_error(p: Vec3, scale: f64) -> Vec3 {
    p.abs() * f32::EPSILON + Vec3::splat((scale * (32.0 * f64::EPSILON)) as f32)
}

/// Least distance of hit points from the edges of a face, in units of their largest error along an
/// axis.
///
/// A ray leaves a point that is off by up to √3 errors, from a start as far away along the normal.
/// At an edge where two faces meet at angle θ, both displacements can move the start beyond the
/// other face. The ray then escapes through the edge or hits a wall twice. At distance s from the
/// edge, the start stays inside while s·sin θ > √3·(1 + cos θ) errors. 16 errors are enough for θ ≥
/// 12.4°.
pub(super) const EDGE_MARGIN: f64 = 16.0;

/// f32 bounding box that contains the f64 box from `min` to `max`.
pub(super) fn round_outward(min: DVec3, max: DVec3) -> Bounds {
    let down = |x: f64| (x as f32).next_down();
    let up = |x: f64| (x as f32).next_up();
    Bounds { min: Vec3::new(down(min.x), down(min.y), down(min.z)), max: Vec3::new(up(max.x), up(max.y), up(max.z)) }
}
