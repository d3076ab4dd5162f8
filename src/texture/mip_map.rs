//! Image textures, filtered by MIP maps.

use crate::color::Rgb;
use crate::image::Image;
use glam::{DVec2, DVec3, Vec3};

/// Continuation of a picture outside the unit square of texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WrapMode {
    /// The picture repeats in both directions.
    #[default]
    Repeat,
    /// The colors of the edge pixels extend outward.
    Clamp,
    /// The picture repeats, and every other copy is mirrored.
    Mirror,
}

/// The reason why a picture cannot be a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MipMapError {
    /// A pixel has a channel below zero.
    #[error("pixel {x}, {y} (from the top left) is negative")]
    Negative {
        /// Column of the pixel, from the left.
        x: u32,
        /// Row of the pixel, from the top.
        y: u32,
    },
    /// A pixel has a channel that is infinite or NaN.
    #[error("pixel {x}, {y} (from the top left) is not finite")]
    NotFinite {
        /// Column of the pixel, from the left.
        x: u32,
        /// Row of the pixel, from the top.
        y: u32,
    },
}

/// A picture with a MIP map: each level has about half as many columns and rows as the level
/// before.
///
/// The picture covers the unit square of texture coordinates, with (0, 0) at its lower left corner.
/// Source: Williams 1983, "Pyramidal parametrics".
#[derive(Clone, Debug)]
pub struct MipMap {
    levels: Vec<MipLevel>,
    wrap: WrapMode,
    mean: Rgb,
    value_range: (f32, f32),
}

/// One level of a MIP map, with linear colors.
#[derive(Clone, Debug)]
struct MipLevel {
    width: usize,
    height: usize,
    /// Pixels in rows, from the top.
    pixels: Vec<Vec3>,
}

impl MipMap {
    /// Builds the MIP map of `image`, whose pixels are linear colors.
    ///
    /// # Errors
    /// [`MipMapError`] if a value is negative or not finite.
    pub fn new(image: &Image, wrap: WrapMode) -> Result<Self, MipMapError> {
        let (width, pixels) = (image.width(), image.pixels());
        if let Some(i) = pixels.iter().position(|p| !(p.is_finite() && p.min_element() >= 0.0)) {
            let (x, y) = ((i % width as usize) as u32, (i / width as usize) as u32);
            let finite = pixels[i].is_finite();
            return Err(if finite { MipMapError::Negative { x, y } } else { MipMapError::NotFinite { x, y } });
        }
        let least = pixels.iter().fold(Vec3::INFINITY, |a, b| a.min(*b)).min_element();
        let greatest = pixels.iter().fold(Vec3::ZERO, |a, b| a.max(*b)).max_element();
        let sum: DVec3 = pixels.iter().map(|p| p.as_dvec3()).sum();
        let mean = (sum / pixels.len() as f64).as_vec3();
        let first = MipLevel { width: width as usize, height: image.height() as usize, pixels: pixels.to_vec() };
        let mut levels = vec![first];
        while let Some(last) = levels.last().filter(|l| l.width > 1 || l.height > 1) {
            levels.push(last.next_coarser_level());
        }
        Ok(Self { levels, wrap, mean, value_range: (least, greatest) })
    }

    /// Mean color over a box with center `uv` and sides `size`, by trilinear interpolation.
    ///
    /// The two MIP levels are those with pixel sizes just below and just above the longer side of
    /// the box. `uv` and `size` are in texture coordinates.
    #[must_use]
    pub fn box_mean(&self, uv: DVec2, size: DVec2) -> Rgb {
        let uv = uv.map(|x| self.wrap.wrap_coordinate_near_zero(x));
        let pixels = (size.x * self.levels[0].width as f64).max(size.y * self.levels[0].height as f64);
        let last = self.levels.len() - 1;
        let level = if pixels > 1.0 { libm::log2(pixels).min(last as f64) } else { 0.0 };
        let (first, between) = (level as usize, (level - level.floor()) as f32);
        let fine = self.levels[first].interpolate_bilinearly(uv, self.wrap);
        if between == 0.0 {
            fine
        } else {
            fine.lerp(self.levels[(first + 1).min(last)].interpolate_bilinearly(uv, self.wrap), between)
        }
    }

    /// Mean color of all pixels.
    pub(super) fn mean(&self) -> Rgb {
        self.mean
    }

    /// Least and greatest value of any channel of any pixel.
    pub(super) fn value_range(&self) -> (f32, f32) {
        self.value_range
    }

    /// Side of a pixel of the finest level in texture coordinates, along the axis that has more
    /// pixels.
    pub(super) fn texel_size(&self) -> f64 {
        1.0 / self.levels[0].width.max(self.levels[0].height) as f64
    }
}

impl WrapMode {
    /// Maps coordinate `x` to an equivalent coordinate in \[0, 2], where the wrapped picture has
    /// the same value.
    ///
    /// Near zero, f64 has enough digits to tell pixels apart. The result is 0 if `x` is not finite.
    fn wrap_coordinate_near_zero(self, x: f64) -> f64 {
        let folded = match self {
            Self::Repeat => x - x.floor(),
            Self::Clamp => x.clamp(0.0, 1.0),
            Self::Mirror => x - 2.0 * (0.5 * x).floor(),
        };
        if folded.is_finite() { folded } else { 0.0 }
    }

    /// Maps the pixel index `i`, which may lie outside a row of `n` pixels, to the index in the row
    /// that the wrap mode shows there.
    fn wrap_pixel_index(self, i: i64, n: usize) -> usize {
        let n = n as i64;
        (match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let i = i.rem_euclid(2 * n);
                i.min(2 * n - 1 - i)
            }
        }) as usize
    }
}

impl MipLevel {
    /// Color at `uv`, interpolated bilinearly between the centers of the four nearest pixels.
    fn interpolate_bilinearly(&self, uv: DVec2, wrap: WrapMode) -> Rgb {
        let x = uv.x * self.width as f64 - 0.5;
        let y = (1.0 - uv.y) * self.height as f64 - 0.5;
        let (column, row) = (x.floor() as i64, y.floor() as i64);
        let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
        let columns = [column, column + 1].map(|i| wrap.wrap_pixel_index(i, self.width));
        let [upper, lower] = [row, row + 1].map(|i| {
            let row = wrap.wrap_pixel_index(i, self.height) * self.width;
            self.pixels[row + columns[0]].lerp(self.pixels[row + columns[1]], fx)
        });
        upper.lerp(lower, fy)
    }

    /// The next coarser MIP level, with half as many columns and rows, rounded down.
    ///
    /// Each pixel is the mean over its area.
    fn next_coarser_level(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let columns: Vec<Vec<(usize, f32)>> = (0..width).map(|j| covered_pixels(j, self.width, width)).collect();
        let mut pixels = Vec::with_capacity(width * height);
        for i in 0..height {
            let rows = covered_pixels(i, self.height, height);
            for columns in &columns {
                let across =
                    |row: usize| columns.iter().map(|(x, w)| self.pixels[row * self.width + x] * *w).sum::<Vec3>();
                pixels.push(rows.iter().map(|(y, w)| across(*y) * *w).sum());
            }
        }
        Self { width, height, pixels }
    }
}

/// Returns the pixels of a fine row that pixel `j` of a coarser row covers, as pairs (index,
/// weight). The weights sum to 1.
///
/// The fine row has `n` pixels, and the coarser row has `m` pixels over the same length.
fn covered_pixels(j: usize, n: usize, m: usize) -> Vec<(usize, f32)> {
    // The unit is 1/m of a fine pixel. Coarse pixel j covers the interval [j n, (j + 1) n], and
    // fine pixel i covers [i m, (i + 1) m].
    let (start, end) = (j * n, (j + 1) * n);
    (start / m..end.div_ceil(m)).map(|i| (i, (end.min((i + 1) * m) - start.max(i * m)) as f32 / n as f32)).collect()
}

#[cfg(test)]
mod tests;
