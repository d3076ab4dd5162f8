//! Division of flux between density estimates and splats.

use super::*;
use crate::color::Rgb;

const SIZE: (u32, u32) = (48, 32);

fn splat_at(x: f32, y: f32) -> Splat {
    Splat { film_position: Vec2::new(x, y), integrated_radiance: Rgb::new(1.0, 2.0, 3.0) }
}

/// Returns `count(x, y)` splats at the center of each pixel.
fn splats(count: impl Fn(u32, u32) -> u32) -> Vec<Splat> {
    let (width, height) = SIZE;
    let pixels = (0..width * height).map(|i| (i % width, i / width));
    pixels.flat_map(|(x, y)| (0..count(x, y)).map(move |_| splat_at(x as f32 + 0.5, y as f32 + 0.5))).collect()
}

fn shares(count: impl Fn(u32, u32) -> u32, ratio: f64) -> DensityEstimateShares {
    DensityEstimateShares::from_splats(&splats(count), SIZE, ratio)
}

/// Where photons are uniform, density estimates do not blur. The ratio of splats to density
/// estimates is then n/50 + (n/10)² with n photons per pixel, and grows as the power ⅔ of the pass.
#[test]
fn uniform_light_needs_many_photons_for_splats() {
    for (count, ratio) in [(1, 1.0), (4, 0.5), (5, 2.0), (9, 10.0)] {
        let n = f64::from(count) * ratio;
        let expected = (n / 50.0 + n * n / 100.0) as f32;
        for found in shares(|_, _| count, ratio).first_pass_ratios {
            assert!((found / expected - 1.0).abs() < 1e-6, "{n}: {found} instead of {expected}");
        }
    }
    let step =
        |ratio: f64, pass: u32| shares(|_, _| 1, ratio).in_pass(pass).share_steps_at_film_position(Vec2::new(6.0, 4.0));
    // n = 9 gives the ratio 0.99. In the eighth pass, it is 8^(2/3) = 4 times as large.
    assert_eq!((step(0.01, 0), step(9.0, 0), step(9.0, 7), step(500.0, 0)), (15, 8, 3, 0));
    assert!(shares(|_, _| 0, 1.0).first_pass_ratios.iter().all(|ratio| *ratio == 0.0));
}

/// A bright line is blurred by density estimates, so splats carry more of its flux than in uniform
/// light with as many photons per pixel. Far from the line, uniform light keeps its small share of
/// splats but for the weight of the whole film.
#[test]
fn splats_carry_more_flux_where_light_is_blurred() {
    let line = shares(|x, _| if x == 8 { 40 } else { 4 }, 0.25);
    let uniform = shares(|_, _| 4, 0.25);
    let at = |shares: &DensityEstimateShares, x: usize| shares.first_pass_ratios[16 * 48 + x];
    assert!(at(&line, 8) > 5.0 * at(&shares(|_, _| 40, 0.25), 8).min(10.0), "{}", at(&line, 8));
    assert!(at(&line, 4) > 5.0 * at(&uniform, 4), "{}", at(&line, 4));
    assert!(at(&line, 40) < 0.5 * at(&line, 4), "{} {}", at(&line, 40), at(&line, 4));
}

/// Blur is measured free of the noise of the pilot: for uniform light with few random splats, its
/// mean over many pilots is 0 within five standard errors.
#[test]
fn pilot_noise_does_not_count_as_blur() {
    use rand::{RngExt, SeedableRng, rngs::SmallRng};
    let mut rng = SmallRng::seed_from_u64(7);
    let estimates: Vec<f64> = (0..400)
        .map(|_| {
            let (width, height) = SIZE;
            let random: Vec<Splat> = (0..300)
                .map(|_| splat_at(rng.random::<f32>() * width as f32, rng.random::<f32>() * height as f32))
                .collect();
            let image = SplatImage::new(&random, SIZE);
            let blurs = BlurMap::new(&image, &vec![0.2; image.sums.len()]);
            let mut sums = BlurSums::default();
            blurs.blocks.iter().for_each(|block| sums += *block);
            sums.squared_differences / sums.squared_means
        })
        .collect();
    let mean = estimates.iter().sum::<f64>() / estimates.len() as f64;
    let variance = estimates.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (estimates.len() - 1) as f64;
    let error = (variance / estimates.len() as f64).sqrt();
    assert!(mean.abs() < 5.0 * error, "{mean} ± {error}");
    assert!(error < 0.01, "{error}");
}

/// Light tracing alone leaves nothing to density estimates on the film. Photons outside the film
/// cannot be splatted.
#[test]
fn all_to_splats_leaves_nothing_on_the_film() {
    let shares = DensityEstimateShares::all_to_splats(SIZE);
    let share = |x, y| shares.in_pass(3).share_steps_at_film_position(Vec2::new(x, y));
    assert_eq!((share(47.9, 31.9), share(48.0, 1.0)), (0, 15));
}

/// A photon stores the fraction of its flux that density estimates use. Storing it changes the flux
/// by less than 10⁻⁵.
#[test]
fn photons_store_their_density_estimate_share() {
    use crate::photon::Photon;
    use glam::Vec3;
    let photon = Photon::new(Vec3::ONE, Rgb::new(0.2, 0.5, 0.3), Vec3::Z, Vec3::Z).unwrap();
    for steps in 0..=SHARE_STEPS {
        let data = photon.with_density_estimate_share(steps).attributes;
        assert!((data.density_estimate_share() - f32::from(steps) / 15.0).abs() < 1e-6);
        assert!((data.flux() - photon.attributes.flux()).length() < 2e-6);
    }
}
