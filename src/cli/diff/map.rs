//! Pictures of errors.

use super::MapKind;
use crate::image::{Image, OutputFormat, RelativeScale, diverging, sequential};
use glam::{DVec3, Vec3};
use serde::Serialize;

/// The part of pixels that the colours of a PNG reach. One firefly must not darken all others.
const REACHED: f64 = 0.99;

/// What the colours of a PNG mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Colors {
    /// The number that the first colour stands for.
    pub from: f64,
    /// The number that the last colour stands for; larger ones have it too.
    pub to: f64,
}

/// The map as linear light for PNG, with the meaning of its colours, or as numbers for OpenEXR. Pictures are of one size, and so is `flip`.
pub(super) fn map(
    kind: MapKind,
    a: &Image,
    b: &Image,
    flip: &[f32],
    format: OutputFormat,
) -> (Vec<Vec3>, Option<Colors>) {
    let numbers = numbers(kind, a, b, flip);
    if format == OutputFormat::Exr {
        return (numbers.iter().map(|v| v.as_vec3()).collect(), None);
    }
    let means: Vec<f64> = numbers.iter().map(|v| v.element_sum() / 3.0).collect();
    let to = if kind == MapKind::Flip { 1.0 } else { reach(&means) };
    let color = if kind == MapKind::Signed { diverging } else { sequential };
    let from = if kind == MapKind::Signed { -to } else { 0.0 };
    (means.iter().map(|v| color(v / to)).collect(), Some(Colors { from, to }))
}

/// By channel; what has none is the same in all three.
fn numbers(kind: MapKind, a: &Image, b: &Image, flip: &[f32]) -> Vec<DVec3> {
    let differences = a.pixels().iter().zip(b.pixels()).map(|(a, b)| a.as_dvec3() - b.as_dvec3());
    match kind {
        MapKind::Flip => flip.iter().map(|e| DVec3::splat(f64::from(*e))).collect(),
        MapKind::Signed => differences.collect(),
        MapKind::Absolute => differences.map(DVec3::abs).collect(),
        MapKind::Relative => {
            let scale = RelativeScale::of(b);
            differences.zip(scale.weights()).map(|(d, w)| DVec3::splat((w * d.length_squared()).sqrt())).collect()
        }
    }
}

/// A size that most values stay below, above zero.
fn reach(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|v| v.abs()).collect();
    let place = ((sizes.len() - 1) as f64 * REACHED) as usize;
    let most = *sizes.select_nth_unstable_by(place, f64::total_cmp).1;
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    [most, largest].into_iter().find(|r| *r > 0.0).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(values: &[[f32; 3]]) -> Image {
        Image::from_pixels(values.len() as u32, 1, values.iter().map(|v| Vec3::from(*v)).collect()).unwrap()
    }

    #[test]
    fn numbers_follow_their_kind() {
        let (a, b) = (image(&[[2.0, 2.5, 1.0]]), image(&[[2.0; 3]]));
        let exr = |kind| map(kind, &a, &b, &[0.25], OutputFormat::Exr).0[0];
        assert_eq!(exr(MapKind::Signed), Vec3::new(0.0, 0.5, -1.0));
        assert_eq!(exr(MapKind::Absolute), Vec3::new(0.0, 0.5, 1.0));
        assert_eq!(exr(MapKind::Flip), Vec3::splat(0.25));
        // Of light 2 throughout: √((¼ + 1) / (3 · (4 + 4))).
        assert!((exr(MapKind::Relative) - f32::sqrt(1.25 / 24.0)).abs().max_element() < 1e-6);
    }

    #[test]
    fn colours_reach_as_far_as_most_errors() {
        let mut values = vec![[1.0_f32; 3]; 200];
        values[7] = [100.0; 3];
        values[8] = [0.5; 3];
        let (a, b) = (image(&values), image(&vec![[0.0; 3]; 200]));
        let (colors, meaning) = map(MapKind::Absolute, &a, &b, &[], OutputFormat::Png);
        assert_eq!(meaning, Some(Colors { from: 0.0, to: 1.0 }));
        assert_eq!([colors[0], colors[7], colors[8]], [sequential(1.0), sequential(1.0), sequential(0.5)]);
        let (colors, meaning) = map(MapKind::Signed, &b, &a, &[], OutputFormat::Png);
        assert_eq!(meaning, Some(Colors { from: -1.0, to: 1.0 }));
        assert_eq!((colors[0], colors[8]), (diverging(-1.0), diverging(-0.5)));
        let same = map(MapKind::Absolute, &a, &a, &[], OutputFormat::Png);
        assert_eq!((same.0[0], same.1), (sequential(0.0), Some(Colors { from: 0.0, to: 1.0 })));
        // A single pixel that differs is seen.
        let mut one = vec![[0.0_f32; 3]; 200];
        one[3] = [4.0; 3];
        let lone = map(MapKind::Absolute, &image(&one), &b, &[], OutputFormat::Png).1;
        assert_eq!(lone, Some(Colors { from: 0.0, to: 4.0 }));
    }
}
