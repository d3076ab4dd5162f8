//! Gauges of passes whose error is known.

use super::*;
use crate::color::Rgb;
use crate::photon::Kernel;
use crate::sampling::{Dimension, Key, Purpose};

const WIDTH: u32 = 40;
const PIXELS: usize = 1600;
const LAW: RadiusLaw = RadiusLaw { alpha: 1.0, kernel: Kernel::Epanechnikov };

/// Noise of variance 1, uniform: 12 to the half times what is drawn about its middle.
fn noise(pass: u32, seed: u64, pixel: usize, which: u64) -> f32 {
    let key = Key::new(seed).purpose(Purpose::Test).with(u64::from(pass) << 32 | pixel as u64).with(which);
    (key.uniform(Dimension::Film) - 0.5) * 12f32.sqrt()
}

/// Passes of a picture of light 1 (weights ½) with noise of `sigma` and smooth bias b, whose steps b/2 and b/4 have noise too.
fn gauged(passes: u32, seed: u64, sigma: f32, bias: f32) -> (ErrorEstimator, Film) {
    let (mut gauge, mut film) = (ErrorEstimator::new(Some(LAW)), Film::new(WIDTH, WIDTH));
    for i in 0..passes {
        let part = |pixel: usize, which: u64| Rgb::splat(sigma * noise(i, seed, pixel, which));
        let pixel = |p: usize| NestedEstimates {
            steps: [Rgb::splat(0.5 * bias) + part(p, 1), Rgb::splat(0.25 * bias) + part(p, 2)],
            ..NestedEstimates::default()
        };
        let image = (0..PIXELS).map(|p| Rgb::splat(1.0 + bias) + part(p, 0)).collect();
        let pass = Pass { image, nested: (0..PIXELS).map(pixel).collect(), ..Pass::default() };
        gauge.add(&film, &pass);
        film.add(&pass.image);
    }
    (gauge, film)
}

#[test]
fn nothing_is_known_of_three_passes() {
    let (gauge, film) = gauged(3, 1, 0.1, 0.0);
    let reading = gauge.read(&film);
    assert!(reading.error.is_infinite() && reading.high.is_infinite() && reading.low == 0.0);
    assert!(gauge.forecast(&reading).is_none());
}

/// Relative to √2: noise is σ/√(2n), bias b/√2 of light 1 (the scale knows the light with its bias: 1 + b).
#[test]
fn noise_and_bias_are_told_apart() {
    for (sigma, bias) in [(0.3, 0.0), (0.3, 0.1), (0.01, 0.1)] {
        let (gauge, film) = gauged(16, 2, sigma, bias);
        let reading = gauge.read(&film);
        let unit = f64::from(1.0 + bias) * 2f64.sqrt();
        let expected = f64::from(sigma) / 4.0 / unit;
        // A variance from 1600 · 15 values is known to √(2/24,000); weights see the noise of 25 pixels.
        assert!((reading.noise / expected - 1.0).abs() < 0.02, "{} {expected}", reading.noise);
        let expected = f64::from(bias) / unit;
        // ‖D₀‖² is known to σ²/n √(2/1600), and the blur is twice its root.
        let known = 4.0 * f64::from(sigma * sigma) / 16.0 * (2.0 / 1600f64).sqrt() / (unit * unit);
        let off = (reading.blur * reading.blur - expected * expected).abs();
        assert!(off < 5.0 * known + 0.1 * expected * expected, "{} {expected}", reading.blur);
        assert!(reading.error >= reading.low && reading.error <= reading.high);
        let square = reading.noise * reading.noise + reading.bias * reading.bias;
        assert!((reading.error * reading.error - square).abs() < 1e-12);
    }
}

/// The true squared error of each of 200 pictures, against the intervals that each tells.
#[test]
fn intervals_hold_the_true_error() {
    let (mut held, pictures) = (0, 200);
    for seed in 0..pictures {
        let (gauge, film) = gauged(8, 100 + seed, 0.3, 0.0);
        let reading = gauge.read(&film);
        let scale = RelativeScale::of_pixels(film.size(), &[Rgb::ONE; PIXELS]);
        let mean = film.mean();
        let error = scale.mean(|i| (mean[i] - Rgb::ONE).as_dvec3() * (mean[i] - Rgb::ONE).as_dvec3()).sqrt();
        held += i32::from(reading.low <= error && error <= reading.high);
    }
    // 90 % of 200, less three deviations of a binomial.
    assert!(held >= 180 - 13, "{held}");
}

/// Walks that stay are wrong by .2 at each of 16 pixels that are looked at, and fresh ones by noise.
#[test]
fn shared_walks_are_bias() {
    let (mut gauge, mut film) = (ErrorEstimator::new(None), Film::new(WIDTH, WIDTH));
    for i in 0..32 {
        let image = vec![Rgb::splat(1.2); PIXELS];
        let fresh = (0..16).map(|p| (p as u32 * 100, Rgb::splat(1.0 + 0.1 * noise(i, 3, p, 0)))).collect();
        let pass = Pass { image, fresh, ..Pass::default() };
        gauge.add(&film, &pass);
        film.add(&pass.image);
    }
    let reading = gauge.read(&film);
    // .1/√32 a pixel, over 16 pixels.
    let expected = 0.2 / 1.2 / 2f64.sqrt();
    assert!((reading.frozen / expected - 1.0).abs() < 5.0 * 0.1 / (32f64 * 16.0).sqrt() / 0.2, "{}", reading.frozen);
    assert!(reading.noise == 0.0 && reading.blur == 0.0 && reading.bias == reading.frozen);
}

/// What a step edge blurred by Epanechnikov's kernel lacks, and what the extrapolation makes of its first two steps: an error of a third
/// would be twice the interval's reach.
#[test]
fn edges_are_not_taken_for_smooth_light() {
    // The integral of the kernel over x < t, for a disc of radius 1: its marginal is (8/(3π))(1 − x²)^{3/2}.
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
    let (mut gauge, mut film) = (ErrorEstimator::new(Some(LAW)), Film::new(WIDTH, WIDTH));
    for _ in 0..8 {
        let splat = |v: f64| Rgb::splat(v as f32);
        let pixel = |v: &[f64; 4]| NestedEstimates {
            steps: [splat(v[0] - v[1]), splat(v[1] - v[2])],
            ..NestedEstimates::default()
        };
        let image = row.iter().map(|v| splat(v[0])).collect();
        let pass = Pass { image, nested: row.iter().map(pixel).collect(), ..Pass::default() };
        gauge.add(&film, &pass);
        film.add(&pass.image);
    }
    let reading = gauge.read(&film);
    let scale = RelativeScale::of_pixels(film.size(), &film.mean());
    let error = scale.mean(|i| DVec3::splat((row[i][0] - row[i][3]) * (row[i][0] - row[i][3]))).sqrt();
    assert!(reading.low <= error && error <= reading.high, "{reading:?} {error}");
    assert!((reading.blur / error - 1.0).abs() < 0.25, "{} {error}", reading.blur);
    // Smooth light would be told 2 ‖D₀‖.
    let smooth = 2.0 * scale.mean(|i| DVec3::splat((row[i][0] - row[i][1]) * (row[i][0] - row[i][1]))).sqrt();
    assert!(smooth < 0.75 * error, "{smooth} {error}");
}
