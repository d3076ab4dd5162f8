//! Environment lights.

use super::PhotonAim;
use super::directional::ray_across;
use super::light_bounds::LightBounds;
use super::source::{DirectSample, EmissionDimensions, EmissionSample, LightSource, ShadowTarget};
use crate::color::{self, Rgb};
use crate::image::{Image, SizeError};
use crate::math::{Ray, Sphere};
use crate::sampling::Piecewise2d;
use crate::shape::SurfacePoint;
use glam::{DVec3, UVec2, Vec2, Vec3};
use libm::{atan2, cos, hypot, sin};
use std::f64::consts::{PI, TAU};

/// Reason why an environment map is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EnvironmentError {
    /// A pixel has a radiance that is negative or not finite. Pixels count from the top left.
    #[error(
        "the radiance in column {x}, row {y} is {value}: repair the picture so that all are finite and none below 0"
    )]
    Radiance {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// The scaled radiance.
        value: Rgb,
    },
    /// The map has no pixels.
    #[error(transparent)]
    Size(#[from] SizeError),
}

/// Radiance from infinity in all directions, given by a map.
///
/// The map is equirectangular; its top row is +y. Without rotation, its center is −z, and the direction to the right of the
/// center is +x. Radiance is interpolated bilinearly between pixels, also across the seam.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    map: Image,
    /// Sine and cosine of the rotation about +y.
    rotation: [f32; 2],
    /// Distribution over the pixels; `None` if the map is black.
    distribution: Option<Piecewise2d>,
    /// Cosine with +y of the upper edge of each row, and of the lower edge of the last row.
    edges: Vec<f64>,
    /// Integral of the radiance over all directions \[W/m²].
    integral: Rgb,
}

impl EnvironmentLight {
    /// The light of a map times `scale` \[W/(m² sr)], rotated by `angle` \[radians] about +y, anticlockwise from above.
    ///
    /// # Errors
    /// [`EnvironmentError::Radiance`] if a scaled pixel is negative or not finite.
    pub fn new(mut map: Image, angle: f64, scale: Rgb) -> Result<Self, EnvironmentError> {
        let width = map.width();
        for (i, pixel) in map.pixels_mut().iter_mut().enumerate() {
            let value = *pixel * scale;
            if !(value.is_finite() && value.cmpge(Rgb::ZERO).all()) {
                return Err(EnvironmentError::Radiance { x: i as u32 % width, y: i as u32 / width, value });
            }
            *pixel = value;
        }
        let (w, h) = (width as usize, map.height() as usize);
        let edges: Vec<f64> = (0..=h).map(|row| cos(PI * row as f64 / h as f64)).collect();
        let brightness = |x: usize, y: usize| f64::from(color::mean(map.pixels()[y * w + x]));
        // The mean of the interpolated radiance over a pixel is positive wherever the radiance is.
        let across = |x: usize, y: usize| {
            0.125 * (brightness((x + w - 1) % w, y) + brightness((x + 1) % w, y)) + 0.75 * brightness(x, y)
        };
        let weight = |x: usize, y: usize| {
            let mean = 0.125 * (across(x, y.saturating_sub(1)) + across(x, (y + 1).min(h - 1))) + 0.75 * across(x, y);
            mean * (edges[y] - edges[y + 1])
        };
        let distribution = Piecewise2d::new(w, h, weight);
        let rows = map
            .pixels()
            .chunks(w)
            .enumerate()
            .map(|(y, row)| row.iter().map(|p| p.as_dvec3()).sum::<DVec3>() * (row_measure(y, h) * TAU / w as f64));
        let integral = rows.sum::<DVec3>().as_vec3();
        Ok(Self { rotation: [sin(angle) as f32, cos(angle) as f32], distribution, edges, integral, map })
    }

    /// A light with the same radiance in all directions \[W/(m² sr)].
    ///
    /// # Errors
    /// [`EnvironmentError::Radiance`] if the radiance is negative or not finite.
    pub fn constant(radiance: Rgb) -> Result<Self, EnvironmentError> {
        Self::new(Image::from_pixels(1, 1, vec![radiance])?, 0.0, Rgb::ONE)
    }

    /// Radiance that arrives from unit `direction` \[W/(m² sr)].
    #[inline]
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        let at = self.pixel(direction) - DVec3::new(0.5, 0.5, 0.0);
        let (w, h) = (self.map.width() as i64, self.map.height() as i64);
        let (x, y) = (at.x.floor(), at.y.floor());
        let (fx, fy) = ((at.x - x) as f32, (at.y - y) as f32);
        let row = |y: i64| {
            let row = &self.map.pixels()[(y.clamp(0, h - 1) * w) as usize..][..w as usize];
            row[(x as i64).rem_euclid(w) as usize].lerp(row[(x as i64 + 1).rem_euclid(w) as usize], fx)
        };
        row(y as i64).lerp(row(y as i64 + 1), fy)
    }

    /// Column and row of unit `direction`, in pixels from the top left corner of the map.
    #[inline]
    fn pixel(&self, direction: Vec3) -> DVec3 {
        let [sin, cos] = self.rotation;
        let x = f64::from(cos * direction.x - sin * direction.z);
        let z = f64::from(sin * direction.x + cos * direction.z);
        let (u, v) = (0.5 + atan2(x, -z) / TAU, atan2(hypot(x, z), f64::from(direction.y)) / PI);
        DVec3::new(u * f64::from(self.map.width()), v * f64::from(self.map.height()), 0.0)
    }

    /// Pdf \[1/sr] with which [`EnvironmentLight::sample`] samples unit `direction`.
    #[inline]
    #[must_use]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let Some(distribution) = &self.distribution else {
            return 0.0;
        };
        let at = self.pixel(direction);
        // Rounding may give a column or row beyond the last: the seam and −y.
        let column = at.x as u32 % self.map.width();
        let row = (at.y as u32).min(self.map.height() - 1);
        let height = self.edges[row as usize] - self.edges[row as usize + 1];
        distribution.pdf(UVec2::new(column, row)) / (TAU * f64::from(self.map.height()) * height) as f32
    }

    /// Samples a unit direction by the radiance of pixels, uniformly within each pixel, with its pdf \[1/sr].
    ///
    /// `None` if the map is black.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (cell, within, _) = self.distribution.as_ref()?.sample(u);
        let row = cell.y as usize;
        let y = self.edges[row] + f64::from(within.y) * (self.edges[row + 1] - self.edges[row]);
        let radius = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
        let angle = (f64::from(cell.x) + f64::from(within.x)) / f64::from(self.map.width()) - 0.5;
        let (s, c) = libm::sincos(angle * TAU);
        let (x, z) = ((radius * s) as f32, (-radius * c) as f32);
        let [sin, cos] = self.rotation;
        let direction = Vec3::new(cos * x + sin * z, y as f32, cos * z - sin * x);
        // Rounding may move the direction to the next pixel; the pdf must be that of the next pixel.
        let pdf = self.pdf(direction);
        (pdf > 0.0).then_some((direction, pdf))
    }
}

impl LightSource for EnvironmentLight {
    #[inline]
    fn sample_li(&self, _p: Vec3, u: Vec2) -> Option<DirectSample> {
        let (wi, pdf) = self.sample(u)?;
        Some(DirectSample { wi, target: ShadowTarget::Infinity, weight: self.radiance(wi) / pdf, pdf: Some(pdf) })
    }

    #[inline]
    fn pdf_li(&self, _p: Vec3, wi: Vec3, _hit: Option<&SurfacePoint>) -> f32 {
        self.pdf(wi)
    }

    fn sample_le(&self, domain: Sphere, position: Vec2, direction: Vec2) -> Option<EmissionSample> {
        let (from, pdf) = self.sample(direction)?;
        let (ray, area) = ray_across(domain, -from, position)?;
        Some(EmissionSample { ray, flux: self.radiance(from) * (area / pdf) })
    }

    fn sample_le_towards(
        &self,
        aim: &PhotonAim,
        domain: Sphere,
        position: Vec2,
        direction: Vec2,
    ) -> Option<EmissionSample> {
        let (from, pdf) = self.sample(direction)?;
        let upstream = domain.radius + from.dot(domain.center);
        let (start, pdf_start) = aim.sample_parallel(-from, upstream, position)?;
        Some(EmissionSample { ray: Ray::new(start, -from), flux: self.radiance(from) / (pdf * pdf_start) })
    }

    fn emission_dimensions(&self) -> EmissionDimensions {
        EmissionDimensions { position: true, direction: true }
    }

    /// Flux \[W] through a disc with the radius of `domain`, over all directions: π r² ∫ L dω.
    fn power(&self, domain: Sphere) -> Rgb {
        self.integral * (std::f32::consts::PI * domain.radius * domain.radius)
    }

    fn bounds(&self) -> Option<LightBounds> {
        None
    }

    #[inline]
    fn is_delta(&self) -> bool {
        false
    }

    #[inline]
    fn is_infinite(&self) -> bool {
        true
    }

    fn peak(&self) -> Option<Rgb> {
        None
    }
}

/// Integral over the cosine with +y of the interpolation weight of row `y` of `h`.
///
/// The weight is a hat function of the angle from +y. Beyond the centers of the first and the last row it is constant.
fn row_measure(y: usize, h: usize) -> f64 {
    let step = PI / h as f64;
    let center = (y as f64 + 0.5) * step;
    if h == 1 {
        return 2.0;
    }
    if y == 0 || y == h - 1 {
        // The constant part contributes 1 − cos, then the falling flank. The last row mirrors the first.
        return 1.0 - (sin(1.5 * step) - sin(0.5 * step)) / step;
    }
    sin(center) * 2.0 * (1.0 - cos(step)) / step
}
