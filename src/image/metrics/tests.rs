use super::*;
use glam::Vec3;

fn image_of_one_row(pixels: &[[f32; 3]]) -> Image {
    Image::from_pixels(pixels.len() as u32, 1, pixels.iter().map(|p| Vec3::from_array(*p)).collect()).unwrap()
}

#[test]
fn metrics_follow_their_formulas() {
    let a = image_of_one_row(&[[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]);
    let b = image_of_one_row(&[[1.0, 0.0, 3.0], [0.0, 1.0, 0.0]]);
    // The squared differences are 4 and 1, over six channel values.
    assert!((rmse(&a, &b).unwrap() - f64::sqrt(5.0 / 6.0)).abs() < 1e-15);
    // The relative squared error is 4 / (0 + ½) / 3 = 8/3 in the first pixel, and 1 / (1 + ½) / 3 =
    // 2/9 in the second.
    assert!((relative_mse(&a, &b, 0.5, None).unwrap() - (8.0 / 3.0 + 2.0 / 9.0) / 2.0).abs() < 1e-15);
    assert!((relative_mse(&a, &b, 0.5, Some(1.0)).unwrap() - (1.0 + 2.0 / 9.0) / 2.0).abs() < 1e-15);
    assert_eq!(rmse(&a, &a).unwrap(), 0.0);
}

#[test]
fn metrics_of_extreme_pixels_do_not_overflow() {
    let (a, b) = (image_of_one_row(&[[f32::MAX; 3]]), image_of_one_row(&[[-f32::MAX; 3]]));
    assert!((rmse(&a, &b).unwrap() / (2.0 * f64::from(f32::MAX)) - 1.0).abs() < 1e-12);
}

#[test]
fn incomparable_pictures_are_refused() {
    let (a, b) = (image_of_one_row(&[[0.0; 3]; 2]), image_of_one_row(&[[0.0; 3]; 3]));
    assert_eq!(rmse(&a, &b), Err(MetricError::SizeMismatch { a: (2, 1), b: (3, 1) }));
    let nan = image_of_one_row(&[[0.0; 3], [0.0, f32::NAN, 0.0]]);
    let expected = MetricError::NonFinite { which: "second", x: 1, y: 0 };
    assert_eq!(rmse(&a, &nan), Err(expected));
    assert_eq!(relative_mse(&a, &nan, 0.1, Some(1.0)), Err(expected));
    assert!(matches!(relative_mse(&a, &a, 0.0, None), Err(MetricError::OptionOutOfRange { name: "epsilon", .. })));
    assert!(matches!(relative_mse(&a, &a, 1.0, Some(-1.0)), Err(MetricError::OptionOutOfRange { name: "clip", .. })));
}

#[test]
fn largest_differences_have_positions() {
    let zero = Image::new(2, 2).unwrap();
    let pixels = [[0.0, 1.0, 0.0], [-0.0, -2.0, 0.5], [0.0; 3], [0.0, 2.0, 0.25]].map(Vec3::from_array);
    let image = Image::from_pixels(2, 2, pixels.to_vec()).unwrap();
    let found = largest_differences(&image, &zero).unwrap();
    let at = |difference, x, y| Some(LargestDifference { difference, x, y });
    assert_eq!(found, PixelDifferences { largest: [None, at(2.0, 1, 0), at(0.5, 1, 0)], differing_pixel_count: 3 });
    assert_eq!(largest_differences(&zero, &image).unwrap(), found);
    assert_eq!(largest_differences(&image, &image).unwrap(), PixelDifferences::default());
}

/// In a reference of uniform radiance 2, local radiance and median radiance are both 2. So an error
/// of 0.1 is a relative error of 0.1 / √(2² + 2²).
#[test]
fn the_relative_error_is_a_root_mean_square() {
    let (a, b) = (image_of_one_row(&[[2.1; 3]; 9]), image_of_one_row(&[[2.0; 3]; 9]));
    assert!((relative_error(&a, &b).unwrap() - 0.1 / f64::sqrt(8.0)).abs() < 1e-7);
    assert!(relative_error(&a, &image_of_one_row(&[[2.0; 3]; 8])).is_err());
}

#[test]
fn differing_bytes_counts_each_channel() {
    let a = Rgb8Image::from_pixels(2, 1, vec![[0, 10, 20], [30, 40, 50]]).unwrap();
    let b = Rgb8Image::from_pixels(2, 1, vec![[0, 11, 20], [30, 33, 50]]).unwrap();
    assert_eq!(compare_bytes(&a, &b), Ok(ByteDifference { count: 2, largest: 7 }));
    assert!(compare_bytes(&a, &Rgb8Image::from_pixels(1, 2, vec![[0; 3]; 2]).unwrap()).is_err());
}
