use super::*;
use crate::render::error_estimate::ErrorEstimate;

/// Confidence so small that the error interval has practically no width. Tests with it compare the
/// target with the estimated error itself.
const CENTER: Confidence = Confidence::LEAST;

/// Returns the forecast after 8 passes with the given moments of nested differences. Each pass has
/// relative variance 0.08, so the noise is 0.1.
fn forecast_with(differences: NestedDifferenceMoments, alpha: Option<f64>) -> ErrorForecast {
    let blur = BlurEstimate::from_differences(&differences);
    let parts = SquaredErrorParts {
        noise: 0.01,
        blur: blur.squared_blur,
        blur_variance: blur.squared_blur_variance,
        ..Default::default()
    };
    let estimate = ErrorEstimate {
        passes: 8,
        error: parts.total().sqrt(),
        blur: blur.squared_blur.sqrt(),
        half_area_blur_ratio: if blur.half_area_blur_ratio > 0.0 { blur.half_area_blur_ratio } else { 0.5 },
        parts,
        difference_moments: differences,
        ..ErrorEstimate::default()
    };
    ErrorForecast::new(estimate, alpha.map(|alpha| (alpha, 0.5)))
}

fn range(forecast: StopForecast) -> PassRange {
    let StopForecast::Passes(range) = forecast else { panic!("{forecast:?}") };
    range
}

/// Moments of smooth light with the blur 2·√`d0_squared`, measured without noise.
fn smooth(d0_squared: f64) -> NestedDifferenceMoments {
    NestedDifferenceMoments { d0_squared, d0_d1: 0.5 * d0_squared, d1_squared: 0.25 * d0_squared, ..Default::default() }
}

#[test]
fn normal_quantiles_match_tables() {
    for (probability, expected) in [(0.5, 0.0), (0.9, 1.281_552), (0.025, -1.959_964), (0.999, 3.090_232)] {
        assert!((normal_quantile(probability) - expected).abs() < 1e-5, "{probability}");
    }
}

#[test]
fn draws_are_spread_evenly() {
    let mean = |of: fn(&ForecastDraw) -> f64| ALL_DRAWS.iter().map(of).sum::<f64>() / DRAW_COUNT as f64;
    assert!(mean(|draw| draw.noise_variate).abs() < 0.05 && mean(|draw| draw.later_blur_variate).abs() < 0.05);
    assert!(
        (mean(|draw| draw.exponent_variate) - 0.5).abs() < 0.02 && (mean(|draw| draw.blur_variate) - 0.5).abs() < 0.02
    );
    assert!((mean(|draw| draw.noise_variate * draw.noise_variate) - 1.0).abs() < 0.1);
    assert!(mean(|draw| draw.noise_variate * draw.later_blur_variate).abs() < 0.1);
}

/// Half the noise needs four times as many passes: noise of 0.1 after 8 passes falls to 0.05 after
/// 32 passes. The uncertainty of the noise model widens the predicted range of passes.
#[test]
fn noise_alone_needs_four_times_the_passes() {
    let forecast = forecast_with(NestedDifferenceMoments::default(), None);
    let PassRange { low, median, high } = range(forecast.stop_forecast(0.05, CENTER));
    assert!((31..=34).contains(&median), "{median}");
    // The relative deviation of the noise variance is 0.2·¾ (`NOISE_MODEL_DEVIATION`, and ¾ of the
    // passes still to come). The tolerance includes the schedule of error estimates.
    let factor = libm::exp(1.2816 * 0.15);
    assert!((f64::from(low) * factor / 32.0 - 1.0).abs() < 0.08, "{low}");
    assert!((f64::from(high.unwrap()) / factor / 32.0 - 1.0).abs() < 0.08, "{high:?}");
}

/// With a wider interval, more passes are needed. The upper end of the interval is √(1 +
/// z·√uncertainty) times the error, for a half width of z standard deviations.
#[test]
fn forecast_uses_the_upper_end_of_the_interval() {
    let mut forecast = forecast_with(NestedDifferenceMoments::default(), None);
    forecast.estimate.parts.realised_noise_relative_variance = 0.04;
    let center = range(forecast.stop_forecast(0.05, CENTER)).median;
    let upper = range(forecast.stop_forecast(0.05, Confidence::new(0.8).unwrap())).median;
    let expected = 1.0 + 1.2816 * 0.2;
    assert!((f64::from(upper) / f64::from(center) / expected - 1.0).abs() < 0.06, "{upper} {center}");
}

/// If the passes made so far have reached a target, the forecast is at most their number.
#[test]
fn reached_targets_are_not_in_the_future() {
    let forecast = forecast_with(NestedDifferenceMoments::default(), None);
    let PassRange { low, median, high } = range(forecast.stop_forecast(0.1001, CENTER));
    assert!(MIN_ERROR_ESTIMATE_PASSES <= low && median <= 8 && high.unwrap() <= 8, "{low} {median} {high:?}");
    assert!(range(forecast.stop_forecast(0.5, CENTER)).high == Some(MIN_ERROR_ESTIMATE_PASSES));
    assert!(range(forecast.stop_forecast(0.0999, CENTER)).low > 8);
}

#[test]
fn fixed_radii_never_reach_targets_below_their_blur() {
    let forecast = forecast_with(smooth(1e-4), Some(1.0));
    assert_eq!(forecast.stop_forecast(0.019, CENTER), StopForecast::Never { floor: 0.02 });
    // The median solves 0.01·8/n + 0.02² = 0.03².
    let median = range(forecast.stop_forecast(0.03, CENTER)).median;
    assert!((155..=175).contains(&median), "{median}");
}

/// Blur falls more slowly at sharp edges, as n^(−1/12), than in smooth light, as n^(−1/3). So it
/// takes more passes to reach a target.
#[test]
fn blur_at_edges_decays_slowly() {
    let edge = |d0_squared: f64| NestedDifferenceMoments {
        d0_squared,
        d0_d1: 0.7275 * d0_squared,
        d1_squared: 0.707 * d0_squared,
        ..Default::default()
    };
    let [smooth, edge] = [smooth(0.25e-2), edge(0.01 / 14.6)].map(|differences| {
        let forecast = forecast_with(differences, Some(2.0 / 3.0));
        assert!((forecast.estimate.blur / 0.1 - 1.0).abs() < 0.02, "{}", forecast.estimate.blur);
        range(forecast.stop_forecast(0.08, CENTER)).median
    });
    assert!(edge > 2 * smooth, "{edge} {smooth}");
}

/// The predicted range of passes is wider if the blur is not measured exactly.
#[test]
fn unknown_blur_widens_the_range() {
    let known = forecast_with(NestedDifferenceMoments::default(), Some(2.0 / 3.0));
    let deviation = 2e-4;
    let noisy =
        NestedDifferenceMoments { d0_squared_variance: deviation * deviation, d0_variance: 0.01, ..Default::default() };
    let unknown =
        forecast_with(NestedDifferenceMoments { squared_noise_relative_variance: 0.02, ..noisy }, Some(2.0 / 3.0));
    let ends = [&known, &unknown].map(|forecast| range(forecast.stop_forecast(0.04, CENTER)));
    assert!(ends[1].median >= ends[0].median);
    let width = |range: &PassRange| f64::from(range.high.unwrap_or(u32::MAX)) / f64::from(range.low);
    assert!(width(&ends[1]) > 1.3 * width(&ends[0]), "{ends:?}");
}

#[test]
fn distant_targets_have_no_forecast() {
    let forecast = forecast_with(NestedDifferenceMoments::default(), None);
    assert_eq!(forecast.stop_forecast(1e-6, CENTER), StopForecast::TooFar { at_least: 8000 });
}
