//! Error maps: colour ramps, their scales, and the picture windows with the largest errors.

use crate::image::{Image, PictureSizeError, RelativeErrorWeights};
use crate::study::methods::MethodResult;
use glam::{DVec3, Vec3};

/// Error at the dark end of a logarithmic colour ramp, divided by the error at the bright end.
pub(super) const RAMP_END_ERROR_RATIO: f64 = 0.01;

/// Quantile of the pixel errors at which a colour scale ends. Larger errors get the colour of the
/// end, so that fireflies do not stretch the scale.
const SCALE_QUANTILE: f64 = 0.99;

/// Side length of a crop \[pixels]. A crop is a square window of a picture that a report enlarges.
pub(super) const CROP_SIZE: u32 = 64;

/// Converts a colour in polar OKLab coordinates (Ottosson 2020) to linear RGB, clamped to \[0, 1].
///
/// `hue` is in degrees.
fn oklch_to_linear_rgb(lightness: f64, chroma: f64, hue: f64) -> Vec3 {
    let (b, a) = libm::sincos(hue.to_radians());
    let (a, b) = (chroma * a, chroma * b);
    let cube = |x: f64| x * x * x;
    let l = cube(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cube(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cube(lightness - 0.089_484_177_5 * a - 1.291_485_548 * b);
    DVec3::new(
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    )
    .clamp(DVec3::ZERO, DVec3::ONE)
    .as_vec3()
}

/// Returns the colour at `t` of a ramp from black (0) over violet, red and orange to light yellow
/// (1).
///
/// `t` is clamped to \[0, 1]. Lightness is linear in `t`. The result is linear RGB.
pub(super) fn error_color_ramp(t: f64) -> Vec3 {
    let t = t.clamp(0.0, 1.0);
    // Near black and white, only small chromas lie inside the sRGB gamut.
    let chroma = 0.2 * (1.0 - (2.0 * t - 1.0) * (2.0 * t - 1.0) * (2.0 * t - 1.0) * (2.0 * t - 1.0));
    oklch_to_linear_rgb(0.06 + 0.9 * t, chroma.max(0.0), 300.0 + 160.0 * t)
}

/// Returns the colour at `t` of a ramp, as linear RGB: blue at −1, black at 0, orange at 1.
///
/// `t` is clamped to \[−1, 1].
pub(super) fn signed_color_ramp(t: f64) -> Vec3 {
    let t = t.clamp(-1.0, 1.0);
    let hue = if t < 0.0 { 250.0 } else { 65.0 };
    // Both signs have equal lightness.
    oklch_to_linear_rgb(0.9 * t.abs(), 0.13 * t.abs().sqrt(), hue)
}

/// Returns the upper end of a colour scale: the 99 % quantile of the positive finite `values`,
/// rounded up to 1, 2 or 5 times a power of ten. `None` if no value is positive and finite.
pub(super) fn color_scale_maximum(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|v| *v > 0.0 && v.is_finite()).collect();
    if values.is_empty() {
        return None;
    }
    let index = ((values.len() - 1) as f64 * SCALE_QUANTILE) as usize;
    let value = *values.select_nth_unstable_by(index, f64::total_cmp).1;
    let decade = libm::pow(10.0, libm::floor(libm::log10(value)));
    let rounded_digit =
        [1.0, 2.0, 5.0, 10.0].into_iter().find(|digit| digit * decade >= value * (1.0 - 1e-9)).unwrap_or(10.0);
    Some(rounded_digit * decade)
}

/// Draws the relative error of each pixel with a logarithmic colour ramp, which is brightest at the
/// error `most`.
pub(super) fn error_map(method: &MethodResult, most: f64) -> Result<Image, PictureSizeError> {
    let colour = |e: &f32| {
        let e = f64::from(*e);
        if e > 0.0 {
            error_color_ramp(1.0 - libm::log(e / most) / libm::log(RAMP_END_ERROR_RATIO))
        } else {
            error_color_ramp(0.0)
        }
    };
    let picture = &method.first_seed_picture;
    Image::from_pixels(picture.width(), picture.height(), method.relative_pixel_errors.iter().map(colour).collect())
}

/// Returns the relative difference of each pixel from the reference: the mean of `difference` over
/// channels, divided by √(L² + m²).
///
/// L is the mean radiance of the reference near the pixel. m is the median of L over the reference,
/// see [`RelativeErrorWeights`].
pub(super) fn relative_differences(difference: &Image, scale: &RelativeErrorWeights) -> Vec<f64> {
    // Each weight contains a factor of 1/3 for the mean over channels.
    let pairs = difference.pixels().iter().zip(scale.pixel_weights());
    pairs.map(|(d, w)| d.as_dvec3().element_sum() / 3.0 * (3.0 * w).sqrt()).collect()
}

/// Draws signed relative differences from the reference with a colour ramp: blue at −`most`, black
/// at 0, orange at `most`.
///
/// `relative` holds the relative difference of each pixel; `method` gives the size of the picture.
pub(super) fn difference_map(method: &MethodResult, relative: &[f64], most: f64) -> Result<Image, PictureSizeError> {
    let picture = &method.first_seed_picture;
    Image::from_pixels(
        picture.width(),
        picture.height(),
        relative.iter().map(|d| signed_color_ramp(d / most)).collect(),
    )
}

/// Rectangle of pixels of a picture; `x` counts from the left, `y` from the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PixelWindow {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl PixelWindow {
    /// Copies the pixels of `image` inside the window.
    pub(super) fn crop_image(self, image: &Image) -> Result<Image, PictureSizeError> {
        let pixels = (self.y..self.y + self.height)
            .flat_map(|y| (self.x..self.x + self.width).map(move |x| image.get(x, y).unwrap_or(Vec3::ZERO)));
        Image::from_pixels(self.width, self.height, pixels.collect())
    }

    fn overlaps(self, o: Self) -> bool {
        self.x < o.x + o.width && o.x < self.x + self.width && self.y < o.y + o.height && o.y < self.y + self.height
    }
}

/// Finds up to `count` windows with the largest errors. The windows do not overlap.
///
/// The error of a window is the sum of squared errors over its pixels and over all methods. The
/// squared errors of each method are first divided by their mean over the picture, so that all
/// methods count equally. A window has [`CROP_SIZE`] × [`CROP_SIZE`] pixels, or fewer in a smaller
/// picture.
pub(super) fn largest_error_windows(methods: &[MethodResult], count: usize) -> Vec<PixelWindow> {
    let Some(first) = methods.first() else { return Vec::new() };
    let (width, height) = (first.first_seed_picture.width(), first.first_seed_picture.height());
    let (w, h) = (width as usize, height as usize);
    let mut sum = vec![0.0; w * h];
    for method in methods {
        let square = |e: &f32| Some(f64::from(*e)).filter(|e| e.is_finite()).map_or(0.0, |e| e * e);
        let mean = method.relative_pixel_errors.iter().map(square).sum::<f64>() / (w * h) as f64;
        if mean > 0.0 {
            sum.iter_mut().zip(&method.relative_pixel_errors).for_each(|(sum, e)| *sum += square(e) / mean);
        }
    }
    // Summed-area table (Crow 1984): each entry is the sum of the squared errors of all pixels to
    // the left of it and above it.
    let mut table = vec![0.0; (w + 1) * (h + 1)];
    for y in 0..h {
        let mut row = 0.0;
        for x in 0..w {
            row += sum[y * w + x];
            table[(y + 1) * (w + 1) + x + 1] = table[y * (w + 1) + x + 1] + row;
        }
    }
    let (cw, ch) = (CROP_SIZE.min(width), CROP_SIZE.min(height));
    let error_sum_in = |at: &PixelWindow| {
        let corner = |x: u32, y: u32| table[y as usize * (w + 1) + x as usize];
        let (right, below) = (at.x + at.width, at.y + at.height);
        corner(right, below) - corner(at.x, below) - corner(right, at.y) + corner(at.x, at.y)
    };
    let mut chosen: Vec<PixelWindow> = Vec::new();
    while chosen.len() < count {
        let places =
            (0..=height - ch).flat_map(|y| (0..=width - cw).map(move |x| PixelWindow { x, y, width: cw, height: ch }));
        let free = places.filter(|place| chosen.iter().all(|c| !c.overlaps(*place)));
        let mut best: Option<(f64, PixelWindow)> = None;
        for place in free {
            let value = error_sum_in(&place);
            if value > 0.0 && best.is_none_or(|(most, _)| value > most) {
                best = Some((value, place));
            }
        }
        let Some((_, window)) = best else { break };
        chosen.push(window);
    }
    chosen
}

#[cfg(test)]
mod tests;
