//! Error metrics between two pictures, such as the relative mean squared error.

use super::buffer::{Image, Rgb8Image};
use super::relative::RelativeErrorWeights;
use serde::Serialize;

/// Error: two pictures cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MetricError {
    /// The two pictures differ in size.
    #[error("a picture of {} × {} pixels cannot be compared with one of {} × {}", a.0, a.1, b.0, b.1)]
    SizeMismatch {
        /// Width and height of the first picture.
        a: (u32, u32),
        /// Width and height of the second picture.
        b: (u32, u32),
    },
    /// A pixel is NaN or infinite.
    #[error("the {which} picture has a non-finite pixel in column {x}, row {y}: repair it before comparing")]
    NonFinite {
        /// The picture that contains the pixel: `first` or `second`.
        which: &'static str,
        /// Column of the pixel that is not finite, counted from 0 at the left.
        x: u32,
        /// Row of the pixel that is not finite, counted from 0 at the top.
        y: u32,
    },
    /// An option of the metric is out of range.
    #[error("{name} is {value}, which is out of range")]
    OptionOutOfRange {
        /// Name of the refused option: `epsilon`, `clip`, `exposure` or `pixels per degree`.
        name: &'static str,
        /// Refused value of the option.
        value: f64,
    },
}

/// Returns the root mean square error over all pixels and channels \[W/(m² sr)].
///
/// # Errors
/// [`MetricError`] if the sizes differ or a pixel is not finite.
pub fn rmse(a: &Image, b: &Image) -> Result<f64, MetricError> {
    let mut sum = 0.0;
    for (a, b) in pixel_pairs(a, b)? {
        let d = a.as_dvec3() - b.as_dvec3();
        sum += d.length_squared();
    }
    Ok((sum / (3.0 * b.pixels().len() as f64)).sqrt())
}

/// Returns the relative mean square error: mean of (a − b)² / (b² + ε) over pixels and channels
/// (Rousselle et al. 2011).
///
/// In the formula, a and b are channel values of the pictures `a` and `reference`. ε is `epsilon`,
/// in the unit of b²; 0.01 is common. The relative squared error of a pixel is limited to `clip`,
/// so that a firefly does not dominate. `None` means no limit.
///
/// # Errors
/// [`MetricError`] if the sizes differ, a pixel is not finite, or ε or `clip` is not positive and
/// finite.
pub fn relative_mse(a: &Image, reference: &Image, epsilon: f64, clip: Option<f64>) -> Result<f64, MetricError> {
    let clip = clip.unwrap_or(f64::MAX);
    for (name, value) in [("epsilon", epsilon), ("clip", clip)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(MetricError::OptionOutOfRange { name, value });
        }
    }
    let mut sum = 0.0;
    for (a, b) in pixel_pairs(a, reference)? {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        let d = a - b;
        let ratio = d * d / (b * b + epsilon);
        sum += (ratio.element_sum() / 3.0).min(clip);
    }
    Ok(sum / reference.pixels().len() as f64)
}

/// Largest absolute difference between two pictures in one channel, and the pixel where it occurs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LargestDifference {
    /// Largest absolute difference of the two pictures in one channel \[W/(m² sr)].
    pub difference: f64,
    /// Column of the pixel with this difference, counted from 0 at the left.
    pub x: u32,
    /// Row of the pixel with this difference, counted from 0 at the top.
    pub y: u32,
}

/// Differences between two pictures: the largest in each channel, and the number of differing
/// pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelDifferences {
    /// Largest difference in red, in green and in blue; `None` for a channel that is equal in all
    /// pixels.
    ///
    /// If several pixels have the largest difference, the first one in rows from the top is given.
    pub largest: [Option<LargestDifference>; 3],
    /// Number of pixels that differ in at least one channel.
    pub differing_pixel_count: usize,
}

/// Returns the largest difference of two pictures in each channel, and the number of differing
/// pixels. Values 0 and −0 count as equal.
///
/// # Errors
/// [`MetricError`] if the sizes differ or a pixel is not finite.
pub fn largest_differences(a: &Image, b: &Image) -> Result<PixelDifferences, MetricError> {
    let width = a.width() as usize;
    let mut found = PixelDifferences::default();
    for (i, (a, b)) in pixel_pairs(a, b)?.enumerate() {
        if a == b {
            continue;
        }
        found.differing_pixel_count += 1;
        for (most, difference) in found.largest.iter_mut().zip((a.as_dvec3() - b.as_dvec3()).abs().to_array()) {
            if difference > most.map_or(0.0, |m| m.difference) {
                *most = Some(LargestDifference { difference, x: (i % width) as u32, y: (i / width) as u32 });
            }
        }
    }
    Ok(found)
}

/// Returns the relative root mean square error of `a` against `reference`.
///
/// Errors are relative to the local radiance of `reference`; see [`RelativeErrorWeights`] for the
/// formula. The squared relative error of a pixel counts at most 1.
///
/// # Errors
/// [`MetricError`] if the sizes differ or a pixel is not finite.
pub fn relative_error(a: &Image, reference: &Image) -> Result<f64, MetricError> {
    check_comparable(a, reference)?;
    let (a, b) = (a.pixels(), reference.pixels());
    let square = |i: usize| {
        let d = a[i].as_dvec3() - b[i].as_dvec3();
        d * d
    };
    Ok(RelativeErrorWeights::from_image(reference).mean_relative_squared_error(square).sqrt())
}

/// Differences of the levels of two 8-bit pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ByteDifference {
    /// Number of channel values that differ.
    pub count: usize,
    /// Largest difference of a channel value \[levels].
    pub largest: u8,
}

/// Compares the levels of two 8-bit pictures.
///
/// # Errors
/// [`MetricError::SizeMismatch`] if the sizes differ.
pub fn compare_bytes(a: &Rgb8Image, b: &Rgb8Image) -> Result<ByteDifference, MetricError> {
    check_equal_sizes((a.width(), a.height()), (b.width(), b.height()))?;
    let levels = a.pixels().as_flattened().iter().zip(b.pixels().as_flattened()).map(|(a, b)| a.abs_diff(*b));
    Ok(levels
        .filter(|&d| d > 0)
        .fold(ByteDifference::default(), |all, d| ByteDifference { count: all.count + 1, largest: all.largest.max(d) }))
}

fn check_equal_sizes(a: (u32, u32), b: (u32, u32)) -> Result<(), MetricError> {
    if a == b { Ok(()) } else { Err(MetricError::SizeMismatch { a, b }) }
}

/// Fails if the sizes of two pictures differ or a pixel is not finite.
pub(super) fn check_comparable(a: &Image, b: &Image) -> Result<(), MetricError> {
    check_equal_sizes((a.width(), a.height()), (b.width(), b.height()))?;
    for (which, image) in [("first", a), ("second", b)] {
        if let Some(at) = image.pixels().iter().position(|pixel| !pixel.is_finite()) {
            let width = image.width() as usize;
            return Err(MetricError::NonFinite { which, x: (at % width) as u32, y: (at / width) as u32 });
        }
    }
    Ok(())
}

/// Returns pairs of the pixels of `a` and `b` at equal positions; fails if the sizes differ or a
/// pixel is not finite.
fn pixel_pairs<'a>(
    a: &'a Image,
    b: &'a Image,
) -> Result<impl Iterator<Item = (&'a glam::Vec3, &'a glam::Vec3)>, MetricError> {
    check_comparable(a, b)?;
    Ok(a.pixels().iter().zip(b.pixels()))
}

#[cfg(test)]
mod tests;
