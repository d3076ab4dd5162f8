//! The trait [`BoundedShape`], which every kind of bounded shape implements.

use super::surface_point::{ShapeSample, SolidAngleSampleResult, SurfacePoint};
use super::texture_mapping::TexCoord;
use crate::accel::ShapeHit;
use crate::math::{BoundingSphere, Ray, Transform};
use glam::{DVec3, Vec2, Vec3};

/// Operations on a bounded shape in world space. The enum [`Shape`](super::Shape) calls them for
/// each of its variants.
pub(super) trait BoundedShape: Sized {
    /// Nearest hit of `ray` with a ray parameter in (0, `ray.t_max`); `None` if there is none.
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit>;

    /// True if `ray` hits the shape at a ray parameter in (0, `ray.t_max`).
    #[inline]
    fn occludes(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }

    /// World-space surface point at a hit that `intersect` returned for `ray`.
    ///
    /// `t` and `uv` are the ray parameter and the `shape_coords` of this [`ShapeHit`].
    fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint;

    /// Texture coordinates of the shape itself, without a texture mapping, at the world-space
    /// surface point `p`.
    ///
    /// `uv` is `shape_coords` of the [`ShapeHit`] at `p`. By default, the texture
    /// coordinates are `uv` and their gradients are zero.
    fn tex_coord(&self, _p: Vec3, uv: Vec2) -> TexCoord {
        TexCoord { uv: uv.as_dvec2(), ..TexCoord::default() }
    }

    /// Lower and upper corner of an axis-aligned box in world space that contains the shape.
    fn bounds_f64(&self) -> (DVec3, DVec3);

    /// The shape translated by `by` in world space.
    fn translated(&self, by: DVec3) -> Self;

    /// The shape transformed by the world-space map `map`.
    ///
    /// The outer side stays the outer side, even if `map` mirrors. `None` if the transformed shape
    /// is of another type, or if the combined object-to-world map is singular.
    fn transformed(&self, map: &Transform) -> Option<Self>;

    /// World-space area of the surface \[length²].
    fn area(&self) -> f64;

    /// Samples a point of the surface, with its pdf per area; `u` is uniform in \[0, 1)².
    fn sample(&self, u: Vec2) -> ShapeSample;

    /// Pdf of [`BoundedShape::sample`] at `point`, per area \[1/length²].
    ///
    /// The default is for uniform samples: 1 over the area.
    #[inline]
    fn pdf(&self, _point: &SurfacePoint) -> f32 {
        (1.0 / self.area()) as f32
    }

    /// Samples a point of the outer side, uniformly by solid angle as seen from `from`.
    ///
    /// `u` is uniform in \[0, 1)². By default, shapes do not support this and must be sampled by
    /// area.
    #[inline]
    fn sample_solid_angle(&self, _from: Vec3, _u: Vec2) -> SolidAngleSampleResult {
        SolidAngleSampleResult::Unsupported
    }

    /// Pdf of `sample_solid_angle` per solid angle \[1/sr]; equal for all points visible from
    /// `from`.
    ///
    /// The pdf is 0 if the outer side is invisible from `from`, and `None` if the shape must be
    /// sampled by area.
    #[inline]
    fn solid_angle_pdf(&self, _from: Vec3) -> Option<f32> {
        None
    }

    /// True if the whole disc of `radius` around `center`, with unit `normal`, lies on this flat
    /// shape: within `tolerance` \[length] of its plane, and at least `tolerance` inside its edges.
    ///
    /// False by default, which means that the answer is not known.
    #[inline]
    fn contains_disc(&self, _center: Vec3, _normal: Vec3, _radius: f32, _tolerance: f32) -> bool {
        false
    }

    /// Upper bound on the position error of a hit, measured along the ray and divided by the
    /// distance from the ray's origin to the hit.
    #[inline]
    fn relative_hit_error(&self) -> f32 {
        f32::EPSILON
    }

    /// A point of the shape with the normal of its plane, if all shapes of this kind are planar.
    ///
    /// `None` by default.
    fn point_if_planar(&self) -> Option<SurfacePoint> {
        None
    }

    /// World-space bounding sphere, if this kind of shape has a tighter one than the sphere around
    /// its bounding box.
    ///
    /// `None` by default.
    fn bounding_sphere(&self) -> Option<BoundingSphere> {
        None
    }
}
