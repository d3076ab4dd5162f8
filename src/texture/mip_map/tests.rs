//! Tests of picture textures and their MIP levels.

use super::*;
use crate::sampling::{Dimension, Key, Purpose};

/// Picture with pseudorandom colors in \[0, 1].
fn random_image(width: u32, height: u32) -> Image {
    let pixel = |i: u32| {
        let u = Key::new(9).purpose_key(Purpose::Test).child_key(u64::from(i)).uniform_2d(Dimension::Film);
        Vec3::new(u.x, u.y, u.x * u.y)
    };
    Image::from_pixels(width, height, (0..width * height).map(pixel).collect()).unwrap()
}

/// The mean of lookups all over the unit square is the mean of the picture, at each MIP level.
///
/// Lookups lie at the quarter points of the pixels, so the sum of their interpolation weights is
/// equal for all pixels. The rounding error of a sum of n < 200 terms is n·2⁻²⁴.
#[test]
fn mip_lookups_keep_the_mean_at_all_levels() {
    for (width, height) in [(8, 8), (7, 5), (1, 9), (13, 6)] {
        for wrap in [WrapMode::Repeat, WrapMode::Clamp, WrapMode::Mirror] {
            let picture = MipMap::new(&random_image(width, height), wrap).unwrap();
            for (i, level) in picture.levels.iter().enumerate() {
                let (columns, rows) = (2 * level.width, 2 * level.height);
                let size =
                    DVec2::new(f64::from(1u32 << i) / f64::from(width), f64::from(1u32 << i) / f64::from(height));
                let mut sum = DVec3::ZERO;
                for at in 0..columns * rows {
                    let (x, y) = ((at % columns) as f64 + 0.5, (at / columns) as f64 + 0.5);
                    sum += picture.box_mean(DVec2::new(x / columns as f64, y / rows as f64), size).as_dvec3();
                }
                let error = (sum / (columns * rows) as f64 - picture.mean().as_dvec3()).abs().max_element();
                assert!(error < 2e-5, "{width} × {height}, {wrap:?}, level {i}: {error}");
            }
            let whole = picture.box_mean(DVec2::new(0.3, 0.9), DVec2::splat(1e3));
            assert!((whole - picture.mean()).abs().max_element() < 2e-5, "{wrap:?}");
        }
    }
}

#[test]
fn picture_pixels_have_their_positions_and_wrap() {
    let values = [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]];
    let pixels = values.iter().flatten().map(|x| Vec3::splat(*x)).collect();
    let image = Image::from_pixels(3, 2, pixels).unwrap();
    let at = |wrap, column: f64, row: f64| {
        let uv = DVec2::new((column + 0.5) / 3.0, 1.0 - (row + 0.5) / 2.0);
        f64::from(MipMap::new(&image, wrap).unwrap().box_mean(uv, DVec2::ZERO).x)
    };
    for wrap in [WrapMode::Repeat, WrapMode::Clamp, WrapMode::Mirror] {
        for (row, line) in values.iter().enumerate() {
            for (column, value) in line.iter().enumerate() {
                assert!((at(wrap, column as f64, row as f64) - f64::from(*value)).abs() < 1e-5);
            }
        }
        assert!((at(wrap, 0.25, 0.5) - 1.75).abs() < 1e-5, "half way down, a quarter to the right");
    }
    for (wrap, beyond) in
        [(WrapMode::Repeat, [0.0, 2.0, 1.0]), (WrapMode::Clamp, [2.0, 0.0, 2.0]), (WrapMode::Mirror, [2.0, 0.0, 1.0])]
    {
        for (column, value) in [(3.0, beyond[0]), (-1.0, beyond[1]), (4.0, beyond[2])] {
            assert!((at(wrap, column, 0.0) - value).abs() < 1e-5, "{wrap:?} {column}");
        }
        assert!((at(wrap, 1e9, 0.0)).is_finite() && at(wrap, f64::INFINITY, f64::NAN).is_finite());
    }
}

#[test]
fn pictures_with_negative_or_nonfinite_values_are_refused() {
    let with = |value: f32| {
        let mut pixels = vec![Vec3::ONE; 6];
        pixels[4].y = value;
        MipMap::new(&Image::from_pixels(3, 2, pixels).unwrap(), WrapMode::Repeat).err()
    };
    assert_eq!(with(0.0), None);
    assert_eq!(with(-1.0), Some(MipMapError::Negative { x: 1, y: 1 }));
    assert_eq!(with(f32::NAN), Some(MipMapError::NotFinite { x: 1, y: 1 }));
}
