//! Pictures in memory, as rows of pixels.

use glam::Vec3;

/// Largest number of pixels of a picture: 2²⁸, such as 16384 × 16384.
///
/// The limit prevents huge allocations for wrong sizes in files and options.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Error: the size of a picture is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureSizeError {
    /// Width or height is zero.
    #[error("a picture of {width} × {height} pixels is empty: both sides must be at least 1")]
    Empty {
        /// Requested width \[pixels].
        width: u32,
        /// Requested height \[pixels].
        height: u32,
    },
    /// The picture has more than [`MAX_PIXELS`] pixels.
    #[error("a picture of {width} × {height} pixels is too large: at most {MAX_PIXELS} pixels are allowed")]
    TooLarge {
        /// Requested width \[pixels].
        width: u32,
        /// Requested height \[pixels].
        height: u32,
    },
    /// The number of given pixels is not width × height.
    #[error("a picture of {width} × {height} pixels cannot be made of {found} pixels")]
    PixelCountMismatch {
        /// Requested width \[pixels].
        width: u32,
        /// Requested height \[pixels].
        height: u32,
        /// Number of given pixels.
        found: usize,
    },
}

/// Returns the number of pixels of a picture of `width` × `height`; fails if the size is invalid.
pub(super) fn pixel_count(width: u32, height: u32) -> Result<usize, PictureSizeError> {
    if width == 0 || height == 0 {
        return Err(PictureSizeError::Empty { width, height });
    }
    let count = u64::from(width) * u64::from(height);
    if count > MAX_PIXELS {
        return Err(PictureSizeError::TooLarge { width, height });
    }
    Ok(count as usize)
}

/// A picture with one value of type `T` per pixel, in rows from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Raster<T> {
    width: u32,
    height: u32,
    pixels: Vec<T>,
}

/// A picture of linear radiance: RGB with Rec. 709 primaries \[W/(m² sr)].
pub type Image = Raster<Vec3>;

/// A picture of 8-bit RGB levels as stored in a PNG file, without conversion to linear values.
pub type Rgb8Image = Raster<[u8; 3]>;

impl Image {
    /// Makes a black picture.
    ///
    /// # Errors
    /// [`PictureSizeError`] if a side is zero or the picture exceeds [`MAX_PIXELS`].
    pub fn new(width: u32, height: u32) -> Result<Self, PictureSizeError> {
        let count = pixel_count(width, height)?;
        Ok(Self { width, height, pixels: vec![Vec3::ZERO; count] })
    }
}

impl<T: Copy> Raster<T> {
    /// Makes a picture from `width · height` pixels in rows from the top left.
    ///
    /// # Errors
    /// [`PictureSizeError`] if the sides are invalid or do not match the number of pixels.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<T>) -> Result<Self, PictureSizeError> {
        if pixels.len() != pixel_count(width, height)? {
            return Err(PictureSizeError::PixelCountMismatch { width, height, found: pixels.len() });
        }
        Ok(Self { width, height, pixels })
    }

    /// Width of the picture \[pixels].
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height of the picture \[pixels].
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels of the picture, in rows from the top left.
    #[must_use]
    pub fn pixels(&self) -> &[T] {
        &self.pixels
    }

    /// All pixels of the picture, mutable, in rows from the top left.
    #[must_use]
    pub fn pixels_mut(&mut self) -> &mut [T] {
        &mut self.pixels
    }

    /// Pixel in column `x` from the left and row `y` from the top; `None` outside the picture.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> Option<T> {
        if x < self.width && y < self.height {
            self.pixels.get(y as usize * self.width as usize + x as usize).copied()
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_sizes_are_refused() {
        assert_eq!(Image::new(0, 5).unwrap_err(), PictureSizeError::Empty { width: 0, height: 5 });
        assert_eq!(
            Image::new(u32::MAX, u32::MAX).unwrap_err(),
            PictureSizeError::TooLarge { width: u32::MAX, height: u32::MAX }
        );
        let short = Image::from_pixels(2, 2, vec![Vec3::ONE; 3]).unwrap_err();
        assert_eq!(short, PictureSizeError::PixelCountMismatch { width: 2, height: 2, found: 3 });
    }

    #[test]
    fn image_rows_count_from_the_top() {
        let mut image = Image::new(3, 2).unwrap();
        image.pixels_mut()[5] = Vec3::ONE;
        assert_eq!(image.get(2, 1), Some(Vec3::ONE));
        assert_eq!((image.get(3, 0), image.get(0, 2)), (None, None));
    }
}
