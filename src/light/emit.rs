//! Emission of photons.

use super::{Emitter, Light, Targets};
use crate::color::Rgb;
use crate::math::{Frame, Ray, Sphere, offset_origin, warp};
use crate::shape::{Shape, ShapeSample};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A ray that leaves a light with flux.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// The ray, of unit direction.
    pub ray: Ray,
    /// Flux over the density of the ray \[W]: its mean over `u` is the light's power, or the part of it that is aimed.
    pub flux: Rgb,
}

impl Light {
    /// Emits for `position` and `direction` in \[0, 1)²: cosine-weighted from surfaces, uniform from points, across the disc of
    /// `domain` for light from infinity.
    #[must_use]
    pub fn emit(&self, domain: Sphere, position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        match self {
            Self::Point { position: p, intensity } => {
                Some(EmissionSample { ray: Ray::new(*p, warp::sphere(direction)), flux: *intensity * (4.0 * PI) })
            }
            Self::Spot(spot) => {
                let w = Frame::around(spot.axis).to_world(warp::cone(direction, spot.outer));
                // As drawn: in a narrow beam the rounding of a direction is a part of its width.
                let intensity = spot.intensity_at(direction.x * spot.outer);
                Some(EmissionSample { ray: Ray::new(spot.position, w), flux: intensity * (TAU * spot.outer) })
            }
            Self::Directional { direction: w, irradiance } => {
                let (ray, area) = across(domain, *w, position)?;
                Some(EmissionSample { ray, flux: *irradiance * area })
            }
            Self::Area(area) => {
                let (ShapeSample { point, pdf, .. }, radiance) = area.sample(position);
                let local = warp::cosine_hemisphere(direction);
                let w = Frame::around(point.ng).to_world(local);
                if w.dot(point.ng) <= 0.0 || radiance == Rgb::ZERO {
                    return None;
                }
                let ray = Ray::new(offset_origin(point.p, point.error, point.ng, w), w);
                Some(EmissionSample { ray, flux: radiance * (PI / pdf) })
            }
            Self::Environment(environment) => {
                let (from, pdf) = environment.sample(direction)?;
                let (ray, area) = across(domain, -from, position)?;
                Some(EmissionSample { ray, flux: environment.radiance(from) * (area / pdf) })
            }
        }
    }

    /// Emits towards `targets` only; rays that miss all of them are never drawn.
    #[must_use]
    pub fn emit_at(
        &self,
        targets: &Targets,
        domain: Sphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        match self {
            Self::Point { position: p, intensity } => {
                let (w, pdf) = targets.sample_direction(*p, None, direction)?;
                Some(EmissionSample { ray: Ray::new(*p, w), flux: *intensity / pdf })
            }
            Self::Spot(spot) => {
                let (w, pdf) = targets.sample_direction(spot.position, None, direction)?;
                let intensity = spot.intensity(w);
                (intensity != Rgb::ZERO)
                    .then(|| EmissionSample { ray: Ray::new(spot.position, w), flux: intensity / pdf })
            }
            Self::Directional { direction: w, irradiance } => {
                let upstream = domain.radius - w.dot(domain.center);
                let (start, pdf) = targets.sample_parallel(*w, upstream, position)?;
                Some(EmissionSample { ray: Ray::new(start, *w), flux: *irradiance / pdf })
            }
            Self::Area(area) => {
                let (ShapeSample { point, pdf, .. }, radiance) = area.sample(position);
                let (w, pdf_w) = targets.sample_direction(point.p, Some(point.ng), direction)?;
                let cos = w.dot(point.ng);
                if cos <= 0.0 || radiance == Rgb::ZERO {
                    return None;
                }
                let ray = Ray::new(offset_origin(point.p, point.error, point.ng, w), w);
                Some(EmissionSample { ray, flux: radiance * (cos / (pdf * pdf_w)) })
            }
            Self::Environment(environment) => {
                let (from, pdf) = environment.sample(direction)?;
                let upstream = domain.radius + from.dot(domain.center);
                let (start, pdf_start) = targets.sample_parallel(-from, upstream, position)?;
                Some(EmissionSample {
                    ray: Ray::new(start, -from),
                    flux: environment.radiance(from) / (pdf * pdf_start),
                })
            }
        }
    }

    /// A point from which it shines, off its own surface; `None` for light from infinity.
    #[must_use]
    pub fn start(&self) -> Option<Vec3> {
        match self {
            Self::Area(area) => {
                let point = area.emitter.sample(Vec2::splat(0.5)).point;
                Some(offset_origin(point.p, point.error, point.ng, point.ng))
            }
            other => other.center(),
        }
    }

    /// A point that stands for the light's place in the simple shading of ray casting; `None` for light from infinity.
    #[must_use]
    pub fn center(&self) -> Option<Vec3> {
        match self {
            Self::Point { position, .. } => Some(*position),
            Self::Spot(spot) => Some(spot.position),
            Self::Directional { .. } | Self::Environment(_) => None,
            Self::Area(area) => Some(match &area.emitter {
                Emitter::Shape(shape) => Shape::bounds(shape).center(),
                emitter @ Emitter::Triangles { .. } => emitter.sample(Vec2::splat(0.5)).point.p,
            }),
        }
    }
}

/// A ray in unit `direction` from a uniform point of the disc that `domain` shows it, with the disc's area; `None` where that is
/// nothing.
fn across(domain: Sphere, direction: Vec3, u: Vec2) -> Option<(Ray, f32)> {
    let frame = Frame::around(direction);
    let d = warp::disc(u) * domain.radius;
    let p = domain.center + frame.s * d.x + frame.t * d.y;
    let start = p - direction * (domain.radius + direction.dot(p - domain.center));
    let area = PI * domain.radius * domain.radius;
    (area > 0.0).then(|| (Ray::new(start, direction), area))
}
