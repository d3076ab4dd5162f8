//! Error maps: colour ramps, shared scales, and windows with the largest errors.

use crate::image::{Image, RelativeScale, SizeError};
use crate::study::methods::MethodResult;
use glam::{DVec3, Vec3};

/// Lowest error of a ramp over the highest: two decades.
pub(super) const LEAST: f64 = 0.01;

/// Fraction of pixels within a scale; fireflies beyond it are clamped.
const HELD: f64 = 0.99;

/// Edge of a crop \[pixels].
pub(super) const CROP: u32 = 64;

/// Linear RGB of an OKLab colour (Ottosson 2020), clipped to the gamut of a display.
fn oklch(lightness: f64, chroma: f64, hue: f64) -> Vec3 {
    let (b, a) = libm::sincos(hue.to_radians());
    let (a, b) = (chroma * a, chroma * b);
    let cone = |x: f64| x * x * x;
    let l = cone(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cone(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cone(lightness - 0.089_484_177_5 * a - 1.291_485_548 * b);
    DVec3::new(
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    )
    .clamp(DVec3::ZERO, DVec3::ONE)
    .as_vec3()
}

/// Ramp from black over violet, red and orange to light yellow, even in lightness, for `t` in \[0,
/// 1].
pub(super) fn ramp(t: f64) -> Vec3 {
    let t = t.clamp(0.0, 1.0);
    // Chroma is limited near black and white.
    let chroma = 0.2 * (1.0 - (2.0 * t - 1.0) * (2.0 * t - 1.0) * (2.0 * t - 1.0) * (2.0 * t - 1.0));
    oklch(0.06 + 0.9 * t, chroma.max(0.0), 300.0 + 160.0 * t)
}

/// Ramp with blue below zero, black at zero, orange above, for `t` in \[−1, 1].
pub(super) fn signed_ramp(t: f64) -> Vec3 {
    let t = t.clamp(-1.0, 1.0);
    let hue = if t < 0.0 { 250.0 } else { 65.0 };
    // Both sides have equal lightness.
    oklch(0.9 * t.abs(), 0.13 * t.abs().sqrt(), hue)
}

/// Upper end of a scale: the 99 % quantile, rounded up to 1, 2 or 5 of a decade; `None` if no value
/// is positive.
pub(super) fn scale(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|v| *v > 0.0 && v.is_finite()).collect();
    if values.is_empty() {
        return None;
    }
    let at = ((values.len() - 1) as f64 * HELD) as usize;
    let value = *values.select_nth_unstable_by(at, f64::total_cmp).1;
    let decade = libm::pow(10.0, libm::floor(libm::log10(value)));
    let up = [1.0, 2.0, 5.0, 10.0].into_iter().find(|digit| digit * decade >= value * (1.0 - 1e-9)).unwrap_or(10.0);
    Some(up * decade)
}

/// Map of the relative error of each pixel, in decades below `most`.
pub(super) fn error_map(method: &MethodResult, most: f64) -> Result<Image, SizeError> {
    let colour = |e: &f32| {
        let e = f64::from(*e);
        if e > 0.0 { ramp(1.0 - libm::log(e / most) / libm::log(LEAST)) } else { ramp(0.0) }
    };
    let picture = &method.picture;
    Image::from_pixels(picture.width(), picture.height(), method.error.iter().map(colour).collect())
}

/// Mean difference over channels, relative to local radiance.
pub(super) fn relative(difference: &Image, scale: &RelativeScale) -> Vec<f64> {
    // Weights include the mean over three channels.
    let pairs = difference.pixels().iter().zip(scale.weights());
    pairs.map(|(d, w)| d.as_dvec3().element_sum() / 3.0 * (3.0 * w).sqrt()).collect()
}

/// Map of relative differences, up to ±`most`.
pub(super) fn difference_map(method: &MethodResult, relative: &[f64], most: f64) -> Result<Image, SizeError> {
    let picture = &method.picture;
    Image::from_pixels(picture.width(), picture.height(), relative.iter().map(|d| signed_ramp(d / most)).collect())
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Window {
    /// The pixels inside the window.
    pub(super) fn of(self, image: &Image) -> Result<Image, SizeError> {
        let pixels = (self.y..self.y + self.height)
            .flat_map(|y| (self.x..self.x + self.width).map(move |x| image.get(x, y).unwrap_or(Vec3::ZERO)));
        Image::from_pixels(self.width, self.height, pixels.collect())
    }

    fn overlaps(self, o: Self) -> bool {
        self.x < o.x + o.width && o.x < self.x + self.width && self.y < o.y + o.height && o.y < self.y + self.height
    }
}

/// Up to `count` disjoint windows with the largest squared errors; each method is weighted by its
/// own mean.
pub(super) fn windows(methods: &[MethodResult], count: usize) -> Vec<Window> {
    let Some(first) = methods.first() else { return Vec::new() };
    let (width, height) = (first.picture.width(), first.picture.height());
    let (w, h) = (width as usize, height as usize);
    let mut sum = vec![0.0; w * h];
    for method in methods {
        let square = |e: &f32| Some(f64::from(*e)).filter(|e| e.is_finite()).map_or(0.0, |e| e * e);
        let mean = method.error.iter().map(square).sum::<f64>() / (w * h) as f64;
        if mean > 0.0 {
            sum.iter_mut().zip(&method.error).for_each(|(sum, e)| *sum += square(e) / mean);
        }
    }
    // Summed-area table: sum over all pixels left of and above.
    let mut table = vec![0.0; (w + 1) * (h + 1)];
    for y in 0..h {
        let mut row = 0.0;
        for x in 0..w {
            row += sum[y * w + x];
            table[(y + 1) * (w + 1) + x + 1] = table[y * (w + 1) + x + 1] + row;
        }
    }
    let (cw, ch) = (CROP.min(width), CROP.min(height));
    let within = |at: &Window| {
        let corner = |x: u32, y: u32| table[y as usize * (w + 1) + x as usize];
        let (right, below) = (at.x + at.width, at.y + at.height);
        corner(right, below) - corner(at.x, below) - corner(right, at.y) + corner(at.x, at.y)
    };
    let mut chosen: Vec<Window> = Vec::new();
    while chosen.len() < count {
        let places =
            (0..=height - ch).flat_map(|y| (0..=width - cw).map(move |x| Window { x, y, width: cw, height: ch }));
        let free = places.filter(|place| chosen.iter().all(|c| !c.overlaps(*place)));
        let mut best: Option<(f64, Window)> = None;
        for place in free {
            let value = within(&place);
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
mod tests {
    use super::*;
    use crate::integrate::Algorithm;

    /// Rec. 709.
    fn luminance(c: Vec3) -> f32 {
        c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    #[test]
    fn ramps_rise_in_lightness() {
        let ramps = [ramp as fn(f64) -> Vec3, signed_ramp, |t| signed_ramp(-t)];
        for ramp in ramps {
            let lights: Vec<f32> = (0..=64).map(|i| luminance(ramp(f64::from(i) / 64.0))).collect();
            assert!(lights.windows(2).all(|pair| pair[1] > pair[0]), "{lights:?}");
            assert!(lights[0] < 0.01 && lights[64] > 0.6);
        }
        // White and red as OKLab defines them.
        assert!((oklch(1.0, 0.0, 0.0) - Vec3::ONE).length() < 1e-6);
        assert!((oklch(0.627_955, 0.257_683, 29.233_9) - Vec3::X).length() < 1e-3);
    }

    #[test]
    fn scales_hold_all_but_fireflies() {
        let mut values = vec![0.017; 1000];
        values[0] = 1e9;
        values.push(f64::NAN);
        assert!((scale(values.into_iter()).unwrap() - 0.02).abs() < 1e-12);
        assert!((scale([0.05].into_iter()).unwrap() - 0.05).abs() < 1e-12);
        assert_eq!(scale([0.0, -1.0].into_iter()), None);
    }

    fn method(width: u32, height: u32, error: Vec<f32>) -> MethodResult {
        let image = Image::new(width, height).unwrap();
        MethodResult {
            label: String::new(),
            algorithm: Algorithm::Path,
            command: String::new(),
            setup: 0.0,
            alpha: 1.0,
            radii: None,
            checkpoints: Vec::new(),
            picture: image.clone(),
            error,
            difference: image,
        }
    }

    #[test]
    fn windows_are_where_errors_are() {
        let mut error = vec![0.0; 200 * 100];
        error[90 * 200 + 180] = 3.0;
        error[5 * 200 + 20] = 1.0;
        let found = windows(&[method(200, 100, error)], 3);
        assert_eq!(found.len(), 2);
        assert!(found[0].overlaps(Window { x: 180, y: 90, width: 1, height: 1 }), "{found:?}");
        assert!(found[1].overlaps(Window { x: 20, y: 5, width: 1, height: 1 }) && !found[0].overlaps(found[1]));
        let small = windows(&[method(8, 4, vec![1.0; 32])], 3);
        assert_eq!(small, [Window { x: 0, y: 0, width: 8, height: 4 }]);
    }

    #[test]
    fn errors_are_colours_by_their_logarithm() {
        let map = error_map(&method(4, 1, vec![0.0, 0.002, 0.02, 0.2]), 0.2).unwrap();
        let expected = [ramp(0.0), ramp(0.0), ramp(0.5), ramp(1.0)];
        assert!(map.pixels().iter().zip(expected).all(|(a, b)| (*a - b).length() < 1e-5));
    }

    /// Radiance 2 everywhere: differences are relative to √(2² + 2²).
    #[test]
    fn differences_are_relative_to_the_light_around() {
        let truth = Image::from_pixels(2, 1, vec![Vec3::splat(2.0); 2]).unwrap();
        let difference = Image::from_pixels(2, 1, vec![Vec3::new(0.3, 0.0, 0.0), Vec3::splat(-1.0)]).unwrap();
        let found = relative(&difference, &RelativeScale::of(&truth));
        let eight = f64::sqrt(8.0);
        assert!((found[0] - 0.1 / eight).abs() < 1e-7 && (found[1] + 1.0 / eight).abs() < 1e-12);
    }
}
