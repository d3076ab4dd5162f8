//! Tests of coated diffuse surfaces: energy, selection of layers, and a random walk in the coat.

use super::rough::mean_sample_weights;
use super::*;
use rand::RngExt;

/// Returns the mean weights of samples of the separate coat and of `bsdf` itself.
///
/// Without a separate coat, the first is 0, and the second includes the coat.
fn layer_albedos(bsdf: Bsdf, wo: Vec3) -> (f64, f64) {
    let coat = bsdf.coat_if_separate().map_or(0.0, |coat| mean_sample_weights(&coat, wo).0);
    (coat, mean_sample_weights(&bsdf, wo).0)
}

#[test]
fn white_coated_surfaces_reflect_all_light() {
    for eta in [1.01, 1.5, 1.8, 3.3] {
        for alpha in [0.0, 0.01, 0.1, 0.3, 0.37, 1.0] {
            let bsdf = Bsdf::coated_diffuse(Rgb::ONE, eta, alpha, true);
            for cos in [1.0, 0.7, 0.3, 0.1, 0.02] {
                let (coat, base) = layer_albedos(bsdf, direction_with_cos(cos));
                // The first tolerance is the lattice's error at the horizon. The second adds the
                // error of tabulated albedos.
                let tolerance = if alpha == 0.0 { 3e-3 } else { 0.018 };
                assert!((coat + base - 1.0).abs() < tolerance, "{eta} {alpha} at {cos}: {coat} + {base}");
            }
        }
    }
}

/// The mean over `u` of the BSDFs that `select_layer` returns is the sum of base and coat.
#[test]
fn selected_layers_average_to_coat_plus_base() {
    let n = 4096;
    for (eta, alpha) in [(1.5, 0.0), (1.5, 0.2), (3.0, 0.05)] {
        let bsdf = Bsdf::coated_diffuse(Rgb::new(0.9, 0.4, 0.1), eta, alpha, true);
        let coat = bsdf.coat_if_separate().unwrap();
        for cos in [1.0, 0.4, 0.05] {
            let (wo, wi) = (direction_with_cos(cos), Vec3::new(-0.6, 0.1, 0.7).normalize());
            let f = |bsdf: Bsdf| bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Radiance);
            let mirrored = |bsdf: Bsdf| {
                let sample = bsdf.sample(wo, Vec3::Z, Vec3::Z, 0.5, Vec2::splat(0.3), TransportMode::Radiance);
                sample.filter(|_| bsdf.casts_caustics()).map_or(Rgb::ZERO, |sample| sample.weight)
            };
            let (mut mean, mut weight) = (Rgb::ZERO, Rgb::ZERO);
            for i in 0..n {
                let selected = bsdf.select_layer(wo, Vec3::Z, (i as f32 + 0.5) / n as f32);
                assert!(selected.stores_photons() != selected.casts_caustics());
                mean += f(selected) / n as f32;
                weight += mirrored(selected) / n as f32;
            }
            let expected = f(bsdf) + f(coat);
            // At the boundary between the layers, one of the 4096 values of `u` may select either.
            assert!((mean - expected).abs().max_element() < 2e-3 * expected.max_element(), "{mean} {expected}");
            assert!((weight - mirrored(coat)).abs().max_element() < 2e-3, "{weight} {}", mirrored(coat));
        }
    }
}

/// The closed form of a smooth coat agrees with random walks between coat and base: in the fraction
/// of walks that leave, and in the fraction that leave with a cosine above 0.7.
#[test]
fn coated_base_matches_random_walk() {
    let (eta, walks) = (1.5f32, 400_000);
    let mut rng = Key::new(29).purpose_key(Purpose::Test).rng();
    for (reflectance, cos) in [(0.2f32, 0.9f32), (0.9, 0.9), (0.5, 0.2)] {
        let entering = 1.0 - dielectric_reflectance_and_cosine(cos, eta).0;
        let (mut left, mut steep) = (0u32, 0u32);
        for _ in 0..walks {
            if rng.random::<f32>() >= entering {
                continue;
            }
            while rng.random::<f32>() < reflectance {
                // Cosine-weighted direction at the base.
                let cos_inside = rng.random::<f32>().sqrt();
                let (reflected, cos_outside) = dielectric_reflectance_and_cosine(cos_inside, 1.0 / eta);
                if rng.random::<f32>() >= reflected {
                    left += 1;
                    steep += u32::from(cos_outside > 0.7);
                    break;
                }
            }
        }
        let bsdf = Bsdf::coated_diffuse(Rgb::splat(reflectance), eta, 0.0, true);
        let wo = direction_with_cos(cos);
        let (mut all, mut above) = (0.0, 0.0);
        let steps = 2000;
        for i in 0..steps {
            // Cosine-weighted directions by their cosine; the BSDF is isotropic.
            let z = ((i as f32 + 0.5) / steps as f32).sqrt();
            let wi = Vec3::new(0.0, (1.0 - z * z).sqrt(), z);
            let f = f64::from(bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Radiance).x);
            let part = f * std::f64::consts::PI / f64::from(steps);
            all += part;
            above += if z > 0.7 { part } else { 0.0 };
        }
        for (count, expected) in [(left, all), (steep, above)] {
            let found = f64::from(count) / f64::from(walks);
            // Five standard errors: one false alarm in a million.
            let tolerance = 5.0 * (expected * (1.0 - expected) / f64::from(walks)).sqrt() + 1e-4;
            assert!((found - expected).abs() < tolerance, "{reflectance} at {cos}: {found} {expected}");
        }
    }
}

/// The BSDF of a coated surface with `nonlinear` = false is proportional to the reflectance. For a
/// white base, it equals the BSDF with `nonlinear` = true.
#[test]
fn linear_coats_are_proportional_to_reflectance() {
    let f = |reflectance: f32, nonlinear: bool| {
        let bsdf = Bsdf::coated_diffuse(Rgb::splat(reflectance), 1.5, 0.0, nonlinear);
        let (wo, wi) = (direction_with_cos(0.8), direction_with_cos(0.3));
        bsdf.evaluate(wo, wi, Vec3::Z, Vec3::Z, TransportMode::Radiance).x
    };
    assert!((f(0.3, false) / f(1.0, false) - 0.3).abs() < 1e-6);
    assert!((f(1.0, true) / f(1.0, false) - 1.0).abs() < 1e-5);
    assert!(f(0.3, true) < 0.7 * f(0.3, false));
}

#[test]
fn coats_are_separate_up_to_storage_threshold() {
    let bsdf = |alpha| Bsdf::coated_diffuse(Rgb::splat(0.5), 1.5, alpha, true);
    for (alpha, separate, specular) in
        [(0.0, true, true), (0.1, true, false), (MIN_PHOTON_STORAGE_ALPHA, true, false), (0.31, false, false)]
    {
        let coat = bsdf(alpha).coat_if_separate();
        assert_eq!((coat.is_some(), coat.is_some_and(|coat| coat.is_specular())), (separate, specular), "{alpha}");
        assert!(bsdf(alpha).stores_photons());
    }
    assert_eq!(Bsdf::coated_diffuse(Rgb::splat(0.5), 1.0, 0.1, true), Bsdf::Diffuse(Rgb::splat(0.5)));
}
