//! Ray parameters of hits, and the conversions between f32 rays and f64 solutions.

use crate::math::Ray;
use glam::{DVec3, Vec2};

/// Hit of a ray: the ray parameter t, and two coordinates whose meaning depends on the shape.
pub type ShapeHit = (f32, f32, f32);

/// Origin and direction of the ray in double precision.
#[inline]
pub(super) fn ray_to_f64(ray: &Ray) -> (DVec3, DVec3) {
    (ray.origin.as_dvec3(), ray.direction.as_dvec3())
}

/// `t` rounded to f32; `None` outside the ray's range.
#[inline]
pub(super) fn t_in_range(ray: &Ray, t: f64) -> Option<f32> {
    let t = t as f32;
    (t > 0.0 && t < ray.t_max).then_some(t)
}

/// Hit at `t` whose first coordinate is the relative residual of rounding `t` to f32.
///
/// At a distance, the residual can be a large part of the shape. In a thin shape it can swap the
/// near and the far side.
#[inline]
pub(super) fn hit_with_residual(ray: &Ray, t: f64, second: f32) -> Option<ShapeHit> {
    t_in_range(ray, t).map(|rounded| (rounded, (t / f64::from(rounded) - 1.0) as f32, second))
}

/// The nearer of two hits that lies within the ray; each is t and a second coordinate.
///
/// A near hit beyond the end of the ray hides the far one.
#[inline]
pub(super) fn nearer_hit(ray: &Ray, near: (f64, f32), far: (f64, f32)) -> Option<ShapeHit> {
    hit_with_residual(ray, near.0, near.1)
        .or_else(|| if near.0 > 0.0 { None } else { hit_with_residual(ray, far.0, far.1) })
}

/// The f64 parameter t of a hit by [`hit_with_residual`].
#[inline]
pub(super) fn exact_t(t: f32, uv: Vec2) -> f64 {
    f64::from(t) * (1.0 + f64::from(uv.x))
}
