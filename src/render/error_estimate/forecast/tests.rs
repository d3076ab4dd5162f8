use super::*;

fn error_estimate_with_parts(
    passes: u32,
    variance: f64,
    difference_variance: f64,
    blur: f64,
    blur_ratio: f64,
) -> ErrorEstimate {
    ErrorEstimate { passes, variance, difference_variance, blur, blur_ratio, ..ErrorEstimate::default() }
}

/// A tenth of the pixels are fireflies of relative squared noise 16. With more passes, more pixels
/// are fireflies. Above four times the passes, each firefly contributes less.
#[test]
fn fireflies_spread_before_they_fade() {
    let mut fireflies = FireflyHistogram::default();
    (0..10).for_each(|_| fireflies.add(16.0, 0.01));
    let forecast = ErrorForecast::new(
        &ErrorEstimate { fireflies, ..error_estimate_with_parts(8, 8.0 * 0.1, 0.0, 0.0, 0.5) },
        None,
    );
    let noise2 = |n: u32| libm::pow(forecast.noise_and_bias_after_passes(n).0, 2.0);
    for (n, expected) in [(8, 0.1), (16, 0.2), (32, 0.4), (64, 0.2), (8 * 160, 0.01)] {
        // Brightness is stored to half an octave.
        assert!(libm::log2(noise2(n) / expected).abs() < 0.5 + 1e-9, "{n}: {} {expected}", noise2(n));
    }
}

/// If one pass has variance 0.04, the error is 0.1 after 4 passes and 0.01 after 400 passes.
#[test]
fn noise_alone_falls_as_the_root_of_passes() {
    let forecast = ErrorForecast::new(&error_estimate_with_parts(4, 0.04, 0.0, 0.0, 0.5), None);
    assert!((forecast.noise_and_bias_after_passes(4).0 - 0.1).abs() < 1e-12);
    assert_eq!(forecast.passes_to_reach(0.01), PassesNeeded::Passes(400));
    assert_eq!(forecast.passes_to_reach(1e-9), PassesNeeded::TooMany);
}

#[test]
fn fixed_radii_leave_a_bias_floor() {
    let forecast = ErrorForecast::new(&error_estimate_with_parts(10, 0.04, 0.01, 0.02, 0.5), Some((1.0, 0.5)));
    assert_eq!(forecast.passes_to_reach(0.02), PassesNeeded::Never { floor: 0.02 });
    let PassesNeeded::Passes(n) = forecast.passes_to_reach(0.025) else { panic!("it can be reached") };
    // .04/n = .025² − .02².
    assert_eq!(n, 178);
}

/// If all noise comes from photon estimates, noise and bias fall as n^(−1/3) (Knaus and Zwicker
/// 2011).
#[test]
fn shrinking_radii_follow_their_law() {
    let alpha = 2.0 / 3.0;
    let forecast = ErrorForecast::new(&error_estimate_with_parts(8, 0.04, 0.02, 0.02, 0.5), Some((alpha, 0.5)));
    let mean = |n: u32, power: f64| {
        (0..n).map(|i| libm::pow(squared_radius_ratio(alpha, i), power)).sum::<f64>() / f64::from(n)
    };
    let (noise, bias) = forecast.noise_and_bias_after_passes(64);
    let expected = 0.04 / 8.0 * (mean(64, -1.0) / 64.0) / (mean(8, -1.0) / 8.0);
    assert!((noise * noise / expected - 1.0).abs() < 1e-9, "{noise}");
    assert!((bias / (0.02 * mean(64, 1.0) / mean(8, 1.0)) - 1.0).abs() < 1e-9, "{bias}");
    let slope = |f: fn((f64, f64)) -> f64| {
        libm::log10(
            f(forecast.noise_and_bias_after_passes(1_000_000)) / f(forecast.noise_and_bias_after_passes(100_000)),
        )
    };
    assert!((slope(|e| e.0) + 1.0 / 3.0).abs() < 1e-3 && (slope(|e| e.1) + 1.0 / 3.0).abs() < 1e-3);
    let PassesNeeded::Passes(n) = forecast.passes_to_reach(0.01) else { panic!("it can be reached") };
    let error = |n| forecast.noise_and_bias_after_passes(n).0.hypot(forecast.noise_and_bias_after_passes(n).1);
    let fewer = if n < EXACT_PASSES { n - 1 } else { n - n / GROUP_DIVISOR - 1 };
    assert!(error(n) <= 0.01 && error(fewer) > 0.01, "{n}");
    let PassesNeeded::Passes(n) = forecast.passes_to_reach(0.001) else { panic!("it can be reached") };
    // Groups of passes agree with single passes to 0.5 %.
    assert!(n > 100_000 && (error(n) / 0.001 - 1.0).abs() < 0.005, "{n} {}", error(n));
}
