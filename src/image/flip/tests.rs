use super::*;

fn image_from_color_function(color: impl Fn(i32, i32) -> [f32; 3]) -> Image {
    let pixels = (0..48).flat_map(|y| (0..64).map(move |x| (x, y))).map(|(x, y)| Vec3::from(color(x, y))).collect();
    Image::from_pixels(64, 48, pixels).unwrap()
}

fn gradient_color(x: i32, y: i32) -> [f32; 3] {
    [x as f32 / 64.0, y as f32 / 64.0, ((x + y) % 64) as f32 / 64.0]
}

fn deterministic_pixel_noise(x: i32, y: i32, channel: i32) -> f32 {
    ((x * 73 + y * 151 + channel * 37) % 17 - 8) as f32
}

fn noisy_gradient_color(x: i32, y: i32) -> [f32; 3] {
    std::array::from_fn(|k| {
        (gradient_color(x, y)[k] + deterministic_pixel_noise(x, y, k as i32) / 64.0).clamp(0.0, 1.0)
    })
}

fn gray_box_color(x: i32, y: i32) -> [f32; 3] {
    if (20..40).contains(&x) && (10..30).contains(&y) { [0.75, 0.5, 0.25] } else { [0.125, 0.125, 0.25] }
}

fn bright_lamp_color(x: i32, y: i32) -> [f32; 3] {
    let lamp = if (50..54).contains(&x) && (8..12).contains(&y) { 64.0 } else { 1.0 };
    gradient_color(x, y).map(|c| (c + 0.0625) * lamp)
}

fn ldr_flip_at_default_exposure(a: &Image, b: &Image) -> FlipMetricResult {
    flip_metric(a, b, &FlipMetricOptions::default()).unwrap()
}

/// Asserts that two ꟻLIP results are equal.
#[track_caller]
fn assert_same_result(a: &FlipMetricResult, b: &FlipMetricResult) {
    assert!(a == b, "means {} and {}", a.mean, b.mean);
}

/// Asserts the mean error of a ꟻLIP result and three errors of pixels: the largest error, the error
/// in column 30 of row 20, and the error of the first pixel.
#[track_caller]
fn assert_flip_values(found: &FlipMetricResult, mean: f64, [largest, inside, first]: [f32; 3]) {
    // The program of the authors of ꟻLIP computes in f32. Square roots of small feature differences
    // amplify its rounding errors to about 10⁻⁴.
    assert!((found.mean - mean).abs() < 2e-5, "{} instead of {mean}", found.mean);
    let most = found.error_map.iter().copied().fold(0.0, f32::max);
    for (found, expected) in [(most, largest), (found.error_map[20 * 64 + 30], inside), (found.error_map[0], first)] {
        assert!((found - expected).abs() < 2e-4, "{found} instead of {expected}");
    }
}

/// The ꟻLIP errors of this module equal those of flip-evaluator 1.7, the program of the authors of
/// ꟻLIP.
#[test]
fn flip_results_match_the_authors_program() {
    let shifted = image_from_color_function(|x, y| gray_box_color(x - 2, y + 1));
    assert_flip_values(
        &ldr_flip_at_default_exposure(
            &image_from_color_function(gradient_color),
            &image_from_color_function(noisy_gradient_color),
        ),
        0.077_562_697,
        [0.430_228_1, 0.087_598_2, 0.299_372_6],
    );
    assert_flip_values(
        &ldr_flip_at_default_exposure(&image_from_color_function(gray_box_color), &shifted),
        0.093_975_276,
        [0.729_492, 0.016_107_9, 0.0],
    );
    let coarse = FlipMetricOptions { pixels_per_degree: 20.0, ..FlipMetricOptions::default() };
    let found = flip_metric(
        &image_from_color_function(gradient_color),
        &image_from_color_function(noisy_gradient_color),
        &coarse,
    )
    .unwrap();
    assert_flip_values(&found, 0.327_105_910, [0.763_210_7, 0.229_014_2, 0.031_483_4]);
    let found = flip_metric(&image_from_color_function(gray_box_color), &shifted, &coarse).unwrap();
    assert_flip_values(&found, 0.067_302_711, [0.974_457_3, 0.0, 0.0]);
    let test = image_from_color_function(|x, y| {
        bright_lamp_color(x, y).map(|c| c * (1.0 + deterministic_pixel_noise(x, y, 0) / 32.0))
    });
    let hdr = FlipMetricOptions { mode: FlipMetricMode::Hdr, ..FlipMetricOptions::default() };
    assert_flip_values(
        &flip_metric(&image_from_color_function(bright_lamp_color), &test, &hdr).unwrap(),
        0.051_461_030,
        [0.212_969_1, 0.029_936_8, 0.190_408_4],
    );
}

#[test]
fn flip_error_ranges_from_0_to_1() {
    let even = |color: [f32; 3]| image_from_color_function(move |_, _| color);
    let hdr = FlipMetricOptions { mode: FlipMetricMode::Hdr, ..FlipMetricOptions::default() };
    for image in
        [image_from_color_function(noisy_gradient_color), image_from_color_function(bright_lamp_color), even([0.0; 3])]
    {
        for options in [FlipMetricOptions::default(), hdr] {
            let found = flip_metric(&image, &image, &options).unwrap();
            assert!(found.mean == 0.0 && found.error_map.iter().all(|e| *e == 0.0), "{}", found.mean);
        }
    }
    // Green and blue differ most (section 4.1.3). For black and white the authors' program gives
    // 0.9674.
    assert!((ldr_flip_at_default_exposure(&even([0.0, 1.0, 0.0]), &even([0.0, 0.0, 1.0])).mean - 1.0).abs() < 1e-6);
    assert!((ldr_flip_at_default_exposure(&even([0.0; 3]), &even([1.0; 3])).mean - 0.967_388_3).abs() < 1e-5);
}

#[test]
fn ldr_flip_is_symmetric_and_applies_exposure() {
    let (a, b) = (image_from_color_function(gradient_color), image_from_color_function(noisy_gradient_color));
    assert_same_result(&ldr_flip_at_default_exposure(&a, &b), &ldr_flip_at_default_exposure(&b, &a));
    let half = |image: &Image| Image::from_pixels(64, 48, image.pixels().iter().map(|p| *p * 0.5).collect()).unwrap();
    let brighter = FlipMetricOptions { mode: FlipMetricMode::Ldr(1.0), ..FlipMetricOptions::default() };
    assert_same_result(&flip_metric(&half(&a), &half(&b), &brighter).unwrap(), &ldr_flip_at_default_exposure(&a, &b));
}

/// The ꟻLIP error between a sharp picture and blurred versions of it grows with each blur.
#[test]
fn more_blur_increases_the_flip_error() {
    let sharp = image_from_color_function(gray_box_color);
    let mut image = sharp.clone();
    let mut last = 0.0;
    for _ in 0..6 {
        let old = image.clone();
        image = image_from_color_function(|x, y| {
            let at = |x: i32, y: i32| old.get(x.clamp(0, 63) as u32, y.clamp(0, 47) as u32).unwrap();
            let sum: Vec3 = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(i, j)| at(x + i, y + j)).into_iter().sum();
            ((sum + at(x, y)) / 5.0).to_array()
        });
        let mean = ldr_flip_at_default_exposure(&sharp, &image).mean;
        assert!(mean > last, "{mean} after {last}");
        last = mean;
    }
}

#[test]
fn flip_accepts_tiny_pictures_and_any_thread_count() {
    let (a, b) = (image_from_color_function(gradient_color), image_from_color_function(noisy_gradient_color));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_same_result(&one.install(|| ldr_flip_at_default_exposure(&a, &b)), &ldr_flip_at_default_exposure(&a, &b));
    let single = |v: f32| Image::from_pixels(1, 1, vec![Vec3::splat(v)]).unwrap();
    let wide = FlipMetricOptions { pixels_per_degree: 1000.0, ..FlipMetricOptions::default() };
    assert!(flip_metric(&single(0.0), &single(1.0), &wide).unwrap().mean > 0.9);
    let narrow = FlipMetricOptions { pixels_per_degree: 1.0, ..FlipMetricOptions::default() };
    assert!(flip_metric(&a, &b, &narrow).unwrap().mean.is_finite());
}

#[test]
fn invalid_options_and_sizes_are_refused() {
    let a = image_from_color_function(gradient_color);
    let options = |pixels_per_degree, mode| FlipMetricOptions { pixels_per_degree, mode };
    for bad in [0.5, f64::NAN, 1001.0] {
        let error = flip_metric(&a, &a, &options(bad, FlipMetricMode::Hdr)).unwrap_err();
        assert!(matches!(error, MetricError::OptionOutOfRange { name: "pixels per degree", .. }));
    }
    let error = flip_metric(&a, &a, &options(67.0, FlipMetricMode::Ldr(f32::NAN))).unwrap_err();
    assert!(matches!(error, MetricError::OptionOutOfRange { name: "exposure", .. }));
    assert!(matches!(
        flip_metric(&a, &Image::new(2, 2).unwrap(), &FlipMetricOptions::default()),
        Err(MetricError::SizeMismatch { .. })
    ));
}
