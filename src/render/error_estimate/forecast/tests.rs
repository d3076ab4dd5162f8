use super::*;
use crate::integrate::squared_radius_ratio;
use crate::render::error_estimate::blur::NestedDifferenceMoments;
use crate::render::error_estimate::disc_area_sums::GROUP_DIVISOR;
use crate::render::error_estimate::fireflies::FireflyHistogram;
use crate::render::error_estimate::squared_error::SquaredErrorParts;

fn error_estimate_with_parts(
    passes: u32,
    variance: f64,
    difference_variance: f64,
    blur: f64,
    blur_ratio: f64,
) -> ErrorEstimate {
    let parts = SquaredErrorParts { noise: variance / f64::from(passes), blur: blur * blur, ..Default::default() };
    let differences = NestedDifferenceMoments { d0_variance: difference_variance, ..Default::default() };
    ErrorEstimate {
        passes,
        blur,
        half_area_blur_ratio: blur_ratio,
        parts,
        difference_moments: differences,
        ..ErrorEstimate::default()
    }
}

fn noise_and_bias_after_passes(forecast: &ErrorForecast, passes: u32) -> (f64, f64) {
    forecast.noise_and_bias(&DiscAreaSums::of_passes(forecast.alpha, forecast.blur_exponent, passes))
}

/// With more passes, fireflies first become more numerous and then fade.
///
/// A tenth of the pixels are fireflies of relative squared noise 16. Beyond four times as many
/// passes, each contributes less than 1.
#[test]
fn firefly_error_grows_before_it_falls() {
    let mut fireflies = FireflyHistogram::default();
    (0..10).for_each(|_| fireflies.add(16.0, 0.01));
    let forecast =
        ErrorForecast::new(ErrorEstimate { fireflies, ..error_estimate_with_parts(8, 8.0 * 0.1, 0.0, 0.0, 0.5) }, None);
    let noise2 = |n: u32| libm::pow(noise_and_bias_after_passes(&forecast, n).0, 2.0);
    for (n, expected) in [(8, 0.1), (16, 0.2), (32, 0.4), (64, 0.2), (8 * 160, 0.01)] {
        // Brightness is stored to half an octave.
        assert!(libm::log2(noise2(n) / expected).abs() < 0.5 + 1e-9, "{n}: {} {expected}", noise2(n));
    }
}

/// Noise without bias falls as 1/√n.
///
/// If one pass has variance 0.04, the error is 0.1 after 4 passes and 0.01 after 400 passes.
#[test]
fn noise_alone_falls_as_the_root_of_passes() {
    let forecast = ErrorForecast::new(error_estimate_with_parts(4, 0.04, 0.0, 0.0, 0.5), None);
    assert!((forecast.error_after_passes(4) - 0.1).abs() < 1e-12);
    assert_eq!(forecast.passes_to_reach_noise(0.01), Some(400));
    assert_eq!(forecast.passes_to_reach_noise(1e-9), None);
    assert_eq!(forecast.bias_floor(), None);
}

#[test]
fn fixed_radii_leave_a_bias_floor() {
    let forecast = ErrorForecast::new(error_estimate_with_parts(10, 0.04, 0.01, 0.02, 0.5), Some((1.0, 0.5)));
    assert_eq!(forecast.bias_floor(), Some(0.02));
    assert!((forecast.error_after_passes(178) - 0.025).abs() < 1e-5);
    let shrinking = ErrorForecast::new(error_estimate_with_parts(10, 0.04, 0.01, 0.02, 0.5), Some((0.5, 0.5)));
    assert_eq!(shrinking.bias_floor(), None);
}

#[test]
fn blur_does_not_remain_if_radii_shrink() {
    let largest = |alpha, shared_paths, clamping| {
        let blurred = error_estimate_with_parts(10, 0.04, 0.01, 0.03, 0.5);
        let estimate = ErrorEstimate { shared_paths, clamping, ..blurred };
        ErrorForecast::new(estimate, Some((alpha, 0.5))).largest_remaining_bias()
    };
    assert_eq!(largest(1.0, 0.01, 0.02), Some(BiasPart::Blur));
    assert_eq!(largest(0.5, 0.01, 0.02), Some(BiasPart::Clamping));
    assert_eq!(largest(0.5, 0.02, 0.01), Some(BiasPart::SharedPaths));
    assert_eq!(largest(0.5, 0.0, 0.0), None);
}

/// With shrinking gather radii, noise and bias fall as n^(−1/3) if all noise comes from photon
/// estimates (Knaus and Zwicker 2011).
#[test]
fn shrinking_radii_follow_their_law() {
    let alpha = 2.0 / 3.0;
    let forecast = ErrorForecast::new(error_estimate_with_parts(8, 0.04, 0.02, 0.02, 0.5), Some((alpha, 0.5)));
    let mean = |n: u32, power: f64| {
        (0..n).map(|i| libm::pow(squared_radius_ratio(alpha, i), power)).sum::<f64>() / f64::from(n)
    };
    let after = |n: u32| noise_and_bias_after_passes(&forecast, n);
    let (noise, bias) = after(64);
    let expected = 0.04 / 8.0 * (mean(64, -1.0) / 64.0) / (mean(8, -1.0) / 8.0);
    assert!((noise * noise / expected - 1.0).abs() < 1e-9, "{noise}");
    assert!((bias / (0.02 * mean(64, 1.0) / mean(8, 1.0)) - 1.0).abs() < 1e-9, "{bias}");
    let slope = |f: fn((f64, f64)) -> f64| libm::log10(f(after(1_000_000)) / f(after(100_000)));
    assert!((slope(|e| e.0) + 1.0 / 3.0).abs() < 1e-3 && (slope(|e| e.1) + 1.0 / 3.0).abs() < 1e-3);
    for target in [0.01, 0.001] {
        let n = forecast.passes_to_reach_noise(target).unwrap();
        assert!(after(n).0 <= target && after(n - n / GROUP_DIVISOR - 1).0 > target, "{n}");
    }
}

/// Sums over groups of passes agree with sums over single passes to 10⁻³.
#[test]
fn sums_over_groups_agree_with_single_passes() {
    for power in [0.25, 1.0] {
        let sums = DiscAreaSums::of_passes(2.0 / 3.0, power, 20_000);
        let areas = (0..20_000).scan(1.0, |area, i| {
            let this = *area;
            *area *= (f64::from(i) + 1.0 + 2.0 / 3.0) / (f64::from(i) + 2.0);
            Some(this)
        });
        let (inverse, blur) = areas.fold((0.0, 0.0), |(a, b), x: f64| (a + 1.0 / x, b + libm::pow(x, power)));
        assert!((sums.inverse_area_sum / inverse - 1.0).abs() < 1e-3, "{} {inverse}", sums.inverse_area_sum);
        assert!((sums.area_power_sum / blur - 1.0).abs() < 1e-3, "{} {blur}", sums.area_power_sum);
        assert_eq!(sums.passes, 20_000);
    }
}
