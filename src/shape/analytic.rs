//! The interface that every kind of shape implements.

use super::hit::ShapeHit;
use super::surface_point::{ShapeSample, SolidAngleSampling, SurfacePoint};
use super::texture_mapping::TexCoord;
use crate::math::{BoundingSphere, Ray, Transform};
use glam::{DVec3, Vec2, Vec3};

/// A bounded shape in world space. [`Shape`](super::Shape) dispatches to it.
pub(super) trait AnalyticShape: Sized {
    /// Nearest hit within the ray.
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit>;

    /// True if the ray hits the shape.
    #[inline]
    fn occludes(&self, ray: &Ray) -> bool {
        self.intersect(ray).is_some()
    }

    /// Point that `ray` hits at `t`; `uv` holds the coordinates of the [`ShapeHit`].
    fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint;

    /// Intrinsic texture coordinates at the surface point `p`; `uv` holds the coordinates of the
    /// [`ShapeHit`].
    fn tex_coord(&self, _p: Vec3, uv: Vec2) -> TexCoord {
        TexCoord { uv: uv.as_dvec2(), ..TexCoord::default() }
    }

    /// Lower and upper corner of a box around the shape.
    fn bounds_f64(&self) -> (DVec3, DVec3);

    /// Image under a translation.
    fn translated(&self, by: DVec3) -> Self;

    /// Image under an affine map, with the same outer side.
    ///
    /// `None` if the image is not of this kind, or if it has no extent that numbers can hold.
    fn transformed(&self, map: &Transform) -> Option<Self>;

    /// Area of the surface \[length²].
    fn area(&self) -> f64;

    /// Samples a point of the surface by `u` in \[0, 1)².
    fn sample(&self, u: Vec2) -> ShapeSample;

    /// Pdf per area \[1/length²] of [`AnalyticShape::sample`] at a point of the surface.
    #[inline]
    fn pdf(&self, _point: &SurfacePoint) -> f32 {
        (1.0 / self.area()) as f32
    }

    /// Samples a visible point of the outer side by solid angle as seen from `from`.
    #[inline]
    fn sample_solid_angle(&self, _from: Vec3, _u: Vec2) -> SolidAngleSampling {
        SolidAngleSampling::Unsupported
    }

    /// Pdf per solid angle \[1/sr] of [`AnalyticShape::sample_solid_angle`]; `None` if unsupported.
    #[inline]
    fn solid_angle_pdf(&self, _from: Vec3) -> Option<f32> {
        None
    }

    /// Error of the position at which a ray hits the shape, relative to the ray's length.
    #[inline]
    fn relative_hit_error(&self) -> f32 {
        f32::EPSILON
    }

    /// A point of the surface if the whole shape lies in one plane.
    fn point_if_planar(&self) -> Option<SurfacePoint> {
        None
    }

    /// Sphere around the shape, if a tighter one is known than that around its box.
    fn bounding_sphere(&self) -> Option<BoundingSphere> {
        None
    }
}
