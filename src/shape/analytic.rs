//! Interface of bounded shapes.

use super::hit::ShapeHit;
use super::surface_point::{ShapeSample, SolidAngleSampleResult, SurfacePoint};
use super::texture_mapping::TexCoord;
use crate::math::{BoundingSphere, Ray, Transform};
use glam::{DVec3, Vec2, Vec3};

/// Bounded shape in world space; [`Shape`](super::Shape) dispatches to it.
pub(super) trait AnalyticShape: Sized {
    /// Nearest hit with a ray parameter in (0, `ray.t_max`).
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit>;

    /// True if the ray hits the shape at a parameter in (0, `ray.t_max`).
    #[inline]
    fn occludes(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }

    /// Surface point at the hit (`t`, `uv.x`, `uv.y`) of `ray`: see [`ShapeHit`].
    fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint;

    /// The shape's own texture coordinates at the surface point `p`.
    ///
    /// `uv` holds the last two numbers of the [`ShapeHit`] at that point.
    fn tex_coord(&self, _p: Vec3, uv: Vec2) -> TexCoord {
        TexCoord { uv: uv.as_dvec2(), ..TexCoord::default() }
    }

    /// Lower and upper corner of an axis-aligned box that contains the shape.
    fn bounds_f64(&self) -> (DVec3, DVec3);

    /// The shape translated by `by`.
    fn translated(&self, by: DVec3) -> Self;

    /// Image of the shape under `map`, with the same outer side.
    ///
    /// `None` if the image is another kind of shape, or if the product of the transforms is
    /// singular.
    fn transformed(&self, map: &Transform) -> Option<Self>;

    /// Area of the surface \[length²].
    fn area(&self) -> f64;

    /// Samples a point of the surface; `u` is uniform in \[0, 1)².
    fn sample(&self, u: Vec2) -> ShapeSample;

    /// Pdf of [`AnalyticShape::sample`] at the given point, per area \[1/length²].
    #[inline]
    fn pdf(&self, _point: &SurfacePoint) -> f32 {
        (1.0 / self.area()) as f32
    }

    /// Samples a visible point of the outer side by solid angle as seen from `from`.
    #[inline]
    fn sample_solid_angle(&self, _from: Vec3, _u: Vec2) -> SolidAngleSampleResult {
        SolidAngleSampleResult::Unsupported
    }

    /// Pdf per solid angle \[1/sr] of [`AnalyticShape::sample_solid_angle`]; `None` if unsupported.
    #[inline]
    fn solid_angle_pdf(&self, _from: Vec3) -> Option<f32> {
        None
    }

    /// Bound on the position error of a hit along the ray, relative to the hit's distance.
    #[inline]
    fn relative_hit_error(&self) -> f32 {
        f32::EPSILON
    }

    /// A point of the surface if the shape lies in a plane, else `None`.
    fn point_if_planar(&self) -> Option<SurfacePoint> {
        None
    }

    /// A sphere around the shape that is tighter than that around its bounding box, if known.
    fn bounding_sphere(&self) -> Option<BoundingSphere> {
        None
    }
}
