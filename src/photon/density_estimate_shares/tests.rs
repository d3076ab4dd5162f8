//! Division of flux between density estimates and splats.

use super::blur_map::BlurSums;
use super::*;
use crate::color::Rgb;
use rand::{RngExt, SeedableRng, rngs::SmallRng};

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
    DensityEstimateShares::from_splats(&splats(count), SIZE, ratio, 50.0)
}

/// Returns about `per_pixel` splats per pixel of equal value at random positions.
fn random_splats(per_pixel: f64, seed: u64) -> Vec<Splat> {
    let (width, height) = SIZE;
    let mut rng = SmallRng::seed_from_u64(seed);
    let count = (per_pixel * f64::from(width * height)) as u32;
    (0..count).map(|_| splat_at(rng.random::<f32>() * width as f32, rng.random::<f32>() * height as f32)).collect()
}

/// Returns the ratio of splat flux to density-estimate flux in the first pass, in column `x` of the
/// middle row.
fn ratio_at(shares: &DensityEstimateShares, x: usize) -> f32 {
    let FluxRatio { noise, blur } = shares.first_pass_ratios[16 * SIZE.0 as usize + x];
    noise + blur
}

/// Where photons are uniform, density estimates do not blur. The ratio of splats to density
/// estimates is then n/50 + (n/10)² with n photons per pixel. The first term grows as the power ⅓
/// of the pass, and the second as the power ⅔.
#[test]
fn uniform_light_needs_many_photons_for_splats() {
    for (count, ratio) in [(1, 1.0), (4, 0.5), (5, 2.0), (9, 10.0)] {
        let n = f64::from(count) * ratio;
        let expected = [n / 50.0, n * n / 100.0];
        for FluxRatio { noise, blur } in shares(|_, _| count, ratio).first_pass_ratios {
            for (found, expected) in [noise, blur].into_iter().zip(expected) {
                assert!((f64::from(found) / expected - 1.0).abs() < 1e-6, "{n}: {found} instead of {expected}");
            }
        }
    }
    let step =
        |ratio: f64, pass: u32| shares(|_, _| 1, ratio).in_pass(pass).share_steps_at_film_position(Vec2::new(6.0, 4.0));
    // n = 9 gives the ratio 0.18 + 0.81. In the eighth pass, it is 2·0.18 + 4·0.81 = 3.6. n = 1
    // gives 0.02 + 0.01, and in pass 512 8·0.02 + 64·0.01 = 0.8.
    assert_eq!((step(0.01, 0), step(9.0, 0), step(9.0, 7), step(500.0, 0)), (15, 8, 3, 0));
    assert_eq!(step(1.0, 511), 8);
    assert!(shares(|_, _| 0, 1.0).first_pass_ratios.iter().all(|ratio| *ratio == FluxRatio::default()));
}

/// The noise of few splats in a pilot does not count as blur. In uniform light, let a pass have one
/// photon per pixel, and the pilot a quarter. The ratio of splats to density estimates is then 0.03
/// without noise, 1/50 for noise and 1/100 for a focus. The mean ratio exceeds this value by less
/// than half; noise that counted as blur would make it 0.2.
#[test]
fn pilot_noise_hardly_raises_the_share_of_splats() {
    let ratios: Vec<f64> = (0..20)
        .flat_map(|seed| {
            DensityEstimateShares::from_splats(&random_splats(0.25, seed), SIZE, 4.0, 50.0).first_pass_ratios
        })
        .map(|FluxRatio { noise, blur }| f64::from(noise + blur))
        .collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!((0.03..0.045).contains(&mean), "{mean}");
}

/// Density estimates blur a bright line. So splats carry more of the flux on the line and near it
/// than in uniform light with as many photons per pixel. Far from the line, uniform light keeps its
/// small share of splats.
#[test]
fn splats_carry_more_flux_where_light_is_blurred() {
    let line = shares(|x, _| if x == 8 { 40 } else { 4 }, 0.25);
    let (dim, bright) = (shares(|_, _| 4, 0.25), shares(|_, _| 40, 0.25));
    assert!(ratio_at(&line, 8) > 3.0 * ratio_at(&bright, 8), "{} {}", ratio_at(&line, 8), ratio_at(&bright, 8));
    assert!(ratio_at(&line, 4) > 5.0 * ratio_at(&dim, 4), "{} {}", ratio_at(&line, 4), ratio_at(&dim, 4));
    assert!(ratio_at(&line, 40) < 1.01 * ratio_at(&dim, 40), "{} {}", ratio_at(&line, 40), ratio_at(&dim, 40));
}

/// Few splats give even counts, because larger squares are counted where splats are few: with one
/// splat in 20 pixels, each square holds at least 14 on average. Counts would be 0 in most squares
/// of 3 × 3 pixels, and 0.11 or more in the others. The splats are the same in each run.
#[test]
fn few_splats_give_even_counts() {
    let image = SplatImage::new(&random_splats(0.05, 3), SIZE);
    let counts: Vec<f64> = (0..image.sums.len()).map(|pixel| image.splats_per_pixel(pixel)).collect();
    assert!(counts.iter().all(|count| (0.01..0.15).contains(count)), "{counts:?}");
}

/// Discs are represented by squares with the same area, from 3 × 3 to 25 × 25 pixels.
#[test]
fn squares_of_discs_have_their_area() {
    let half_widths = [0.0, 1.0, 9.0, 49.0, 50.0, 441.0, 1e9, f64::INFINITY].map(disc_half_width);
    assert_eq!(half_widths, [1, 1, 1, 3, 3, 10, 12, 12]);
}

/// Shares have no edges, even where light has one. With one photon per pixel, they are averaged
/// over the 7 × 7 pixels of a disc, so the logarithm of the ratio changes by about a seventh of its
/// range from pixel to pixel.
#[test]
fn shares_change_gradually_at_edges_of_light() {
    let shares = shares(|x, _| if x < 24 { 4 } else { 0 }, 0.25);
    let logarithms: Vec<f32> = (0..48).map(|x| ratio_at(&shares, x).ln_1p()).collect();
    let range = logarithms.iter().fold(0.0f32, |largest, value| largest.max(*value));
    let step = logarithms.windows(2).fold(0.0f32, |largest, pair| largest.max((pair[0] - pair[1]).abs()));
    assert!(range > 0.02 && step < 0.2 * range, "{step} of {range}");
}

/// One splat that is brighter than all others together hardly changes the blur of the film: by less
/// than a fifth, for these splats. If it counted by its light, the blur would be that of its block
/// alone.
#[test]
fn one_bright_splat_hardly_changes_the_blur_of_the_film() {
    let is_bright = |splat: &Splat| splat.film_position.x % 8.0 < 2.0;
    let stripes: Vec<Splat> = random_splats(8.0, 1).into_iter().filter(is_bright).collect();
    let blur = |splats: &[Splat]| {
        let image = SplatImage::new(splats, SIZE);
        BlurMap::new(&image, &vec![2; image.sums.len()]).film
    };
    let before = blur(&stripes);
    let bright = Splat { integrated_radiance: Rgb::splat(1e5), ..splat_at(4.5, 4.5) };
    let after = blur(&[&stripes[..], &[bright]].concat());
    assert!(before > 0.2 && (after / before - 1.0).abs() < 0.2, "{before} becomes {after}");
}

/// Estimates of blur are unbiased: for uniform light with few random splats, their mean over many
/// pilots is 0 within five standard errors. Their sample variance agrees with the variance that
/// they report, within five standard errors √(2/399) of a variance of 400 values.
#[test]
fn blur_of_uniform_light_is_zero_within_its_error() {
    let estimates: Vec<(f64, f64)> = (0..400)
        .map(|seed| {
            let image = SplatImage::new(&random_splats(0.2, seed), SIZE);
            let blurs = BlurMap::new(&image, &vec![7; image.sums.len()]);
            let mut sums = BlurSums::default();
            blurs.blocks.iter().for_each(|block| sums += *block);
            sums.estimate()
        })
        .collect();
    let count = estimates.len() as f64;
    let mean = estimates.iter().map(|(blur, _)| blur).sum::<f64>() / count;
    let variance = estimates.iter().map(|(blur, _)| (blur - mean) * (blur - mean)).sum::<f64>() / (count - 1.0);
    let reported = estimates.iter().map(|(_, error)| error * error).sum::<f64>() / count;
    assert!(mean.abs() < 5.0 * (variance / count).sqrt(), "{mean} ± {}", (variance / count).sqrt());
    let tolerance = 5.0 * (2.0 / (count - 1.0)).sqrt();
    assert!((variance / reported - 1.0).abs() < tolerance, "{reported} instead of {variance}");
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
