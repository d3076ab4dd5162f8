//! Ray parameters of hits that are computed in f64 and stored in f32.

use crate::accel::ShapeHit;
use crate::math::Ray;
use glam::{DVec3, Vec2};

/// World-space origin and direction of the ray, converted to f64.
#[inline]
pub(super) fn ray_to_f64(ray: &Ray) -> (DVec3, DVec3) {
    (ray.origin.as_dvec3(), ray.direction.as_dvec3())
}

/// Ray parameter `t` rounded to f32; `None` if it is outside (0, `ray.t_max`).
#[inline]
pub(super) fn round_t_if_in_range(ray: &Ray, t: f64) -> Option<f32> {
    let t = t as f32;
    (t > 0.0 && t < ray.t_max).then_some(t)
}

/// Hit of `ray` at `t` rounded to f32, with `shape_coords` = (r, `v`). `None` if the rounded t is
/// outside (0, `ray.t_max`).
///
/// r is the relative rounding error of t. [`f64_ray_parameter`] restores the f64 value of t from
/// the rounded t and r. In f32 alone, the error of a distant hit could exceed the thickness of the
/// shape.
#[inline]
pub(super) fn hit_with_rounding_residual(ray: &Ray, t: f64, v: f32) -> Option<ShapeHit> {
    round_t_if_in_range(ray, t)
        .map(|rounded| ShapeHit { t: rounded, shape_coords: Vec2::new((t / f64::from(rounded) - 1.0) as f32, v) })
}

/// First hit of `ray` with a convex shape; `None` if no intersection is in (0, `ray.t_max`).
///
/// The ray's line crosses the surface twice. `near` and `far` each hold the ray parameter t of a
/// crossing, and `shape_coords.y` of the [`ShapeHit`] there.
#[inline]
pub(super) fn nearer_hit(ray: &Ray, near: (f64, f32), far: (f64, f32)) -> Option<ShapeHit> {
    hit_with_rounding_residual(ray, near.0, near.1)
        .or_else(|| if near.0 > 0.0 { None } else { hit_with_rounding_residual(ray, far.0, far.1) })
}

/// Ray parameter in f64 of a hit that [`hit_with_rounding_residual`] returned.
///
/// `t` is the rounded ray parameter of the hit, and `uv` its `shape_coords`.
#[inline]
pub(super) fn f64_ray_parameter(t: f32, uv: Vec2) -> f64 {
    f64::from(t) * (1.0 + f64::from(uv.x))
}
