//! Surfaces that radiate.

use super::{DirectSample, ShadowTarget};
use crate::color::Rgb;
use crate::math::offset_origin;
use crate::sampling::Discrete;
use crate::shape::{Mesh, Shape, ShapeSample, SurfacePoint, TexCoord, TextureMapping};
use crate::texture::{Texture, TextureEvalContext};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// How far from a distant triangle, in parts of the way, a ray may meet it: shearing rounds a few times what f64 does not.
const TRIANGLE_BLUR: f32 = 4.0 * f32::EPSILON;

/// The surface of an area light.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// An analytic shape.
    Shape(Shape),
    /// Triangles `first ..` of a mesh, chosen by area.
    Triangles {
        /// The mesh.
        mesh: Arc<Mesh>,
        /// The first triangle.
        first: u32,
        /// Weight of each triangle from the first on.
        choice: Discrete,
    },
}

/// Radiance from the outer side of a surface.
#[derive(Clone, Debug)]
pub struct Area {
    /// The surface.
    pub emitter: Emitter,
    /// Radiance \[W/(m² sr)]; where it varies, its mean.
    pub radiance: Rgb,
    /// How radiance varies over the surface; `None` where it is the same everywhere.
    pub glow: Option<Arc<EmissionTexture>>,
}

/// Radiance that follows a texture.
#[derive(Clone, Debug)]
pub struct EmissionTexture {
    /// The texture.
    pub texture: Arc<Texture>,
    /// How it lies on the surface.
    pub chart: TextureMapping,
    /// What it is multiplied by \[W/(m² sr)].
    pub scale: Rgb,
}

/// Where a point of an emitter was drawn, as its own coordinates go by.
#[derive(Clone, Copy, Debug)]
enum Spot {
    Shape(Vec2),
    Triangle(u32, Vec2),
}

impl Emitter {
    /// Area of the surface \[length²].
    #[must_use]
    pub fn area(&self) -> f64 {
        match self {
            Self::Shape(shape) => shape.area(),
            Self::Triangles { choice, .. } => choice.total(),
        }
    }

    /// Density per area \[1/length²] with which [`Emitter::sample`] draws a point of the surface.
    #[inline]
    #[must_use]
    pub fn pdf(&self, point: &SurfacePoint) -> f32 {
        match self {
            Self::Shape(shape) => shape.pdf(point),
            Self::Triangles { choice, .. } => (1.0 / choice.total()) as f32,
        }
    }

    /// A point, with its density per area.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> ShapeSample {
        self.draw(u).0
    }

    #[inline]
    fn draw(&self, u: Vec2) -> (ShapeSample, Spot) {
        match self {
            Self::Shape(shape) => {
                let sample = shape.sample(u);
                (sample, Spot::Shape(sample.uv))
            }
            Self::Triangles { mesh, first, choice } => {
                let (i, probability) = choice.sample(u.x);
                // What is left of u.x inside the chosen interval is uniform again.
                let x = choice.remainder(u.x, i);
                let b = crate::math::warp::triangle(Vec2::new(x, u.y));
                let i = *first + i as u32;
                let point = mesh.surface(i as usize, b);
                let area = choice.total() * f64::from(probability);
                (ShapeSample { point, pdf: probability / area as f32, uv: b }, Spot::Triangle(i, b))
            }
        }
    }

    /// Texture coordinates of a point, as the surface itself has them.
    fn mapped(&self, p: Vec3, spot: Spot) -> TexCoord {
        match (self, spot) {
            (Self::Shape(shape), Spot::Shape(uv)) => shape.mapped(p, uv),
            (Self::Triangles { mesh, .. }, Spot::Triangle(i, b)) => mesh.mapped(i as usize, b),
            _ => TexCoord::default(),
        }
    }
}

impl EmissionTexture {
    /// Radiance at a place of the surface \[W/(m² sr)].
    #[must_use]
    pub fn radiance(&self, place: &TextureEvalContext) -> Rgb {
        self.texture.color(place) * self.scale
    }
}

impl Area {
    /// The same radiance everywhere.
    #[must_use]
    pub fn even(emitter: Emitter, radiance: Rgb) -> Self {
        Self { emitter, radiance, glow: None }
    }

    /// A point of the surface, drawn by area, with its radiance.
    #[inline]
    pub(super) fn sample(&self, u: Vec2) -> (ShapeSample, Rgb) {
        let (sample, spot) = self.emitter.draw(u);
        (sample, self.radiance_at(&sample.point, spot))
    }

    #[inline]
    fn radiance_at(&self, point: &SurfacePoint, spot: Spot) -> Rgb {
        match &self.glow {
            None => self.radiance,
            Some(glow) => {
                let p = glow.chart.in_object(point.p);
                glow.radiance(&TextureEvalContext::sharp(glow.chart.at(p, || self.emitter.mapped(point.p, spot)).uv, p))
            }
        }
    }

    /// Flux \[W]: πL times the area.
    #[must_use]
    pub fn power(&self) -> Rgb {
        self.radiance * (PI * self.emitter.area() as f32)
    }

    #[inline]
    pub(super) fn sample_direct(&self, p: Vec3, u: Vec2) -> Option<DirectSample> {
        const ANY: Spot = Spot::Shape(Vec2::ZERO);
        let ((point, wi, pdf), spot) = match &self.emitter {
            // Outside a sphere only the visible cap counts; inside it, its outer side cannot be seen.
            Emitter::Shape(Shape::Sphere(sphere)) => {
                let (point, pdf) = sphere.sample_visible(p, u)?;
                let (_, wi, _) = crate::math::direction(p, point.p)?;
                ((point, wi, pdf), ANY)
            }
            Emitter::Shape(Shape::Rectangle(rectangle)) => match rectangle.sample_visible(p, u) {
                Some(seen) => (seen, ANY),
                None => self.sample_by_area(p, u)?,
            },
            _ => self.sample_by_area(p, u)?,
        };
        // A shadow ray's direction is rounded: its end may miss the place it was meant for by so much of its length.
        let blur = match &self.emitter {
            Emitter::Triangles { .. } | Emitter::Shape(Shape::Instance(_)) => TRIANGLE_BLUR,
            Emitter::Shape(_) => f32::EPSILON,
        };
        let error = point.error + (point.p - p).abs() * blur;
        let reach = ShadowTarget::Point(offset_origin(point.p, error, point.ng, -wi));
        Some(DirectSample { wi, reach, irradiance: self.radiance_at(&point, spot) / pdf, pdf: Some(pdf) })
    }

    /// A point, the unit direction to it from `p`, and its density per steradian.
    #[inline]
    fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<((SurfacePoint, Vec3, f32), Spot)> {
        let (ShapeSample { point, pdf, .. }, spot) = self.emitter.draw(u);
        let (d2, wi, _) = crate::math::direction(p, point.p)?;
        let cos = -wi.dot(point.ng);
        (cos > 0.0).then(|| ((point, wi, d2 * pdf / cos), spot))
    }

    #[inline]
    pub(super) fn density(&self, p: Vec3, wi: Vec3, seen: &SurfacePoint) -> f32 {
        let cos = -wi.dot(seen.ng);
        if cos <= 0.0 {
            return 0.0;
        }
        let by_area = || (seen.p - p).length_squared() * self.emitter.pdf(seen) / cos;
        match &self.emitter {
            Emitter::Shape(Shape::Sphere(sphere)) => sphere.visible_density(p),
            Emitter::Shape(Shape::Rectangle(rectangle)) => rectangle.visible_density(p).unwrap_or_else(by_area),
            _ => by_area(),
        }
    }
}
