//! Area lights: emitting shapes, and emitting triangles of meshes.

use super::light_bounds::{DirectionCone, LightBounds, NORMAL_ERROR, angle_between};
use super::source::{DirectLightSample, EmissionSample, LightGeometry, LightSource, ShadowTarget};
use super::{Light, PhotonAim};
use crate::color::Rgb;
use crate::math::{BoundingSphere, Bounds, Frame, Ray, offset_ray_origin, warp};
use crate::sampling::DiscreteDistribution;
use crate::shape::{
    Mesh, RELATIVE_TRIANGLE_HIT_ERROR, Shape, ShapeSample, SolidAngleSample, SolidAngleSampleResult, SurfacePoint,
    TexCoord, TextureMapping,
};
use crate::texture::{Texture, TextureEvalContext};
use glam::{DVec3, Vec2, Vec3};
use std::f32::consts::PI;
use std::f64::consts::{FRAC_PI_2, PI as PI_F64};
use std::sync::Arc;

/// The surface of an area light.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "lights lie in one array and are sampled where they lie")]
pub enum LightSurface {
    /// An analytic shape.
    Shape(Shape),
    /// Consecutive triangles of a mesh.
    Triangles {
        /// Mesh that contains the triangles of the light.
        mesh: Arc<Mesh>,
        /// Index of the light's first triangle in `mesh`.
        first_triangle: u32,
        /// Discrete distribution over the light's triangles by area. Its index 0 stands for
        /// triangle `first_triangle` of `mesh`.
        triangle_distribution: DiscreteDistribution,
    },
}

/// An area light: a surface that emits on its outer side.
#[derive(Clone, Debug)]
pub struct AreaLight {
    /// The surface that emits light.
    pub surface: LightSurface,
    /// Emitted radiance \[W/(m² sr)]. If `texture` is set, it is the mean over the surface.
    pub radiance: Rgb,
    /// Texture that varies the radiance over the surface; `None` if the radiance is uniform.
    pub texture: Option<Arc<EmissionTexture>>,
}

/// A texture that varies the radiance over an emitting surface.
#[derive(Clone, Debug)]
pub struct EmissionTexture {
    /// The texture, whose values `scale` converts to radiance.
    pub texture: Arc<Texture>,
    /// Mapping from surface points to texture coordinates.
    pub mapping: TextureMapping,
    /// Factor by which texture values are multiplied to give radiance \[W/(m² sr)].
    pub scale: Rgb,
}

/// Parametric coordinates of a point on the surface of an area light, for texture lookup.
#[derive(Clone, Copy, Debug)]
enum SurfaceCoord {
    /// Parametric coordinates on an analytic shape.
    Shape(Vec2),
    /// Index of a triangle in the mesh, and barycentric coordinates in the triangle.
    Triangle(u32, Vec2),
}

impl LightSurface {
    /// Area of the light's surface \[length²].
    #[must_use]
    pub fn area(&self) -> f64 {
        match self {
            Self::Shape(shape) => shape.area(),
            Self::Triangles { triangle_distribution: choice, .. } => choice.weight_sum(),
        }
    }

    /// Pdf per area \[1/length²] with which [`LightSurface::sample`] samples `point`.
    #[inline]
    #[must_use]
    pub fn pdf(&self, point: &SurfacePoint) -> f32 {
        match self {
            Self::Shape(shape) => shape.pdf(point),
            Self::Triangles { triangle_distribution: choice, .. } => (1.0 / choice.weight_sum()) as f32,
        }
    }

    /// Samples a point of the surface by `u` in \[0, 1)².
    ///
    /// The sample holds its pdf per area \[1/length²]. On some shapes, this pdf varies from point
    /// to point.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> ShapeSample {
        self.sample_point_with_coord(u).0
    }

    /// Samples a point of the surface like [`LightSurface::sample`], and returns it with its
    /// parametric coordinates.
    #[inline]
    fn sample_point_with_coord(&self, u: Vec2) -> (ShapeSample, SurfaceCoord) {
        match self {
            Self::Shape(shape) => {
                let sample = shape.sample(u);
                (sample, SurfaceCoord::Shape(sample.shape_coords))
            }
            Self::Triangles { mesh, first_triangle: first, triangle_distribution: choice } => {
                let (i, probability) = choice.sample(u.x);
                // The remainder of u.x within the chosen interval is uniform again.
                let x = choice.remapped_sample(u.x, i);
                let b = warp::square_to_uniform_triangle(Vec2::new(x, u.y));
                let i = *first + i as u32;
                let point = mesh.surface_point(i as usize, b);
                let area = choice.weight_sum() * f64::from(probability);
                (ShapeSample { point, pdf: probability / area as f32, shape_coords: b }, SurfaceCoord::Triangle(i, b))
            }
        }
    }

    /// Texture coordinates of the surface point `p`, whose parametric coordinates are `coord`.
    fn tex_coord(&self, p: Vec3, coord: SurfaceCoord) -> TexCoord {
        match (self, coord) {
            (Self::Shape(shape), SurfaceCoord::Shape(uv)) => shape.tex_coord(p, uv),
            (Self::Triangles { mesh, .. }, SurfaceCoord::Triangle(i, b)) => mesh.tex_coord(i as usize, b),
            (Self::Shape(_), SurfaceCoord::Triangle(..)) | (Self::Triangles { .. }, SurfaceCoord::Shape(_)) => {
                TexCoord::default()
            }
        }
    }

    /// Returns a world-space point just outside the middle of the surface. It is the surface sample
    /// at (½, ½), moved to the outer side by more than the rounding error.
    pub(super) fn representative_point(&self) -> Vec3 {
        let point = self.sample(Vec2::splat(0.5)).point;
        offset_ray_origin(point.p, point.position_error, point.ng, point.ng)
    }

    /// Center of the bounding box, for an analytic shape; an arbitrary point of the surface, for
    /// mesh triangles.
    pub(super) fn center_or_surface_point(&self) -> Vec3 {
        match self {
            Self::Shape(shape) => shape.bounds().center(),
            Self::Triangles { .. } => self.sample(Vec2::splat(0.5)).point.p,
        }
    }

    /// A point of the surface with its normal, if the surface is a disc or a rectangle; `None` for
    /// all other shapes and for mesh triangles.
    fn point_if_planar(&self) -> Option<SurfacePoint> {
        match self {
            Self::Shape(shape) => shape.point_if_planar(),
            Self::Triangles { .. } => None,
        }
    }

    /// Bounding box of the surface, and a cone that contains all outer normals of the surface.
    fn bounds_and_normal_cone(&self) -> (Bounds, DirectionCone) {
        match self {
            Self::Shape(shape) => {
                let cone = |point: SurfacePoint| DirectionCone { axis: point.ng.as_dvec3(), half_angle: NORMAL_ERROR };
                (shape.bounds(), self.point_if_planar().map_or(DirectionCone::ALL, cone))
            }
            Self::Triangles { mesh, first_triangle: first, triangle_distribution: choice } => {
                let triangles = || *first as usize..*first as usize + choice.len();
                // The shading normals at a triangle's corners decide which side is the outer one.
                // If they disagree, both sides may emit.
                let normal = |i| {
                    let [a, b, c] = [Vec2::ZERO, Vec2::X, Vec2::Y].map(|b| mesh.surface_point(i, b).ng);
                    (a == b && b == c).then(|| a.as_dvec3())
                };
                let sum: Option<DVec3> = triangles().map(|i| normal(i).map(|n| n * mesh.triangle_area(i))).sum();
                let around = |axis: DVec3| {
                    let widest = triangles().filter_map(normal).map(|n| angle_between(n, axis)).fold(0.0, f64::max);
                    DirectionCone { axis, half_angle: (widest + NORMAL_ERROR).min(PI_F64) }
                };
                let normals = sum.and_then(DVec3::try_normalize).map_or(DirectionCone::ALL, around);
                (Bounds::from_points(triangles().flat_map(|i| mesh.corners(i))), normals)
            }
        }
    }
}

impl EmissionTexture {
    /// Emitted radiance \[W/(m² sr)] at the surface point that `context` describes.
    #[must_use]
    pub fn radiance(&self, context: &TextureEvalContext) -> Rgb {
        self.texture.evaluate_color(context) * self.scale
    }
}

impl AreaLight {
    /// Creates an area light whose radiance \[W/(m² sr)] is equal at all points of `surface`.
    #[must_use]
    pub fn with_uniform_radiance(surface: LightSurface, radiance: Rgb) -> Self {
        Self { surface, radiance, texture: None }
    }

    /// Emitted flux of the area light \[W]: π · area · mean radiance.
    fn flux(&self) -> Rgb {
        self.radiance * (PI * self.surface.area() as f32)
    }

    /// Samples a point of the surface like [`LightSurface::sample`], and returns it with the
    /// radiance emitted there \[W/(m² sr)].
    #[inline]
    fn sample(&self, u: Vec2) -> (ShapeSample, Rgb) {
        let (sample, coord) = self.surface.sample_point_with_coord(u);
        (sample, self.radiance_at(&sample.point, coord))
    }

    /// Emitted radiance at `point` \[W/(m² sr)]. `coord` holds the parametric coordinates of
    /// `point`.
    #[inline]
    fn radiance_at(&self, point: &SurfacePoint, coord: SurfaceCoord) -> Rgb {
        match &self.texture {
            None => self.radiance,
            Some(emission) => {
                let p = emission.mapping.point_to_object_space(point.p);
                let at = emission.mapping.tex_coord_at(p, || self.surface.tex_coord(point.p, coord));
                emission.radiance(&TextureEvalContext::unfiltered(at.uv, p))
            }
        }
    }

    /// Samples a point of the surface like [`LightSurface::sample`]. Returns the point with its pdf
    /// per solid angle at `p` \[1/sr], and its parametric coordinates.
    ///
    /// Returns `None` if `p` is behind the surface at the sampled point, or equal to this point.
    #[inline]
    fn sample_surface_by_area(&self, p: Vec3, u: Vec2) -> Option<(SolidAngleSample, SurfaceCoord)> {
        let (ShapeSample { point, pdf, .. }, coord) = self.surface.sample_point_with_coord(u);
        let (d2, wi, _) = crate::math::distance2_direction_distance(p, point.p)?;
        let cos = -wi.dot(point.ng);
        (cos > 0.0).then(|| (SolidAngleSample { point, wi, pdf: d2 * pdf / cos }, coord))
    }
}

impl LightSource for AreaLight {
    #[inline]
    fn geometry(&self) -> LightGeometry<'_> {
        LightGeometry::Surface(&self.surface)
    }

    #[inline]
    fn sample_li(&self, p: Vec3, u: Vec2) -> Option<DirectLightSample> {
        // Shapes with solid-angle sampling need no parametric coordinates: they get texture
        // coordinates from the position.
        const NO_COORD: SurfaceCoord = SurfaceCoord::Shape(Vec2::ZERO);
        let by_solid_angle = match &self.surface {
            LightSurface::Shape(shape) => shape.sample_solid_angle(p, u),
            LightSurface::Triangles { .. } => SolidAngleSampleResult::Unsupported,
        };
        let (SolidAngleSample { point, wi, pdf }, coord) = match by_solid_angle {
            SolidAngleSampleResult::Sampled(sample) => (sample, NO_COORD),
            SolidAngleSampleResult::Invisible => return None,
            SolidAngleSampleResult::Unsupported => self.sample_surface_by_area(p, u)?,
        };
        // Rounding of the shadow ray's direction moves the ray's end in proportion to the ray's
        // length.
        let relative_error = match &self.surface {
            LightSurface::Shape(shape) => shape.relative_hit_error(),
            LightSurface::Triangles { .. } => RELATIVE_TRIANGLE_HIT_ERROR,
        };
        let position_error = point.position_error + (point.p - p).abs() * relative_error;
        let target = ShadowTarget::Point(offset_ray_origin(point.p, position_error, point.ng, -wi));
        Some(DirectLightSample { wi, target, weight: self.radiance_at(&point, coord) / pdf, pdf: Some(pdf) })
    }

    #[inline]
    fn pdf_li(&self, p: Vec3, wi: Vec3, hit: Option<&SurfacePoint>) -> f32 {
        let Some(hit) = hit else { return 0.0 };
        let cos = -wi.dot(hit.ng);
        if cos <= 0.0 {
            return 0.0;
        }
        let by_solid_angle = match &self.surface {
            LightSurface::Shape(shape) => shape.solid_angle_pdf(p),
            LightSurface::Triangles { .. } => None,
        };
        by_solid_angle.unwrap_or_else(|| (hit.p - p).length_squared() * self.surface.pdf(hit) / cos)
    }

    fn sample_le(&self, _domain: BoundingSphere, position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        let (ShapeSample { point, pdf, .. }, radiance) = self.sample(position);
        let local = warp::square_to_cosine_hemisphere(direction);
        let w = Frame::from_normal(point.ng).to_world(local);
        if w.dot(point.ng) <= 0.0 || radiance == Rgb::ZERO {
            return None;
        }
        let ray = Ray::new(offset_ray_origin(point.p, point.position_error, point.ng, w), w);
        Some(EmissionSample { ray, weight: radiance * (PI / pdf) })
    }

    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        _domain: BoundingSphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        let (ShapeSample { point, pdf, .. }, radiance) = self.sample(position);
        let (w, pdf_direction) = aim.sample_direction(point.p, Some(point.ng), direction)?;
        let cos = w.dot(point.ng);
        if cos <= 0.0 || radiance == Rgb::ZERO {
            return None;
        }
        let ray = Ray::new(offset_ray_origin(point.p, point.position_error, point.ng, w), w);
        Some(EmissionSample { ray, weight: radiance * (cos / (pdf * pdf_direction)) })
    }

    fn power(&self, _domain: BoundingSphere) -> Rgb {
        self.flux()
    }

    fn bounds(&self) -> Option<LightBounds> {
        let (space, normals) = self.surface.bounds_and_normal_cone();
        Some(LightBounds::new(space, normals, FRAC_PI_2, self.flux()))
    }

    fn may_illuminate(&self, sphere: BoundingSphere) -> bool {
        self.surface.point_if_planar().is_none_or(|point| (sphere.center - point.p).dot(point.ng) >= -sphere.radius)
    }

    fn untextured_light(&self) -> Option<Light> {
        self.texture.is_some().then(|| Light::Area(Self { texture: None, ..self.clone() }))
    }
}
