//! Exposures and the film curve of HDR-ꟻLIP (Andersson et al. 2021, section 4).

use crate::image::Image;
use crate::math::positive_median;
use glam::{DVec3, Vec3};

/// Coefficients k₀ … k₄ of the film curve of HDR-ꟻLIP: (k₀x² + k₁x) / (k₂x² + k₃x + k₄).
///
/// The curve is Narkowicz's fit of the ACES film curve, with his exposure factor 0.6.
const FILM_CURVE_COEFFICIENTS: [f64; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];

/// Output of the film curve that counts as close to white.
const NEAR_WHITE: f64 = 0.85;

/// Maps `radiance` times `scale` to linear display values in \[0, 1] by the film curve. Negative
/// radiance counts as 0.
pub(super) fn film_curve(radiance: Vec3, scale: f64) -> Vec3 {
    let x = radiance.as_dvec3().max(DVec3::ZERO) * scale;
    let [k0, k1, k2, k3, k4] = FILM_CURVE_COEFFICIENTS;
    let level = (x * (k0 * x + k1)) / (x * (k2 * x + k3) + k4);
    level.min(DVec3::ONE).as_vec3()
}

/// Returns the exposures of HDR-ꟻLIP \[stops], which are about one stop apart. The first exposure
/// brings the brightest pixel of `reference` close to white. The last exposure brings the median
/// pixel close to white.
///
/// Black pixels are left out of the median. A black reference has only the exposure 0.
pub(super) fn hdr_flip_exposures(reference: &Image) -> Vec<f64> {
    let luminance = |p: &Vec3| p.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722));
    let luminances = || reference.pixels().iter().map(luminance);
    let Some(median) = positive_median(luminances()) else { return vec![0.0] };
    let brightest = luminances().fold(median, f64::max);
    let bright = film_input_near_white();
    let (first, last) = (libm::log2(bright / brightest), libm::log2(bright / median));
    let count = (last - first).ceil().max(2.0);
    (0..count as u32).map(|i| first + f64::from(i) * (last - first) / (count - 1.0)).collect()
}

/// Input x of the film curve whose output t is [`NEAR_WHITE`].
///
/// x is the positive root of (k₀ − k₂t)x² + (k₁ − k₃t)x − k₄t, with the coefficients kᵢ of
/// [`FILM_CURVE_COEFFICIENTS`].
fn film_input_near_white() -> f64 {
    let [k0, k1, k2, k3, k4] = FILM_CURVE_COEFFICIENTS;
    let (a, half, c) = (k0 - k2 * NEAR_WHITE, 0.5 * (k1 - k3 * NEAR_WHITE), -k4 * NEAR_WHITE);
    ((half * half - a * c).sqrt() - half) / a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image_of_one_row(values: &[f32]) -> Image {
        Image::from_pixels(values.len() as u32, 1, values.iter().map(|v| Vec3::splat(*v)).collect()).unwrap()
    }

    #[test]
    fn the_near_white_input_inverts_the_curve() {
        let level = film_curve(Vec3::splat(film_input_near_white() as f32), 1.0);
        assert!((f64::from(level.x) - NEAR_WHITE).abs() < 1e-6, "{level}");
        assert_eq!(film_curve(Vec3::new(-1.0, 0.0, f32::MAX), 1e30), Vec3::new(0.0, 0.0, 1.0));
    }

    /// HDR-ꟻLIP uses four exposures for the range of four stops between the maximum 16 and the
    /// median 1.
    ///
    /// The median excludes black pixels.
    #[test]
    fn exposures_span_the_brightest_to_the_median() {
        let found = hdr_flip_exposures(&image_of_one_row(&[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 16.0]));
        assert_eq!(found.len(), 4);
        assert!(
            (found[3] - found[0] - 4.0).abs() < 1e-9 && (found[3] - libm::log2(film_input_near_white())).abs() < 1e-9,
            "{found:?}"
        );
        assert_eq!(hdr_flip_exposures(&image_of_one_row(&[0.0, -1.0])), [0.0]);
        let even = hdr_flip_exposures(&image_of_one_row(&[2.0; 4]));
        assert!(even.len() == 2 && even[0] == even[1], "{even:?}");
    }
}
