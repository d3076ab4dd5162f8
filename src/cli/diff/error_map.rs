//! Error maps: pictures of the difference between two pictures.

use super::ErrorMapKind;
use crate::image::{Image, OutputFormat, RelativeErrorWeights, diverging_color, sequential_color};
use glam::{DVec3, Vec3};
use serde::Serialize;

/// Quantile of the absolute pixel errors that the last colour of a PNG error map shows. Larger
/// errors get this colour too, so that one firefly does not stretch the scale.
const SCALE_QUANTILE: f64 = 0.99;

/// Colour scale of a PNG error map: the errors that its first and last colours show.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct ColorScale {
    /// Error that the first colour of the scale shows: 0, or `-last_color_error` for signed errors.
    #[serde(rename = "from")]
    pub first_color_error: f64,
    /// Error that the last colour of the scale shows. Larger errors get this colour too.
    #[serde(rename = "to")]
    pub last_color_error: f64,
}

/// Returns the pixels of an error map. For PNG, also returns the colour scale of these pixels.
///
/// For PNG, the pixels are colours. For OpenEXR, the pixels are the errors of red, green and blue,
/// and the colour scale is `None`. `flip` holds the FLIP error of each pixel of `a` against `b`.
pub(super) fn error_map(
    kind: ErrorMapKind,
    a: &Image,
    b: &Image,
    flip: &[f32],
    format: OutputFormat,
) -> (Vec<Vec3>, Option<ColorScale>) {
    let values = error_map_values(kind, a, b, flip);
    if format == OutputFormat::Exr {
        return (values.iter().map(|v| v.as_vec3()).collect(), None);
    }
    let means: Vec<f64> = values.iter().map(|v| v.element_sum() / 3.0).collect();
    let to = if kind == ErrorMapKind::Flip { 1.0 } else { color_scale_end(&means) };
    let color = if kind == ErrorMapKind::Signed { diverging_color } else { sequential_color };
    let from = if kind == ErrorMapKind::Signed { -to } else { 0.0 };
    (means.iter().map(|v| color(v / to)).collect(), Some(ColorScale { first_color_error: from, last_color_error: to }))
}

/// Returns the errors of red, green and blue of each pixel. FLIP and relative errors are one number
/// per pixel, which is repeated in all channels.
fn error_map_values(kind: ErrorMapKind, a: &Image, b: &Image, flip: &[f32]) -> Vec<DVec3> {
    let differences = a.pixels().iter().zip(b.pixels()).map(|(a, b)| a.as_dvec3() - b.as_dvec3());
    match kind {
        ErrorMapKind::Flip => flip.iter().map(|e| DVec3::splat(f64::from(*e))).collect(),
        ErrorMapKind::Signed => differences.collect(),
        ErrorMapKind::Absolute => differences.map(DVec3::abs).collect(),
        ErrorMapKind::Relative => {
            let scale = RelativeErrorWeights::from_image(b);
            differences.zip(scale.pixel_weights()).map(|(d, w)| DVec3::splat((w * d.length_squared()).sqrt())).collect()
        }
    }
}

/// Returns the error that the last colour of a PNG error map shows: the quantile [`SCALE_QUANTILE`]
/// of the absolute `values`.
///
/// A colour scale needs a positive length. So if the quantile is 0, the result is the largest
/// absolute value, or 1 if all values are 0.
fn color_scale_end(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|v| v.abs()).collect();
    let index = ((sizes.len() - 1) as f64 * SCALE_QUANTILE) as usize;
    let most = *sizes.select_nth_unstable_by(index, f64::total_cmp).1;
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    [most, largest].into_iter().find(|r| *r > 0.0).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image_of_one_row(values: &[[f32; 3]]) -> Image {
        Image::from_pixels(values.len() as u32, 1, values.iter().map(|v| Vec3::from(*v)).collect()).unwrap()
    }

    #[test]
    fn error_map_values_follow_the_map_kind() {
        let (a, b) = (image_of_one_row(&[[2.0, 2.5, 1.0]]), image_of_one_row(&[[2.0; 3]]));
        let exr = |kind| error_map(kind, &a, &b, &[0.25], OutputFormat::Exr).0[0];
        assert_eq!(exr(ErrorMapKind::Signed), Vec3::new(0.0, 0.5, -1.0));
        assert_eq!(exr(ErrorMapKind::Absolute), Vec3::new(0.0, 0.5, 1.0));
        assert_eq!(exr(ErrorMapKind::Flip), Vec3::splat(0.25));
        // The squared differences sum to ¼ + 1. The reference has the local radiance L = 2 and the
        // median m = 2, so the error is √((¼ + 1) / (3 · (L² + m²))).
        assert!((exr(ErrorMapKind::Relative) - f32::sqrt(1.25 / 24.0)).abs().max_element() < 1e-6);
    }

    #[test]
    fn one_firefly_does_not_stretch_the_scale() {
        let mut values = vec![[1.0_f32; 3]; 200];
        values[7] = [100.0; 3];
        values[8] = [0.5; 3];
        let (a, b) = (image_of_one_row(&values), image_of_one_row(&vec![[0.0; 3]; 200]));
        let (colors, meaning) = error_map(ErrorMapKind::Absolute, &a, &b, &[], OutputFormat::Png);
        assert_eq!(meaning, Some(ColorScale { first_color_error: 0.0, last_color_error: 1.0 }));
        assert_eq!(
            [colors[0], colors[7], colors[8]],
            [sequential_color(1.0), sequential_color(1.0), sequential_color(0.5)]
        );
        let (colors, meaning) = error_map(ErrorMapKind::Signed, &b, &a, &[], OutputFormat::Png);
        assert_eq!(meaning, Some(ColorScale { first_color_error: -1.0, last_color_error: 1.0 }));
        assert_eq!((colors[0], colors[8]), (diverging_color(-1.0), diverging_color(-0.5)));
        let same = error_map(ErrorMapKind::Absolute, &a, &a, &[], OutputFormat::Png);
        assert_eq!(
            (same.0[0], same.1),
            (sequential_color(0.0), Some(ColorScale { first_color_error: 0.0, last_color_error: 1.0 }))
        );
        // The only differing pixel sets the end of the colour scale, because the quantile of all
        // errors is 0.
        let mut one = vec![[0.0_f32; 3]; 200];
        one[3] = [4.0; 3];
        let single = error_map(ErrorMapKind::Absolute, &image_of_one_row(&one), &b, &[], OutputFormat::Png).1;
        assert_eq!(single, Some(ColorScale { first_color_error: 0.0, last_color_error: 4.0 }));
    }
}
