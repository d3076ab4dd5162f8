use super::*;

fn gray_image(width: u32, values: &[f32]) -> Image {
    let pixels: Vec<Vec3> = values.iter().map(|v| Vec3::splat(*v)).collect();
    Image::from_pixels(width, values.len() as u32 / width, pixels).unwrap()
}

/// In a reference of uniform radiance 2, local radiance and median radiance are both 2. So an error
/// of 0.1 is a relative error of 0.1 / √(2² + 2²).
#[test]
fn error_weights_of_uniform_pictures_follow_their_radiance() {
    let error_weights = RelativeErrorWeights::from_image(&gray_image(8, &[2.0; 64]));
    let square = error_weights.mean_relative_squared_error(|_| DVec3::splat(0.01));
    assert!((square - 0.01 / 8.0).abs() < 1e-15, "{square}");
}

/// A pixel of radiance 1000 changes only the weights of its 5 × 5 neighborhood.
#[test]
fn bright_pixels_change_only_their_neighbourhood() {
    let mut values = vec![1.0; 16 * 16];
    values[0] = 1000.0;
    values[255] = 0.0;
    let error_weights = RelativeErrorWeights::from_image(&gray_image(16, &values));
    assert!((error_weights.pixel_weights()[8 * 16 + 8] * 3.0 - 0.5).abs() < 1e-12);
    // The neighborhood of a corner pixel has nine pixels: one of radiance 1000 and eight of
    // radiance 1.
    let corner = 1008.0 / 9.0;
    assert!((error_weights.pixel_weights()[0] * 3.0 * (corner * corner + 1.0) - 1.0).abs() < 1e-12);
    assert!(error_weights.pixel_weights()[255] * 3.0 <= 1.0);
}

#[test]
fn relative_error_counts_a_firefly_as_one_pixel() {
    let error_weights = RelativeErrorWeights::from_image(&gray_image(8, &[1.0; 64]));
    let firefly = |i| if i == 5 { DVec3::splat(1e9) } else { DVec3::ZERO };
    assert_eq!(
        (
            error_weights.mean_relative_squared_error(firefly),
            error_weights.mean_relative_squared_error(|i| -firefly(i))
        ),
        (1.0 / 64.0, -1.0 / 64.0)
    );
}

#[test]
fn black_and_non_finite_pictures_have_error_weights() {
    assert_eq!(
        RelativeErrorWeights::from_image(&gray_image(2, &[0.0; 4])).mean_relative_squared_error(|_| DVec3::ONE),
        1.0
    );
    let broken = RelativeErrorWeights::from_image(&gray_image(2, &[1.0, f32::NAN, 1.0, f32::INFINITY]));
    assert!(broken.pixel_weights().iter().all(|w| (w * 6.0 - 1.0).abs() < 1e-12));
}
