//! Crop windows: the part of a picture that is rendered.

use std::str::FromStr;

/// Rectangle of pixels of a picture that is rendered: columns `left` to `right` and rows `top` to
/// `bottom`.
///
/// Columns and rows count from 0 at the upper left corner of the picture. `right` and `bottom` are
/// not included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CropWindow {
    /// First column of pixels inside the window.
    pub left: u32,
    /// First row of pixels inside the window.
    pub top: u32,
    /// First column of pixels to the right of the window.
    pub right: u32,
    /// First row of pixels below the window.
    pub bottom: u32,
}

/// Error: a text does not describe a crop window. The field is the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no window: write X0,Y0,X1,Y1 in pixels, with X0 < X1 and Y0 < Y1")]
pub struct CropWindowError(String);

impl CropWindow {
    /// Returns the window that holds all pixels of a picture.
    #[must_use]
    pub fn of_whole_picture((width, height): (u32, u32)) -> Self {
        Self { left: 0, top: 0, right: width, bottom: height }
    }

    /// Returns the width and height of the window \[pixels].
    #[must_use]
    pub fn size(self) -> (u32, u32) {
        (self.right - self.left, self.bottom - self.top)
    }

    /// Returns the smallest window that contains this one and is a union of tiles of a picture of
    /// `width` × `height` pixels.
    ///
    /// Tiles have `edge` × `edge` pixels, except at the right and the lower border.
    #[must_use]
    pub fn grown_to_tiles(self, edge: u32, (width, height): (u32, u32)) -> Self {
        Self {
            left: self.left / edge * edge,
            top: self.top / edge * edge,
            right: self.right.next_multiple_of(edge).min(width),
            bottom: self.bottom.next_multiple_of(edge).min(height),
        }
    }

    /// True if the window has pixels and lies in a picture of `width` × `height` pixels.
    #[must_use]
    pub fn fits_into(self, (width, height): (u32, u32)) -> bool {
        self.left < self.right && self.right <= width && self.top < self.bottom && self.bottom <= height
    }
}

impl FromStr for CropWindow {
    type Err = CropWindowError;

    fn from_str(text: &str) -> Result<Self, CropWindowError> {
        let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[left, top, right, bottom]) if left < right && top < bottom => Ok(Self { left, top, right, bottom }),
            _ => Err(CropWindowError(text.to_owned())),
        }
    }
}

/// Writes the window as `left,top,right,bottom`, the form that [`FromStr`] reads.
impl std::fmt::Display for CropWindow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{},{},{}", self.left, self.top, self.right, self.bottom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crop_windows_are_read_from_text() {
        let window: CropWindow = "3,4,10,20".parse().unwrap();
        assert_eq!((window, window.size()), (CropWindow { left: 3, top: 4, right: 10, bottom: 20 }, (7, 16)));
        assert_eq!(window.to_string().parse(), Ok(window));
        assert!(window.fits_into((10, 20)) && !window.fits_into((9, 20)) && !window.fits_into((10, 19)));
        let grown = CropWindow { left: 0, top: 0, right: 16, bottom: 30 };
        assert_eq!(window.grown_to_tiles(16, (40, 30)), grown);
        assert_eq!(grown.grown_to_tiles(16, (40, 30)), grown);
        for wrong in ["", "1,2,3", "1,2,3,4,5", "3,0,3,4", "0,4,3,3", "-1,0,3,4", "a,b,c,d"] {
            assert!(wrong.parse::<CropWindow>().is_err(), "{wrong}");
        }
    }
}
