//! Surfaces that radiate.

use super::{DirectSample, Reach};
use crate::color::Rgb;
use crate::math::offset_origin;
use crate::sampling::Discrete;
use crate::shape::{Mesh, Shape, ShapeSample, SurfacePoint};
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

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

/// Uniform radiance from the outer side of a surface.
#[derive(Clone, Debug)]
pub struct Area {
    /// The surface.
    pub emitter: Emitter,
    /// Radiance \[W/(m² sr)].
    pub radiance: Rgb,
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
        match self {
            Self::Shape(shape) => shape.sample(u),
            Self::Triangles { mesh, first, choice } => {
                let (i, probability) = choice.sample(u.x);
                // What is left of u.x inside the chosen interval is uniform again.
                let x = choice.remainder(u.x, i);
                let point = mesh.surface(*first as usize + i, crate::math::warp::triangle(Vec2::new(x, u.y)));
                let area = choice.total() * f64::from(probability);
                ShapeSample { point, pdf: probability / area as f32 }
            }
        }
    }
}

impl Area {
    /// Flux \[W]: πL times the area.
    #[must_use]
    pub fn power(&self) -> Rgb {
        self.radiance * (PI * self.emitter.area() as f32)
    }

    #[inline]
    pub(super) fn sample_direct(&self, p: Vec3, u: Vec2) -> Option<DirectSample> {
        let (point, wi, pdf) = match &self.emitter {
            // Outside a sphere only the visible cap counts; inside it, its outer side cannot be seen.
            Emitter::Shape(Shape::Sphere(sphere)) => {
                let (point, pdf) = sphere.sample_visible(p, u)?;
                let (_, wi, _) = crate::math::direction(p, point.p)?;
                (point, wi, pdf)
            }
            Emitter::Shape(Shape::Rectangle(rectangle)) => {
                rectangle.sample_visible(p, u).or_else(|| self.sample_by_area(p, u))?
            }
            _ => self.sample_by_area(p, u)?,
        };
        let reach = Reach::Point(offset_origin(point.p, point.error, point.ng, -wi));
        Some(DirectSample { wi, reach, irradiance: self.radiance / pdf, pdf: Some(pdf) })
    }

    /// A point, the unit direction to it from `p`, and its density per steradian.
    #[inline]
    fn sample_by_area(&self, p: Vec3, u: Vec2) -> Option<(SurfacePoint, Vec3, f32)> {
        let ShapeSample { point, pdf } = self.emitter.sample(u);
        let (d2, wi, _) = crate::math::direction(p, point.p)?;
        let cos = -wi.dot(point.ng);
        (cos > 0.0).then(|| (point, wi, d2 * pdf / cos))
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
