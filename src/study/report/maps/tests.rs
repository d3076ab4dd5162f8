use super::*;
use crate::integrate::Algorithm;

/// Luminance of a linear colour with the primaries of Rec. 709.
fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[test]
fn ramps_rise_in_lightness() {
    let ramps = [error_color_ramp as fn(f64) -> Vec3, signed_color_ramp, |t| signed_color_ramp(-t)];
    for ramp in ramps {
        let luminances: Vec<f32> = (0..=64).map(|i| luminance(ramp(f64::from(i) / 64.0))).collect();
        assert!(luminances.windows(2).all(|pair| pair[1] > pair[0]), "{luminances:?}");
        assert!(luminances[0] < 0.01 && luminances[64] > 0.6);
    }
    // OKLab coordinates of white and red, converted to linear RGB.
    assert!((oklch_to_linear_rgb(1.0, 0.0, 0.0) - Vec3::ONE).length() < 1e-6);
    assert!((oklch_to_linear_rgb(0.627_955, 0.257_683, 29.233_9) - Vec3::X).length() < 1e-3);
}

#[test]
fn color_scales_ignore_fireflies() {
    let mut values = vec![0.017; 1000];
    values[0] = 1e9;
    values.push(f64::NAN);
    assert!((color_scale_maximum(values.into_iter()).unwrap() - 0.02).abs() < 1e-12);
    assert!((color_scale_maximum([0.05].into_iter()).unwrap() - 0.05).abs() < 1e-12);
    assert_eq!(color_scale_maximum([0.0, -1.0].into_iter()), None);
}

fn method_with_pixel_errors(width: u32, height: u32, error: Vec<f32>) -> MethodResult {
    let image = Image::new(width, height).unwrap();
    MethodResult {
        label: String::new(),
        algorithm: Algorithm::Path,
        render_command: String::new(),
        setup_seconds: 0.0,
        alpha: 1.0,
        gather_radii: None,
        checkpoints: Vec::new(),
        first_seed_picture: image.clone(),
        relative_pixel_errors: error,
        mean_difference: image,
    }
}

#[test]
fn windows_contain_the_largest_errors() {
    let mut error = vec![0.0; 200 * 100];
    error[90 * 200 + 180] = 3.0;
    error[5 * 200 + 20] = 1.0;
    let found = largest_error_windows(&[method_with_pixel_errors(200, 100, error)], 3);
    assert_eq!(found.len(), 2);
    assert!(found[0].overlaps(PixelWindow { x: 180, y: 90, width: 1, height: 1 }), "{found:?}");
    assert!(found[1].overlaps(PixelWindow { x: 20, y: 5, width: 1, height: 1 }) && !found[0].overlaps(found[1]));
    let small = largest_error_windows(&[method_with_pixel_errors(8, 4, vec![1.0; 32])], 3);
    assert_eq!(small, [PixelWindow { x: 0, y: 0, width: 8, height: 4 }]);
}

#[test]
fn error_maps_are_logarithmic() {
    let map = error_map(&method_with_pixel_errors(4, 1, vec![0.0, 0.002, 0.02, 0.2]), 0.2).unwrap();
    let expected = [error_color_ramp(0.0), error_color_ramp(0.0), error_color_ramp(0.5), error_color_ramp(1.0)];
    assert!(map.pixels().iter().zip(expected).all(|(a, b)| (*a - b).length() < 1e-5));
}

/// Differences are divided by √(L² + m²). L is the local radiance and m the median radiance of the
/// reference: see [`RelativeErrorWeights`]. Both are 2 in a reference of uniform radiance 2.
#[test]
fn differences_are_relative_to_local_radiance() {
    let reference = Image::from_pixels(2, 1, vec![Vec3::splat(2.0); 2]).unwrap();
    let difference = Image::from_pixels(2, 1, vec![Vec3::new(0.3, 0.0, 0.0), Vec3::splat(-1.0)]).unwrap();
    let found = relative_differences(&difference, &RelativeErrorWeights::from_image(&reference));
    let eight = f64::sqrt(8.0);
    assert!((found[0] - 0.1 / eight).abs() < 1e-7 && (found[1] + 1.0 / eight).abs() < 1e-12);
}
