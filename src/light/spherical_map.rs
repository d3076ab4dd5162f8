//! Equirectangular maps over all directions, with importance sampling.

use crate::color::{self, Rgb};
use crate::image::{Image, SizeError};
use crate::sampling::PiecewiseConstant2d;
use glam::{DVec2, DVec3, UVec2, Vec2, Vec3};
use libm::{atan2, cos, hypot, sin};
use std::f64::consts::{PI, TAU};

/// Reason why a picture cannot be the emission of a light.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EmissionPictureError {
    /// A pixel is negative or not finite after scaling. Pixels count from the top left.
    #[error("the value in column {x}, row {y} is {value}: repair the picture so that all are finite and none below 0")]
    Value {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// The scaled value.
        value: Rgb,
    },
    /// The picture has no pixels.
    #[error(transparent)]
    Size(#[from] SizeError),
}

/// Multiplies a picture by `scale`.
///
/// # Errors
/// [`EmissionPictureError::Value`] if a scaled pixel is negative or not finite.
pub(super) fn scale_emission_picture(mut picture: Image, scale: Rgb) -> Result<Image, EmissionPictureError> {
    let width = picture.width();
    for (i, pixel) in picture.pixels_mut().iter_mut().enumerate() {
        let value = *pixel * scale;
        if !(value.is_finite() && value.cmpge(Rgb::ZERO).all()) {
            return Err(EmissionPictureError::Value { x: i as u32 % width, y: i as u32 / width, value });
        }
        *pixel = value;
    }
    Ok(picture)
}

/// A function of direction, given by an equirectangular map.
///
/// The top row of the map is +y, its center is −z, and the direction to the right of the center is
/// +x. Values are interpolated bilinearly between pixels, also across the seam.
#[derive(Clone, Debug)]
pub struct EquirectangularMap {
    map: Image,
    /// Distribution over the pixels; `None` if the map is black.
    distribution: Option<PiecewiseConstant2d>,
    /// Cosine with +y of the upper edge of each row, and of the lower edge of the last row.
    row_edge_cosines: Vec<f64>,
    /// Integral of the map over all directions \[value · sr].
    integral: Rgb,
}

impl EquirectangularMap {
    /// The map times `scale`.
    ///
    /// # Errors
    /// [`EmissionPictureError::Value`] if a scaled pixel is negative or not finite.
    pub fn new(map: Image, scale: Rgb) -> Result<Self, EmissionPictureError> {
        let map = scale_emission_picture(map, scale)?;
        let (w, h) = (map.width() as usize, map.height() as usize);
        let row_edge_cosines: Vec<f64> = (0..=h).map(|row| cos(PI * row as f64 / h as f64)).collect();
        let brightness = |x: usize, y: usize| f64::from(color::channel_mean(map.pixels()[y * w + x]));
        // The mean of the interpolated radiance over a pixel is positive wherever the radiance is.
        let across = |x: usize, y: usize| {
            0.125 * (brightness((x + w - 1) % w, y) + brightness((x + 1) % w, y)) + 0.75 * brightness(x, y)
        };
        let weight = |x: usize, y: usize| {
            let mean = 0.125 * (across(x, y.saturating_sub(1)) + across(x, (y + 1).min(h - 1))) + 0.75 * across(x, y);
            mean * (row_edge_cosines[y] - row_edge_cosines[y + 1])
        };
        let distribution = PiecewiseConstant2d::new(w, h, weight);
        let rows = map.pixels().chunks(w).enumerate().map(|(y, row)| {
            row.iter().map(|p| p.as_dvec3()).sum::<DVec3>() * (row_interpolation_integral(y, h) * TAU / w as f64)
        });
        let integral = rows.sum::<DVec3>().as_vec3();
        Ok(Self { distribution, row_edge_cosines, integral, map })
    }

    /// Integral of the map over all directions \[value · sr].
    pub(super) fn integral(&self) -> Rgb {
        self.integral
    }

    /// Value of the map in unit `direction`.
    #[inline]
    pub(super) fn value_in_direction(&self, direction: Vec3) -> Rgb {
        let at = self.pixel(direction) - 0.5;
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
    fn pixel(&self, direction: Vec3) -> DVec2 {
        let [x, y, z] = direction.to_array().map(f64::from);
        let (u, v) = (0.5 + atan2(x, -z) / TAU, atan2(hypot(x, z), y) / PI);
        DVec2::new(u * f64::from(self.map.width()), v * f64::from(self.map.height()))
    }

    /// Pdf \[1/sr] with which [`EquirectangularMap::sample`] samples unit `direction`.
    #[inline]
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let Some(distribution) = &self.distribution else {
            return 0.0;
        };
        let at = self.pixel(direction);
        // Rounding may give a column or row beyond the last: the seam and −y.
        let column = at.x as u32 % self.map.width();
        let row = (at.y as u32).min(self.map.height() - 1);
        let height = self.row_edge_cosines[row as usize] - self.row_edge_cosines[row as usize + 1];
        distribution.pdf(UVec2::new(column, row)) / (TAU * f64::from(self.map.height()) * height) as f32
    }

    /// Samples a unit direction by the values of the pixels, uniformly within each pixel; `None` if
    /// the map is black.
    ///
    /// Rounding may move the direction to the next pixel: its pdf is [`EquirectangularMap::pdf`], which
    /// may be zero.
    #[inline]
    pub(super) fn sample(&self, u: Vec2) -> Option<Vec3> {
        let (cell, within, _) = self.distribution.as_ref()?.sample(u);
        let row = cell.y as usize;
        let y = self.row_edge_cosines[row]
            + f64::from(within.y) * (self.row_edge_cosines[row + 1] - self.row_edge_cosines[row]);
        let radius = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
        let angle = (f64::from(cell.x) + f64::from(within.x)) / f64::from(self.map.width()) - 0.5;
        let (s, c) = libm::sincos(angle * TAU);
        Some(Vec3::new((radius * s) as f32, y as f32, (-radius * c) as f32))
    }
}

/// Integral over the cosine with +y of the interpolation weight of row `y` of `h`.
///
/// The weight is a hat function of the angle from +y. Beyond the centers of the first and the last
/// row it is constant.
fn row_interpolation_integral(y: usize, h: usize) -> f64 {
    let step = PI / h as f64;
    let center = (y as f64 + 0.5) * step;
    if h == 1 {
        return 2.0;
    }
    if y == 0 || y == h - 1 {
        // The constant part contributes 1 − cos, then the falling flank. The last row mirrors the
        // first.
        return 1.0 - (sin(1.5 * step) - sin(0.5 * step)) / step;
    }
    sin(center) * 2.0 * (1.0 - cos(step)) / step
}
