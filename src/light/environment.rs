//! Light from all around.

use super::{DirectSample, ShadowTarget};
use crate::color::{self, Rgb};
use crate::image::{Image, SizeError};
use crate::math::Sphere;
use crate::sampling::Piecewise2d;
use glam::{DVec3, UVec2, Vec2, Vec3};
use libm::{atan2, cos, hypot, sin};
use std::f64::consts::{PI, TAU};

/// A picture that cannot light a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EnvironmentError {
    /// Radiance below zero or not finite, counted from the top left.
    #[error(
        "the radiance in column {x}, row {y} is {value}: repair the picture so that all are finite and none below 0"
    )]
    Radiance {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// What it is, scaled.
        value: Rgb,
    },
    /// No picture at all.
    #[error(transparent)]
    Size(#[from] SizeError),
}

/// Radiance from infinity by direction.
///
/// The map covers all directions by longitude and latitude, its top row straight up (+y). Unturned, its middle lies towards −z, and
/// right of that is +x. Radiance is interpolated between pixels, across the seam too.
#[derive(Clone, Debug)]
pub struct Environment {
    map: Image,
    /// Sine and cosine of the turn about +y.
    turn: [f32; 2],
    /// The choice of cells, which are the map's pixels; none where all is black.
    grid: Option<Piecewise2d>,
    /// Cosine with +y of the upper edge of each row, and of the lower edge of the last.
    edges: Vec<f64>,
    /// Radiance over all directions \[W/m²].
    integral: Rgb,
}

impl Environment {
    /// The environment of a map times `scale` \[W/(m² sr)], turned by `angle` \[radians] about +y, anticlockwise seen from above.
    ///
    /// # Errors
    /// [`EnvironmentError::Radiance`] where a scaled pixel is below zero or not finite.
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
        // The mean over a pixel of what is interpolated there, so above zero wherever that is anywhere.
        let across = |x: usize, y: usize| {
            0.125 * (brightness((x + w - 1) % w, y) + brightness((x + 1) % w, y)) + 0.75 * brightness(x, y)
        };
        let weight = |x: usize, y: usize| {
            let mean = 0.125 * (across(x, y.saturating_sub(1)) + across(x, (y + 1).min(h - 1))) + 0.75 * across(x, y);
            mean * (edges[y] - edges[y + 1])
        };
        let grid = Piecewise2d::new(w, h, weight);
        let rows = map
            .pixels()
            .chunks(w)
            .enumerate()
            .map(|(y, row)| row.iter().map(|p| p.as_dvec3()).sum::<DVec3>() * (row_measure(y, h) * TAU / w as f64));
        let integral = rows.sum::<DVec3>().as_vec3();
        Ok(Self { turn: [sin(angle) as f32, cos(angle) as f32], grid, edges, integral, map })
    }

    /// The same radiance from everywhere.
    ///
    /// # Errors
    /// [`EnvironmentError::Radiance`] where it is below zero or not finite.
    pub fn constant(radiance: Rgb) -> Result<Self, EnvironmentError> {
        Self::new(Image::from_pixels(1, 1, vec![radiance])?, 0.0, Rgb::ONE)
    }

    /// Radiance that arrives from unit `direction` \[W/(m² sr)].
    #[inline]
    #[must_use]
    pub fn radiance(&self, direction: Vec3) -> Rgb {
        let at = self.place(direction) - DVec3::new(0.5, 0.5, 0.0);
        let (w, h) = (self.map.width() as i64, self.map.height() as i64);
        let (x, y) = (at.x.floor(), at.y.floor());
        let (fx, fy) = ((at.x - x) as f32, (at.y - y) as f32);
        let row = |y: i64| {
            let row = &self.map.pixels()[(y.clamp(0, h - 1) * w) as usize..][..w as usize];
            row[(x as i64).rem_euclid(w) as usize].lerp(row[(x as i64 + 1).rem_euclid(w) as usize], fx)
        };
        row(y as i64).lerp(row(y as i64 + 1), fy)
    }

    /// Column and row of a direction, in pixels from the top left corner of the map.
    #[inline]
    fn place(&self, direction: Vec3) -> DVec3 {
        let [sin, cos] = self.turn;
        let x = f64::from(cos * direction.x - sin * direction.z);
        let z = f64::from(sin * direction.x + cos * direction.z);
        let (u, v) = (0.5 + atan2(x, -z) / TAU, atan2(hypot(x, z), f64::from(direction.y)) / PI);
        DVec3::new(u * f64::from(self.map.width()), v * f64::from(self.map.height()), 0.0)
    }

    /// Density per steradian with which [`Environment::sample`] draws unit `direction`.
    #[inline]
    #[must_use]
    pub fn density(&self, direction: Vec3) -> f32 {
        let Some(grid) = &self.grid else {
            return 0.0;
        };
        let at = self.place(direction);
        // What lies on the seam is in the first column, what points straight down in the last row.
        let column = at.x as u32 % self.map.width();
        let row = (at.y as u32).min(self.map.height() - 1);
        let height = self.edges[row as usize] - self.edges[row as usize + 1];
        grid.pdf(UVec2::new(column, row)) / (TAU * f64::from(self.map.height()) * height) as f32
    }

    /// A unit direction drawn about by radiance, uniformly in each pixel, with its density per steradian.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (cell, within, _) = self.grid.as_ref()?.sample(u);
        let row = cell.y as usize;
        let y = self.edges[row] + f64::from(within.y) * (self.edges[row + 1] - self.edges[row]);
        let radius = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
        let angle = (f64::from(cell.x) + f64::from(within.x)) / f64::from(self.map.width()) - 0.5;
        let (s, c) = libm::sincos(angle * TAU);
        let (x, z) = ((radius * s) as f32, (-radius * c) as f32);
        let [sin, cos] = self.turn;
        let direction = Vec3::new(cos * x + sin * z, y as f32, cos * z - sin * x);
        // Rounding may carry it across the edge of a pixel: its density is the one that is found there.
        let pdf = self.density(direction);
        (pdf > 0.0).then_some((direction, pdf))
    }

    #[inline]
    pub(super) fn sample_direct(&self, u: Vec2) -> Option<DirectSample> {
        let (wi, pdf) = self.sample(u)?;
        Some(DirectSample { wi, reach: ShadowTarget::Infinity, irradiance: self.radiance(wi) / pdf, pdf: Some(pdf) })
    }

    /// Flux \[W] through the disc that `domain` shows to each direction: π r² ∫ L dω.
    #[must_use]
    pub fn power(&self, domain: Sphere) -> Rgb {
        self.integral * (std::f32::consts::PI * domain.radius * domain.radius)
    }
}

/// The integral over the cosine with +y of the weight with which row `y` of `h` is interpolated: a hat over the angle θ from +y
/// that is level beyond the first and the last middle of a row.
fn row_measure(y: usize, h: usize) -> f64 {
    let step = PI / h as f64;
    let middle = (y as f64 + 0.5) * step;
    if h == 1 {
        return 2.0;
    }
    if y == 0 || y == h - 1 {
        // Half of the map mirrors the other: 1 − cos of the level part, and the falling flank.
        return 1.0 - (sin(1.5 * step) - sin(0.5 * step)) / step;
    }
    sin(middle) * 2.0 * (1.0 - cos(step)) / step
}
