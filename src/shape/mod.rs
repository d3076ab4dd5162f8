//! Shapes in the resolved scene: world space, re-centred. Curved ones solve in double precision.

mod disc;
mod ellipsoid;
mod instance;
mod mesh;
pub mod parametric;
mod plane;
mod rectangle;
mod sphere;
mod texture_mapping;

pub use disc::Disc;
pub use ellipsoid::Ellipsoid;
pub use instance::{IndexedMesh, Instance};
pub use mesh::{Mesh, Triangle};
pub use plane::Plane;
pub use rectangle::Rectangle;
pub use sphere::Sphere;
pub use texture_mapping::{Form, TexCoord, TextureMapping, upright};

pub use parametric::{Patch, Revolution};

use crate::math::{Bounds, Ray, Transform};
use glam::{DVec3, Vec2, Vec3};

/// Where a ray meets a shape: the ray's parameter, and two coordinates whose meaning is the shape's own.
pub type Crossing = (f32, f32, f32);

/// The surface around one point.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The point.
    pub p: Vec3,
    /// How far the true point may lie from `p` along each axis, and how far off the next ray's test may see it.
    pub error: Vec3,
    /// Geometric unit normal, on the shape's outer side.
    pub ng: Vec3,
    /// Shading unit normal, in the same half space as `ng`.
    pub ns: Vec3,
    /// The coordinates of the point that its shape gave it.
    pub uv: Vec2,
}

impl SurfacePoint {
    /// A point known in double precision on a surface whose coordinates reach `scale`; flat shading.
    #[inline]
    fn exact(p: DVec3, normal: DVec3, scale: f64) -> Self {
        let ng = normal.as_vec3();
        let rounded = p.as_vec3();
        Self { p: rounded, error: rounding_error(rounded, scale), ng, ns: ng, uv: Vec2::ZERO }
    }
}

/// A point on a shape, drawn by area.
#[derive(Clone, Copy, Debug)]
pub struct ShapeSample {
    /// The point and its normal.
    pub point: SurfacePoint,
    /// Density per area \[1/length²].
    pub pdf: f32,
    /// The coordinates of a [`Crossing`] there.
    pub uv: Vec2,
}

/// Rounding to f32 costs half an ulp of each coordinate; the next test in f64 sees the shape within 32 ulps of `scale`.
#[inline]
fn rounding_error(p: Vec3, scale: f64) -> Vec3 {
    p.abs() * f32::EPSILON + Vec3::splat((scale * (32.0 * f64::EPSILON)) as f32)
}

/// A bounded analytic shape.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A sphere under an affine map.
    Ellipsoid(Ellipsoid),
    /// A disc, or an ellipse in the plane.
    Disc(Disc),
    /// A parallelogram.
    Rectangle(Rectangle),
    /// A mesh that is placed by a map.
    Instance(Instance),
    /// A profile turned about an axis.
    Revolution(Revolution),
    /// A tensor-product surface.
    Patch(Patch),
}

macro_rules! each {
    ($self:expr, $s:ident => $e:expr) => {
        match $self {
            Shape::Sphere($s) => $e,
            Shape::Ellipsoid($s) => $e,
            Shape::Disc($s) => $e,
            Shape::Rectangle($s) => $e,
            Shape::Instance($s) => $e,
            Shape::Revolution($s) => $e,
            Shape::Patch($s) => $e,
        }
    };
}

impl Shape {
    /// The nearest crossing within the ray.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<Crossing> {
        each!(self, s => s.intersect(ray))
    }

    /// Whether the shape crosses the ray.
    #[inline]
    #[must_use]
    pub fn occludes(&self, ray: &Ray) -> bool {
        match self {
            Self::Instance(s) => s.occludes(ray),
            shape => shape.intersect(ray).is_some(),
        }
    }

    /// The surface where `ray` crosses it at `t`, with the coordinates `uv` of the [`Crossing`].
    #[inline]
    #[must_use]
    pub fn surface(&self, ray: &Ray, t: f32, uv: Vec2) -> SurfacePoint {
        match self {
            Self::Sphere(s) => s.surface(ray, unrounded(t, uv)),
            Self::Ellipsoid(s) => s.surface(ray, unrounded(t, uv)),
            Self::Disc(s) => s.surface(ray, t),
            Self::Rectangle(s) => s.surface(ray, t),
            Self::Revolution(s) => s.surface(ray, uv),
            Self::Patch(s) => s.surface(ray, uv),
            Self::Instance(s) => s.surface(ray, uv.x),
        }
    }

    /// Texture coordinates at `p` by what the shape itself says, with `uv` of the [`Crossing`]; of those that say nothing, `uv` as it is.
    #[must_use]
    pub fn mapped(&self, p: Vec3, uv: Vec2) -> TexCoord {
        match self {
            Self::Instance(s) => s.mapped(p, uv.x),
            Self::Revolution(s) => s.mapped(p, uv),
            Self::Patch(s) => s.mapped(uv),
            _ => TexCoord { uv: uv.as_dvec2(), ..TexCoord::default() },
        }
    }

    /// A box around the shape.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let (min, max) = self.extent();
        outer_bounds(min, max)
    }

    /// The box around the shape in double precision.
    #[must_use]
    pub fn extent(&self) -> (DVec3, DVec3) {
        each!(self, s => s.extent())
    }

    /// The shape moved by a vector.
    #[must_use]
    pub fn translated(&self, by: DVec3) -> Self {
        match self {
            Self::Sphere(s) => Self::Sphere(s.translated(by)),
            Self::Ellipsoid(s) => Self::Ellipsoid(s.translated(by)),
            Self::Disc(s) => Self::Disc(s.translated(by)),
            Self::Rectangle(s) => Self::Rectangle(s.translated(by)),
            Self::Instance(s) => Self::Instance(s.translated(by)),
            Self::Revolution(s) => Self::Revolution(s.translated(by)),
            Self::Patch(s) => Self::Patch(s.translated(by)),
        }
    }

    /// The image under an affine map, with the same outer side; `None` where it has no extent left that numbers can hold.
    #[must_use]
    pub fn transformed(&self, map: &Transform) -> Option<Self> {
        Some(match self {
            Self::Sphere(s) => match map.similarity() {
                Some(scale) => Self::Sphere(Sphere::new(map.point(s.center), s.radius * scale)),
                None => Self::Ellipsoid(Ellipsoid::around(s, map)?),
            },
            Self::Ellipsoid(s) => Self::Ellipsoid(s.transformed(map)?),
            Self::Disc(s) => Self::Disc(s.transformed(map)),
            Self::Rectangle(s) => Self::Rectangle(s.transformed(map)),
            Self::Instance(s) => Self::Instance(s.transformed(map)?),
            Self::Revolution(s) => Self::Revolution(s.transformed(map)?),
            Self::Patch(s) => Self::Patch(s.transformed(map)?),
        })
    }

    /// Area of the surface \[length²].
    #[must_use]
    pub fn area(&self) -> f64 {
        each!(self, s => s.area())
    }

    /// A point of the surface for `u` in \[0, 1)².
    #[must_use]
    pub fn sample(&self, u: Vec2) -> ShapeSample {
        each!(self, s => s.sample(u))
    }

    /// Density per area \[1/length²] with which [`Shape::sample`] draws a point of the surface.
    #[inline]
    #[must_use]
    pub fn pdf(&self, point: &SurfacePoint) -> f32 {
        match self {
            Self::Ellipsoid(s) => s.pdf(point.ng.as_dvec3()),
            Self::Revolution(s) => s.pdf(point),
            Self::Patch(s) => s.pdf(point),
            uniform => (1.0 / uniform.area()) as f32,
        }
    }
}

/// The ray in double precision.
#[inline]
fn widen(ray: &Ray) -> (DVec3, DVec3) {
    (ray.origin.as_dvec3(), ray.direction.as_dvec3())
}

/// How far from the edges of a face its points are kept, in their largest error along an axis.
///
/// A ray leaves a point that is up to √3 errors off from as far again along the normal. Where another face meets this one at angle θ, both may
/// put its start beyond that face: then it escapes through the edge, or meets a wall twice. At distance s from the edge it is within while
/// s·sin θ > √3·(1 + cos θ) errors, which 16 errors allow for down to θ = 12.4°.
const INSET: f64 = 16.0;

/// `t` as f32 if it lies inside the ray.
#[inline]
fn within(ray: &Ray, t: f64) -> Option<f32> {
    let t = t as f32;
    (t > 0.0 && t < ray.t_max).then_some(t)
}

/// `t` inside the ray as a crossing that keeps, as its first coordinate, what the rounding to f32 lost, in parts of `t`: far away it may be
/// a good part of the shape, and in a thin one take the near side for the far one.
#[inline]
fn crossing(ray: &Ray, t: f64) -> Option<Crossing> {
    within(ray, t).map(|rounded| (rounded, (t / f64::from(rounded) - 1.0) as f32, 0.0))
}

/// The parameter that a [`crossing`] was made of.
#[inline]
fn unrounded(t: f32, uv: Vec2) -> f64 {
    f64::from(t) * (1.0 + f64::from(uv.x))
}

/// The box around points in double precision, grown by the rounding to f32.
fn outer_bounds(min: DVec3, max: DVec3) -> Bounds {
    let down = |x: f64| (x as f32).next_down();
    let up = |x: f64| (x as f32).next_up();
    Bounds { min: Vec3::new(down(min.x), down(min.y), down(min.z)), max: Vec3::new(up(max.x), up(max.y), up(max.z)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::offset_origin;
    use crate::sampling::{Dimension, Key, Purpose};
    use glam::DAffine3;

    fn shapes() -> Vec<Shape> {
        let squash = Transform::new(DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, 0.2, 2.5),
            glam::DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5),
            DVec3::new(0.3, -2.0, 1.0),
        ))
        .unwrap();
        vec![
            Shape::Sphere(Sphere::new(DVec3::new(1.0, 2.0, -0.5), 0.7)),
            Shape::Ellipsoid(Ellipsoid::new(squash)),
            Shape::Disc(Disc::new(DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.0, 0.2, 1.0))),
            Shape::Rectangle(Rectangle::new(DVec3::ONE, DVec3::new(2.0, 0.1, 0.0), DVec3::new(0.3, 1.0, 0.5))),
        ]
    }

    /// The mean of 1/pdf over samples is the area; the bound is five standard errors measured from the samples.
    #[test]
    fn sampled_points_lie_on_the_shape_with_the_stated_density() {
        for shape in shapes() {
            let (n, mut sum, mut squares) = (100_000u64, 0.0, 0.0);
            for i in 0..n {
                let s = shape.sample(Key::new(3).purpose(Purpose::Test).with(i).uniform_2d(Dimension::LightPosition));
                let inverse = 1.0 / f64::from(s.pdf);
                sum += inverse;
                squares += inverse * inverse;
                // The normal is rounded to f32.
                assert!((shape.pdf(&s.point) * inverse as f32 - 1.0).abs() < 1e-6, "{shape:?}");
                if i < 1000 {
                    let above = s.point.p + s.point.ng * 0.1;
                    let ray = Ray::new(above, -s.point.ng);
                    let (t, u, v) = shape.intersect(&ray).expect("a ray at a sampled point hits");
                    assert!((t - 0.1).abs() < 1e-5, "{shape:?} {t}");
                    let back = shape.surface(&ray, t, Vec2::new(u, v));
                    assert!((back.p - s.point.p).length() < 1e-5 && back.ng.dot(s.point.ng) > 1.0 - 1e-4);
                }
            }
            let mean = sum / n as f64;
            let sigma = ((squares / n as f64 - mean * mean).max(0.0) / n as f64).sqrt();
            assert!((mean - shape.area()).abs() < 5.0 * sigma + 1e-6 * shape.area(), "{shape:?}: {mean}");
        }
    }

    /// Rays that leave an offset point away from the shape never meet it again; rays into it never meet its skin twice.
    #[test]
    fn offset_rays_leave_cleanly() {
        for scale in [1e-3, 1.0, 1e4] {
            for center in [DVec3::ZERO, DVec3::new(3.0, -200.0, 1e3) * scale] {
                let sphere = Shape::Sphere(Sphere::new(center, scale));
                for i in 0..20_000u64 {
                    let key = Key::new(5).purpose(Purpose::Test).with(i);
                    let s = sphere.sample(key.uniform_2d(Dimension::LightPosition)).point;
                    let d = crate::math::warp::cosine_hemisphere(key.uniform_2d(Dimension::LightDirection));
                    let d = crate::math::Frame::around(s.ng).to_world(d);
                    let out = Ray::new(offset_origin(s.p, s.error, s.ng, d), d);
                    assert!(sphere.intersect(&out).is_none(), "{scale} {center} {i}");
                    let inside = Ray::new(offset_origin(s.p, s.error, s.ng, -d), -d);
                    let (t, ..) = sphere.intersect(&inside).expect("an inner ray meets the far side");
                    let chord = 2.0 * scale as f32 * d.dot(s.ng);
                    assert!(
                        (t - chord).abs() < 1e-3 * chord + 4.0 * s.error.max_element() / d.dot(s.ng),
                        "{t} {chord}"
                    );
                }
            }
        }
    }

    #[test]
    fn spheres_stay_spheres_under_similarities_only() {
        let ball = Shape::Sphere(Sphere::new(DVec3::X, 0.5));
        let twice = Transform::new(DAffine3::from_scale(DVec3::splat(-2.0))).unwrap();
        match ball.transformed(&twice) {
            Some(Shape::Sphere(s)) => assert_eq!((s.center, s.radius), (DVec3::new(-2.0, 0.0, 0.0), 1.0)),
            other => panic!("{other:?}"),
        }
        let stretched = Transform::new(DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0))).unwrap();
        assert!(matches!(ball.transformed(&stretched), Some(Shape::Ellipsoid(_))));
    }

    #[test]
    fn boxes_contain_their_shapes() {
        for shape in shapes() {
            let b = shape.bounds();
            for i in 0..5000u64 {
                let u = Key::new(1).purpose(Purpose::Test).with(i).uniform_2d(Dimension::LightPosition);
                let p = shape.sample(u).point.p;
                assert!(p.cmpge(b.min).all() && p.cmple(b.max).all(), "{shape:?} {p}");
            }
        }
    }
}
