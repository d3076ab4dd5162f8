//! Shapes in world space, and their intersection with rays.
//!
//! Intersections are computed in f64, except those of triangles. Every kind of bounded shape
//! implements `BoundedShape` and is a variant of [`Shape`].
//!
//! To add a kind of shape:
//!
//! - add a file in this folder, and a variant of [`Shape`] in this file;
//! - add a file in `format/shapes/` that reads the shape, and its line in `format/shapes/mod.rs`.

mod bounded_shape;
mod cuboid;
mod disc;
mod ellipsoid;
mod frustum;
mod hit;
mod instance;
mod mesh;
mod object_ray;
pub mod parametric_surface;
mod plane;
mod rectangle;
mod sphere;
mod surface_point;
#[cfg(test)]
mod tests;
mod texture_mapping;

pub use cuboid::Cuboid;
pub use disc::Disc;
pub use ellipsoid::Ellipsoid;
pub use frustum::Frustum;
pub use instance::{MeshInstance, MeshWithBvh};
pub use mesh::{Mesh, TriangleIndices};
pub use parametric_surface::{Patch, Revolution};
pub use plane::Plane;
pub use rectangle::Rectangle;
pub use sphere::Sphere;
pub use surface_point::{
    RELATIVE_TRIANGLE_HIT_ERROR, ShapeSample, SolidAngleSample, SolidAngleSampleResult, SurfacePoint,
};
pub use texture_mapping::{TexCoord, TextureMapping, TextureMappingKind, upright_texture_axes};

use crate::accel::ShapeHit;
use crate::math::{self, Bounds, Ray, Transform};
use bounded_shape::BoundedShape;
use glam::{DVec3, Vec2, Vec3};
use surface_point::round_outward;

/// A bounded shape in world space.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Sphere, given by centre and radius.
    Sphere(Sphere),
    /// Ellipsoid: a sphere under an affine map.
    Ellipsoid(Ellipsoid),
    /// Disc, or ellipse in a plane.
    Disc(Disc),
    /// Rectangle or parallelogram.
    Rectangle(Rectangle),
    /// Box or parallelepiped.
    Cuboid(Cuboid),
    /// Cylinder, cone or truncated cone.
    Frustum(Frustum),
    /// Triangle mesh with its own bounding volume hierarchy, under an affine map.
    Instance(MeshInstance),
    /// Surface of revolution: the surface that a spline curve sweeps as it turns around an axis.
    Revolution(Revolution),
    /// Tensor-product surface: Bézier patch, B-spline or NURBS.
    Patch(Patch),
}

/// Matches on a [`Shape`] and evaluates one expression for all variants.
///
/// In the expression `$e`, `$s` is the concrete shape, such as a [`Sphere`], and `$wrap` is the
/// variant's constructor.
macro_rules! dispatch {
    ($self:expr, $s:ident, $wrap:ident => $e:expr) => {
        dispatch!($self, $s, $wrap => $e, Sphere Ellipsoid Disc Rectangle Cuboid Frustum Instance Revolution Patch)
    };
    ($self:expr, $s:ident, $wrap:ident => $e:expr, $($kind:ident)*) => {
        match $self {
            $(Shape::$kind($s) => {
                let $wrap = Shape::$kind;
                $e
            })*
        }
    };
}

impl Shape {
    /// Nearest hit of `ray` with a ray parameter in (0, `ray.t_max`); `None` if there is none.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        dispatch!(self, s, _w => s.intersect(ray))
    }

    /// True if `ray` hits the shape at a ray parameter in (0, `ray.t_max`).
    #[inline]
    #[must_use]
    pub fn occludes(&self, ray: &Ray) -> bool {
        dispatch!(self, s, _w => s.occludes(ray))
    }

    /// World-space surface point at a hit that [`Shape::intersect`] returned for `ray`.
    ///
    /// `t` and `uv` are the ray parameter and the `shape_coords` of this [`ShapeHit`].
    #[inline]
    #[must_use]
    pub fn surface_point(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint {
        dispatch!(self, s, _w => s.surface_point(ray, t, uv))
    }

    /// Texture coordinates of the shape itself, without a texture mapping, at the world-space
    /// surface point `p`.
    ///
    /// `uv` is `shape_coords` of the [`ShapeHit`] at `p`. Shapes without texture coordinates of
    /// their own return `uv`, with gradients of zero.
    #[must_use]
    pub fn tex_coord(&self, p: Vec3, uv: Vec2) -> TexCoord {
        dispatch!(self, s, _w => s.tex_coord(p, uv))
    }

    /// Axis-aligned box in world space that contains the shape, rounded outward to f32.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let (min, max) = self.bounds_f64();
        round_outward(min, max)
    }

    /// Lower and upper corner of an axis-aligned box in world space that contains the shape.
    #[must_use]
    pub fn bounds_f64(&self) -> (DVec3, DVec3) {
        dispatch!(self, s, _w => s.bounds_f64())
    }

    /// World-space sphere that contains the shape. For a [`Sphere`], it is the sphere itself; for
    /// other shapes, it is the sphere around the bounding box.
    #[must_use]
    pub fn bounding_sphere(&self) -> math::BoundingSphere {
        let tight = dispatch!(self, s, _w => s.bounding_sphere());
        tight.unwrap_or_else(|| self.bounds().bounding_sphere())
    }

    /// A point of a disc or rectangle, with the normal of its plane.
    ///
    /// `None` for all other kinds of shapes, even if they are planar.
    #[must_use]
    pub fn point_if_planar(&self) -> Option<SurfacePoint> {
        dispatch!(self, s, _w => s.point_if_planar())
    }

    /// True for parametric surfaces: their edges may coincide with edges of neighbouring surfaces.
    ///
    /// A ray through such an edge can hit both surfaces at one point. Other kinds of shapes keep
    /// their surface points away from their edges.
    #[must_use]
    pub(crate) fn may_share_edges(&self) -> bool {
        match self {
            Self::Revolution(_) | Self::Patch(_) => true,
            Self::Sphere(_)
            | Self::Ellipsoid(_)
            | Self::Disc(_)
            | Self::Rectangle(_)
            | Self::Cuboid(_)
            | Self::Frustum(_)
            | Self::Instance(_) => false,
        }
    }

    /// The shape translated by `by` in world space.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        dispatch!(self, s, wrap => wrap(s.translated(by)))
    }

    /// The shape transformed by the world-space map `map`.
    ///
    /// The outer side stays the outer side, even if `map` mirrors. `None` if the combined
    /// object-to-world map is singular.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Option<Self> {
        if let (Self::Sphere(s), None) = (self, map.uniform_scale()) {
            return Ellipsoid::from_sphere(s, map).map(Self::Ellipsoid);
        }
        dispatch!(self, s, wrap => s.transformed(map).map(wrap))
    }

    /// World-space area of the surface \[length²].
    ///
    /// The area is approximate for a mesh instance that is scaled unevenly.
    #[must_use]
    pub fn area(&self) -> f64 {
        dispatch!(self, s, _w => s.area())
    }

    /// Samples a point of the surface; `u` is uniform in \[0, 1)².
    ///
    /// The sample holds its pdf per area, which is not constant for all shapes.
    #[must_use]
    pub fn sample(&self, u: Vec2) -> ShapeSample {
        dispatch!(self, s, _w => s.sample(u))
    }

    /// Pdf of [`Shape::sample`] at `point`, per area \[1/length²].
    #[inline]
    #[must_use]
    pub fn pdf(&self, point: &SurfacePoint) -> f32 {
        dispatch!(self, s, _w => s.pdf(point))
    }

    /// Samples a point of the outer side, uniformly by solid angle as seen from `from`.
    ///
    /// `u` is uniform in \[0, 1)². Other shapes that may occlude the point are ignored. The result
    /// also tells if the outer side is invisible, or if the shape must be sampled by area.
    #[inline]
    #[must_use]
    pub fn sample_solid_angle(&self, from: Vec3, u: Vec2) -> SolidAngleSampleResult {
        dispatch!(self, s, _w => s.sample_solid_angle(from, u))
    }

    /// Pdf per solid angle \[1/sr] of [`Shape::sample_solid_angle`]; 0 if the outer side is
    /// invisible.
    ///
    /// All visible points have this pdf. Returns `None` if the shape must be sampled by area
    /// instead.
    #[inline]
    #[must_use]
    pub fn solid_angle_pdf(&self, from: Vec3) -> Option<f32> {
        dispatch!(self, s, _w => s.solid_angle_pdf(from))
    }

    /// True if the whole disc of `radius` around `center`, with unit `normal`, lies on this flat
    /// shape: within `tolerance` \[length] of its plane, and at least `tolerance` inside its edges.
    ///
    /// Only rectangles and discs are tested. The result is false for all other kinds of shapes.
    #[inline]
    #[must_use]
    pub(crate) fn contains_disc(&self, center: Vec3, normal: Vec3, radius: f32, tolerance: f32) -> bool {
        dispatch!(self, s, _w => s.contains_disc(center, normal, radius, tolerance))
    }

    /// Upper bound on the position error of a hit, measured along the ray and divided by the
    /// distance from the ray's origin to the hit.
    #[inline]
    #[must_use]
    pub fn relative_hit_error(&self) -> f32 {
        dispatch!(self, s, _w => s.relative_hit_error())
    }
}
