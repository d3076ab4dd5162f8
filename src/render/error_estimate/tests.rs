//! Tests of error estimates, on synthetic passes whose error is known.

use super::{ErrorEstimator, MIN_ERROR_ESTIMATE_PASSES};
use crate::color::Rgb;
use crate::image::RelativeErrorWeights;
use crate::integrate::{NestedDifferences, PassResult, RadiusLaw};
use crate::photon::Kernel;
use crate::render::Film;
use crate::sampling::{Dimension, Key, Purpose};
use glam::DVec3;

const WIDTH: u32 = 40;
const PIXELS: usize = 1600;
const LAW: RadiusLaw = RadiusLaw { alpha: 1.0, kernel: Kernel::Epanechnikov };

/// Returns a uniformly distributed random number of mean 0 and variance 1. `which` selects one of
/// several numbers of a pixel.
fn uniform_noise(pass: u32, seed: u64, pixel: usize, which: u64) -> f32 {
    let key =
        Key::new(seed).purpose_key(Purpose::Test).child_key(u64::from(pass) << 32 | pixel as u64).child_key(which);
    (key.uniform_1d(Dimension::Film) - 0.5) * 12f32.sqrt()
}

/// Makes passes of radiance 1 with noise `sigma` and smooth bias b, and adds them to an estimator.
///
/// The differences D₀ = b/2 and D₁ = b/4 between nested estimates are noisy too.
fn render_noisy_passes(passes: u32, seed: u64, sigma: f32, bias: f32) -> (ErrorEstimator, Film) {
    let (mut estimator, mut film) = (ErrorEstimator::new(Some(LAW)), Film::new(WIDTH, WIDTH));
    for i in 0..passes {
        let part = |pixel: usize, which: u64| Rgb::splat(sigma * uniform_noise(i, seed, pixel, which));
        let pixel = |p: usize| NestedDifferences {
            differences: [Rgb::splat(0.5 * bias) + part(p, 1), Rgb::splat(0.25 * bias) + part(p, 2)],
            ..NestedDifferences::default()
        };
        let image = (0..PIXELS).map(|p| Rgb::splat(1.0 + bias) + part(p, 0)).collect();
        let pass = PassResult { image, nested: (0..PIXELS).map(pixel).collect(), ..PassResult::default() };
        estimator.add(i, &pass);
        film.add(&pass.image);
    }
    (estimator, film)
}

#[test]
fn three_passes_give_no_estimate() {
    let (estimator, film) = render_noisy_passes(MIN_ERROR_ESTIMATE_PASSES - 1, 1, 0.1, 0.0);
    let estimate = estimator.estimate(&film);
    assert!(estimate.error.is_infinite() && estimate.high.is_infinite() && estimate.low == 0.0);
    assert!(estimator.forecast(&estimate).is_none());
}

/// The estimated noise is near σ/√(2n), and the estimated bias near b/√2. Both are relative to the
/// radiance without bias, which is 1.
#[test]
fn noise_and_bias_are_separated() {
    for (sigma, bias) in [(0.3, 0.0), (0.3, 0.1), (0.01, 0.1)] {
        let (estimator, film) = render_noisy_passes(16, 2, sigma, bias);
        let estimate = estimator.estimate(&film);
        let unit = 2f64.sqrt();
        // The variance of 1600 · 15 values has a relative error of √(2/24,000). The weights average
        // 25 pixels, which adds their noise. The noise is relative to the radiance without
        // estimated blur, so it has the error of this estimate too.
        let noise = f64::from(sigma) / 4.0 / unit;
        let expected = f64::from(bias) / unit;
        let tolerance = 0.02 + unit * (estimate.blur - expected).abs();
        assert!((estimate.noise / noise - 1.0).abs() < tolerance, "{} {noise}", estimate.noise);
        // The standard error of ‖D₀‖² is σ²/n √(2/1600); blur is twice its root.
        let known = 4.0 * f64::from(sigma * sigma) / 16.0 * (2.0 / 1600f64).sqrt() / (unit * unit);
        let off = (estimate.blur * estimate.blur - expected * expected).abs();
        assert!(off < 5.0 * known + 0.1 * expected * expected, "{} {expected}", estimate.blur);
        assert!(estimate.error >= estimate.low && estimate.error <= estimate.high);
        let square = estimate.noise * estimate.noise + estimate.bias * estimate.bias;
        assert!((estimate.error * estimate.error - square).abs() < 1e-12);
    }
}

/// A caustic that is blurred to twice its radiance has an error relative to its true radiance.
#[test]
fn errors_are_relative_to_the_picture_without_blur() {
    let (estimator, film) = render_noisy_passes(16, 3, 0.0, 1.0);
    let estimate = estimator.estimate(&film);
    assert!((estimate.blur - 0.5f64.sqrt()).abs() < 1e-6, "{}", estimate.blur);
}

/// The 90 % intervals of 200 pictures contain the true error about as often as they should.
#[test]
fn intervals_contain_the_true_error() {
    let (mut held, pictures) = (0, 200);
    for seed in 0..pictures {
        let (estimator, film) = render_noisy_passes(8, 100 + seed, 0.3, 0.0);
        let estimate = estimator.estimate(&film);
        let error_weights = RelativeErrorWeights::from_pixels(film.size(), &[Rgb::ONE; PIXELS]);
        let mean = film.mean_picture();
        let error = error_weights
            .mean_relative_squared_error(|i| (mean[i] - Rgb::ONE).as_dvec3() * (mean[i] - Rgb::ONE).as_dvec3())
            .sqrt();
        held += i32::from(estimate.low <= error && error <= estimate.high);
    }
    // The bound is 90 % of 200, less three standard deviations of the binomial distribution.
    assert!(held >= 180 - 13, "{held}");
}

/// The error of shared paths is reported as bias. Here it is 0.2 at each of 16 pixels; unshared
/// paths have only noise.
#[test]
fn shared_path_errors_count_as_bias() {
    let (mut estimator, mut film) = (ErrorEstimator::new(None), Film::new(WIDTH, WIDTH));
    for i in 0..32 {
        let image = vec![Rgb::splat(1.2); PIXELS];
        let unshared_path_pixels =
            (0..16).map(|p| (p as u32 * 100, Rgb::splat(1.0 + 0.1 * uniform_noise(i, 3, p, 0)))).collect();
        let pass = PassResult { image, unshared_path_pixels, ..PassResult::default() };
        estimator.add(i, &pass);
        film.add(&pass.image);
    }
    let estimate = estimator.estimate(&film);
    // The noise of a pixel by unshared paths is 0.1/√32, and 16 pixels are averaged.
    let expected = 0.2 / 1.2 / 2f64.sqrt();
    assert!(
        (estimate.shared_paths / expected - 1.0).abs() < 5.0 * 0.1 / (32f64 * 16.0).sqrt() / 0.2,
        "{}",
        estimate.shared_paths
    );
    assert!(estimate.noise == 0.0 && estimate.blur == 0.0 && estimate.bias == estimate.shared_paths);
}

/// At a straight edge of light, blurred by the Epanechnikov kernel, the extrapolated bias agrees
/// with the true bias.
#[test]
fn edges_are_not_extrapolated_as_smooth() {
    // Integral of the kernel over x < t for a disc of radius 1; its marginal is (8/(3π))(1 −
    // x²)^{3/2}.
    let cumulative = |t: f64| {
        let steps = 400;
        let t = t.clamp(-1.0, 1.0);
        let h = (t + 1.0) / f64::from(steps);
        let density = |x: f64| 8.0 / (3.0 * std::f64::consts::PI) * libm::pow((1.0 - x * x).max(0.0), 1.5);
        (0..steps).map(|i| density(-1.0 + (f64::from(i) + 0.5) * h) * h).sum::<f64>()
    };
    let row: Vec<[f64; 4]> = (0..PIXELS)
        .map(|p| {
            let x = (f64::from(p as u32 % WIDTH) + 0.5) / f64::from(WIDTH) * 4.0 - 2.0;
            let at = |r: f64| cumulative(x / r);
            [at(1.0), at(0.5f64.sqrt()), at(0.5), if x > 0.0 { 1.0 } else { 0.0 }]
        })
        .collect();
    let (mut estimator, mut film) = (ErrorEstimator::new(Some(LAW)), Film::new(WIDTH, WIDTH));
    for i in 0..8 {
        let splat = |v: f64| Rgb::splat(v as f32);
        let pixel = |v: &[f64; 4]| NestedDifferences {
            differences: [splat(v[0] - v[1]), splat(v[1] - v[2])],
            ..NestedDifferences::default()
        };
        let image = row.iter().map(|v| splat(v[0])).collect();
        let pass = PassResult { image, nested: row.iter().map(pixel).collect(), ..PassResult::default() };
        estimator.add(i, &pass);
        film.add(&pass.image);
    }
    let estimate = estimator.estimate(&film);
    let error_weights = RelativeErrorWeights::from_pixels(film.size(), &film.mean_picture());
    let error = error_weights
        .mean_relative_squared_error(|i| DVec3::splat((row[i][0] - row[i][3]) * (row[i][0] - row[i][3])))
        .sqrt();
    assert!(estimate.low <= error && error <= estimate.high, "{estimate:?} {error}");
    assert!((estimate.blur / error - 1.0).abs() < 0.25, "{} {error}", estimate.blur);
    // The law of smooth light would give 2 ‖D₀‖.
    let smooth = 2.0
        * error_weights
            .mean_relative_squared_error(|i| DVec3::splat((row[i][0] - row[i][1]) * (row[i][0] - row[i][1])))
            .sqrt();
    assert!(smooth < 0.75 * error, "{smooth} {error}");
}
