//! Encodes pictures for reports, at an exposure that makes them visible.

use crate::image::{Image, MAX_EXPOSURE_STOPS, OutputFormat, ToneCurve, ToneMap, WriteOptions, encode};
use crate::study::StudyError;
use glam::Vec3;

/// Fraction of the non-black pixels that automatic exposure may clip to white.
const MAX_CLIPPED_FRACTION: f64 = 0.01;

/// Returns `image` as the bytes of a PNG file, at an exposure of `stops` \[stops].
pub(super) fn encode_png(image: &Image, stops: f32) -> Result<Vec<u8>, StudyError> {
    let tone = ToneMap { curve: ToneCurve::Srgb, exposure_stops: stops };
    Ok(encode(OutputFormat::Png, image, &WriteOptions { tone, ..WriteOptions::default() })?.0)
}

/// Returns the positive part of a difference picture: negative channels become 0.
pub(super) fn positive_part(difference: &Image) -> Result<Image, StudyError> {
    map_pixels(difference, |d| d.max(Vec3::ZERO))
}

/// Returns the negative part of a difference picture with reversed sign: positive channels become
/// 0.
pub(super) fn negative_part(difference: &Image) -> Result<Image, StudyError> {
    map_pixels(difference, |d| (-d).max(Vec3::ZERO))
}

fn map_pixels(difference: &Image, map: fn(Vec3) -> Vec3) -> Result<Image, StudyError> {
    let pixels = difference.pixels().iter().map(|d| map(*d)).collect();
    Ok(Image::from_pixels(difference.width(), difference.height(), pixels)?)
}

/// Returns the largest exposure, in whole stops, that clips at most about 1 % of the non-black
/// pixels of `image` to white. `None` if all pixels are black.
pub(super) fn auto_exposure_stops(image: &Image) -> Option<f32> {
    let mut peaks: Vec<f32> = image.pixels().iter().map(|p| p.max_element()).filter(|p| *p > 0.0).collect();
    if peaks.is_empty() {
        return None;
    }
    let index = ((peaks.len() - 1) as f64 * (1.0 - MAX_CLIPPED_FRACTION)) as usize;
    let (_, peak, _) = peaks.select_nth_unstable_by(index, f32::total_cmp);
    Some((-libm::log2f(*peak)).floor().clamp(-MAX_EXPOSURE_STOPS, MAX_EXPOSURE_STOPS))
}

/// Returns the text of an exposure, such as `+1 stop`, `0 stops` or `-3 stops`.
pub(super) fn exposure_text(stops: f32) -> String {
    let sign = if stops > 0.0 { "+" } else { "" };
    format!("{sign}{stops} {}", if stops.abs() == 1.0 { "stop" } else { "stops" })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray_image(values: &[f32]) -> Image {
        Image::from_pixels(values.len() as u32, 1, values.iter().map(|v| Vec3::splat(*v)).collect()).unwrap()
    }

    #[test]
    fn difference_splits_into_positive_and_negative_parts() {
        let difference = gray_image(&[0.5, -0.25, 0.0]);
        assert_eq!(positive_part(&difference).unwrap(), gray_image(&[0.5, 0.0, 0.0]));
        assert_eq!(negative_part(&difference).unwrap(), gray_image(&[0.0, 0.25, 0.0]));
    }

    #[test]
    fn auto_exposure_ignores_fireflies() {
        // At three stops, a pixel of 0.1 becomes 0.1 · 2³ = 0.8, which is below 1. At four stops,
        // it exceeds 1.
        let mut faint = vec![0.1; 200];
        faint[7] = 1e6;
        assert_eq!(auto_exposure_stops(&gray_image(&faint)), Some(3.0));
        assert_eq!(
            (auto_exposure_stops(&gray_image(&[0.0, 4.0])), auto_exposure_stops(&gray_image(&[0.0; 3]))),
            (Some(-2.0), None)
        );
        assert_eq!(auto_exposure_stops(&gray_image(&[f32::from_bits(1)])), Some(MAX_EXPOSURE_STOPS));
    }
}
