//! Equirectangular maps: pictures over all directions, with importance sampling.

use crate::color::{self, Rgb};
use crate::image::{Image, PictureSizeError};
use crate::sampling::PiecewiseConstant2d;
use glam::{DVec2, DVec3, UVec2, Vec2, Vec3};
use libm::{atan2, cos, hypot, sin};
use std::f64::consts::{PI, TAU};

/// Error: the picture cannot define the emission of a light.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EmissionPictureError {
    /// A pixel is negative or not finite after scaling.
    #[error("the value in column {x}, row {y} is {value}: repair the picture so that all are finite and none below 0")]
    InvalidPixel {
        /// Column of the invalid pixel, counted from 0 at the left.
        x: u32,
        /// Row of the invalid pixel, counted from 0 at the top.
        y: u32,
        /// Value of the invalid pixel after scaling.
        value: Rgb,
    },
    /// The picture has no pixels or too many pixels, or the number of its pixels is not width ×
    /// height.
    #[error(transparent)]
    InvalidSize(#[from] PictureSizeError),
}

/// Returns `picture` with all pixels multiplied by `scale`.
///
/// # Errors
/// [`EmissionPictureError::InvalidPixel`] if a scaled pixel is negative or not finite.
pub(super) fn scale_and_validate_picture(mut picture: Image, scale: Rgb) -> Result<Image, EmissionPictureError> {
    let width = picture.width();
    for (i, pixel) in picture.pixels_mut().iter_mut().enumerate() {
        let value = *pixel * scale;
        if !(value.is_finite() && value.cmpge(Rgb::ZERO).all()) {
            return Err(EmissionPictureError::InvalidPixel { x: i as u32 % width, y: i as u32 / width, value });
        }
        *pixel = value;
    }
    Ok(picture)
}

/// A function of direction, given by a picture in equirectangular projection.
///
/// The top edge of the picture is +y, its center is −z, and +x is to the right of the center.
/// Values are interpolated bilinearly, also across the left and right edge.
#[derive(Clone, Debug)]
pub struct EquirectangularMap {
    map: Image,
    /// Sampling distribution over the pixels; `None` if the map is black.
    ///
    /// The probability of a pixel is proportional to m·Ω. Here, m is the mean of the interpolated
    /// map over the area and the color channels of the pixel, and Ω is the pixel's solid angle.
    distribution: Option<PiecewiseConstant2d>,
    /// Cosine of the angle from +y to the upper edge of each row. The last element is for the lower
    /// edge of the last row.
    row_edge_cosines: Vec<f64>,
    /// Integral of the interpolated map over all directions \[pixel value · sr].
    integral: Rgb,
}

impl EquirectangularMap {
    /// Creates a map whose values are the pixels of `map` times `scale`.
    ///
    /// # Errors
    /// [`EmissionPictureError::InvalidPixel`] if a scaled pixel is negative or not finite.
    pub fn new(map: Image, scale: Rgb) -> Result<Self, EmissionPictureError> {
        let map = scale_and_validate_picture(map, scale)?;
        let (w, h) = (map.width() as usize, map.height() as usize);
        let row_edge_cosines: Vec<f64> = (0..=h).map(|row| cos(PI * row as f64 / h as f64)).collect();
        let brightness = |x: usize, y: usize| f64::from(color::channel_mean(map.pixels()[y * w + x]));
        // Mean of the interpolated value over a pixel, first horizontally, then vertically. It is
        // positive if the value is positive anywhere in the pixel, so no direction with light has
        // pdf 0.
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

    /// Integral of the interpolated map over all directions \[pixel value · sr].
    pub(super) fn integral(&self) -> Rgb {
        self.integral
    }

    /// Value of the map in unit `direction`, interpolated bilinearly between pixels.
    #[inline]
    pub(super) fn value_in_direction(&self, direction: Vec3) -> Rgb {
        let at = self.pixel_coordinates(direction) - 0.5;
        let (w, h) = (self.map.width() as i64, self.map.height() as i64);
        let (x, y) = (at.x.floor(), at.y.floor());
        let (fx, fy) = ((at.x - x) as f32, (at.y - y) as f32);
        let row = |y: i64| {
            let row = &self.map.pixels()[(y.clamp(0, h - 1) * w) as usize..][..w as usize];
            row[(x as i64).rem_euclid(w) as usize].lerp(row[(x as i64 + 1).rem_euclid(w) as usize], fx)
        };
        row(y as i64).lerp(row(y as i64 + 1), fy)
    }

    /// Continuous pixel coordinates of unit `direction` on the map, right and down from its top
    /// left corner.
    #[inline]
    fn pixel_coordinates(&self, direction: Vec3) -> DVec2 {
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
        let (pixel, _) = self.pixel_in_direction(direction);
        let height = self.row_edge_cosines[pixel.y as usize] - self.row_edge_cosines[pixel.y as usize + 1];
        distribution.pdf(pixel) / (TAU * f64::from(self.map.height()) * height) as f32
    }

    /// Returns the pixel (column, row) that contains unit `direction`, and the direction's
    /// horizontal position inside the pixel, in \[0, 1).
    #[inline]
    fn pixel_in_direction(&self, direction: Vec3) -> (UVec2, f32) {
        let at = self.pixel_coordinates(direction);
        // At the right edge and at −y, rounding may give a column or row beyond the last.
        let pixel = UVec2::new(at.x as u32 % self.map.width(), (at.y as u32).min(self.map.height() - 1));
        (pixel, at.x.fract() as f32)
    }

    /// Inverse of [`EquirectangularMap::sample`]: returns the point u in \[0, 1)² that `sample`
    /// maps to unit `direction`; `None` if the map is black.
    #[inline]
    pub(super) fn inverse_sample(&self, direction: Vec3) -> Option<Vec2> {
        let (pixel, x) = self.pixel_in_direction(direction);
        let (top, bottom) = (self.row_edge_cosines[pixel.y as usize], self.row_edge_cosines[pixel.y as usize + 1]);
        let y = (f64::from(direction.y) - top) / (bottom - top);
        let within = Vec2::new(x, y as f32).clamp(Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON / 2.0));
        Some(self.distribution.as_ref()?.inverse_sample(pixel, within))
    }

    /// Samples a unit direction by `u` in \[0, 1)², with a pdf that is constant in each pixel.
    ///
    /// Rounding may move the direction to a neighbouring pixel, so [`EquirectangularMap::pdf`] of
    /// the result may be zero. Returns `None` if the map is black.
    #[inline]
    pub(super) fn sample(&self, u: Vec2) -> Option<Vec3> {
        let (cell, within, _) = self.distribution.as_ref()?.sample(u);
        let row = cell.y as usize;
        let height = self.row_edge_cosines[row]
            + f64::from(within.y) * (self.row_edge_cosines[row + 1] - self.row_edge_cosines[row]);
        let radius = ((1.0 - height) * (1.0 + height)).max(0.0).sqrt();
        let angle = (f64::from(cell.x) + f64::from(within.x)) / f64::from(self.map.width()) - 0.5;
        let (s, c) = libm::sincos(angle * TAU);
        Some(Vec3::new((radius * s) as f32, height as f32, (-radius * c) as f32))
    }
}

/// Integral ∫ w d(cos θ) over the whole map, where θ is the angle to the upper pole of the map. The
/// function w(θ) is the weight of pixel row `row` in the vertical linear interpolation between
/// `rows` rows.
///
/// The weight w is 1 at the center of the row, and falls linearly to 0 at the centers of the
/// adjacent rows. The first row has w = 1 up to the upper pole, the last row down to the lower
/// pole.
fn row_interpolation_integral(row: usize, rows: usize) -> f64 {
    let step = PI / rows as f64;
    let center = (row as f64 + 0.5) * step;
    if rows == 1 {
        return 2.0;
    }
    if row == 0 || row == rows - 1 {
        // The weight is 1 up to the row's center at θ = step/2, which contributes 1 − cos(step/2).
        // Then it falls to 0 at θ = 1.5 step. The last row mirrors the first.
        return 1.0 - (sin(1.5 * step) - sin(0.5 * step)) / step;
    }
    sin(center) * 2.0 * (1.0 - cos(step)) / step
}
