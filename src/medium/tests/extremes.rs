//! Tests of extreme media: empty media, opaque media, and media without absorption.

use super::*;
use glam::DAffine3;

const X: Vec3 = Vec3::X;

fn unit_cube_density_grid(values: Vec<f32>, size: [u32; 3]) -> Option<Arc<GridDensity>> {
    let place = DAffine3::from_translation(DVec3::new(0.0, -0.5, -0.5));
    Some(Arc::new(GridDensity::new(size, values, place).unwrap()))
}

fn medium_from_coefficients(a: Vec3, s: Vec3, e: Vec3, density: Option<Arc<GridDensity>>) -> Medium {
    Medium { absorption: a, scattering: s, emission: e, phase: PhaseFunction::Isotropic, density }
}

#[test]
fn empty_media_have_no_effect() {
    let ray = Ray::new(Vec3::ZERO, X);
    let nothing = medium_from_coefficients(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, None);
    let thin = medium_from_coefficients(Vec3::ONE, Vec3::ONE, Vec3::ONE, unit_cube_density_grid(vec![0.0; 8], [2; 3]));
    let elsewhere =
        medium_from_coefficients(Vec3::ONE, Vec3::ONE, Vec3::ONE, unit_cube_density_grid(vec![1.0; 8], [2; 3]))
            .translated(DVec3::Y * 2.0);
    for (medium, empty) in [(nothing, true), (thin, true), (elsewhere, false)] {
        assert_eq!(medium.is_empty(), empty);
        for distance in [0.0, 1.0, f32::INFINITY] {
            let random = &mut test_rng(6);
            assert_eq!(medium.transmittance(&ray, distance, random), Vec3::ONE);
            assert_eq!(medium.emitted_radiance(&ray, distance, random), Vec3::ZERO);
            let distance_sample = medium.distance_sample(&ray, distance, Vec3::ONE, random);
            assert_eq!(distance_sample, DistanceSample { scattering_distance: None, weight: Vec3::ONE });
        }
    }
}

/// Checks that weights stay finite at an optical depth of 10⁴ and at an infinite distance.
#[test]
#[ignore = "long: paths through optical depths of ten thousand"]
fn large_optical_depths_stay_finite() {
    let ray = Ray::new(Vec3::ZERO, X);
    for density in [None, unit_cube_density_grid(vec![1.0; 20], [20, 1, 1])] {
        let scale = 1e4;
        let grey = medium_from_coefficients(
            Vec3::splat(0.25 * scale),
            Vec3::splat(0.75 * scale),
            Vec3::splat(scale),
            density.clone(),
        );
        let white = medium_from_coefficients(Vec3::ZERO, Vec3::splat(scale), Vec3::ZERO, density.clone());
        let mixed = medium_from_coefficients(Vec3::ZERO, Vec3::new(scale, 1.0, 0.0), Vec3::X, density);
        let random = &mut test_rng(7);
        for distance in [1.0, f32::INFINITY] {
            for _ in 0..10_000 {
                for (medium, albedo) in [(&grey, 0.75), (&white, 1.0)] {
                    let distance_sample = medium.distance_sample(&ray, distance, Vec3::ONE, random);
                    assert!(distance_sample.scattering_distance.is_some_and(|t| t < 0.01), "{distance_sample:?}");
                    assert!((distance_sample.weight - albedo).abs().max_element() < 1e-6, "{distance_sample:?}");
                }
                for throughput in [Vec3::ONE, Vec3::X, Vec3::Z, Vec3::ZERO, Vec3::new(1e-30, 1.0, 1e30), Vec3::INFINITY]
                {
                    let distance_sample = mixed.distance_sample(&ray, distance, throughput, random);
                    assert!(
                        distance_sample.weight.is_finite() && distance_sample.weight.min_element() >= 0.0,
                        "{distance_sample:?}"
                    );
                    let whole = throughput.element_sum();
                    let after = (throughput * distance_sample.weight).element_sum();
                    assert!(!whole.is_finite() || after <= whole * (1.0 + 1e-6), "{throughput} {distance_sample:?}");
                    if throughput == Vec3::Z {
                        assert_eq!(distance_sample, DistanceSample { scattering_distance: None, weight: Vec3::Z });
                    }
                }
            }
            // The true transmittance e⁻¹⁰⁰⁰⁰ rounds to 0. In the grid, roulette ends every tracked
            // path.
            assert_eq!(grey.transmittance(&ray, distance, random), Vec3::ZERO);
            assert!(
                (grey.emitted_radiance(&ray, f32::INFINITY, random) - 1.0).abs().max_element() < 1e-6
                    || !grey.is_homogeneous()
            );
        }
    }
}

/// Estimates transmittance through density 0, where all tentative collisions are null collisions.
/// The true value is 1.
///
/// The optical depth of the majorant is four times the number of collisions between two
/// unconditional roulettes, so 1/16 of the paths survive with weight 16. The standard error is
/// 4/√n.
#[test]
#[ignore = "long: many paths that roulette ends"]
fn collision_roulette_is_unbiased() {
    let mut values = vec![0.0; 512];
    values[511] = 1.0;
    let ray = Ray::new(Vec3::new(0.0, -0.4, -0.4), X);
    let medium = medium_from_coefficients(
        Vec3::splat(65_000.0),
        Vec3::splat(1000.0),
        Vec3::ZERO,
        unit_cube_density_grid(values, [8; 3]),
    );
    let (random, n) = (&mut test_rng(8), 2000);
    let (mut transmittance, mut sample_weight) = (0.0, 0.0);
    for _ in 0..n {
        transmittance += medium.transmittance(&ray, 1.0, random).x;
        sample_weight += medium.distance_sample(&ray, 1.0, Vec3::ONE, random).weight.x;
    }
    for mean in [transmittance, sample_weight].map(|sum| sum / n as f32) {
        assert!((mean - 1.0).abs() < 20.0 / (n as f32).sqrt(), "{mean}");
    }
}

#[test]
fn tracking_ends_at_extreme_densities() {
    let mut values = vec![0.0; 512];
    values[100] = f32::MAX;
    let ray = Ray::new(Vec3::new(-1.0, -0.4, -0.4), Vec3::new(1.0, 0.3, 0.2).normalize());
    let medium =
        medium_from_coefficients(Vec3::splat(f32::MAX), Vec3::ONE, Vec3::ONE, unit_cube_density_grid(values, [8; 3]));
    let random = &mut test_rng(9);
    for _ in 0..100 {
        let distance_sample = medium.distance_sample(&ray, f32::INFINITY, Vec3::ONE, random);
        let light =
            medium.transmittance(&ray, f32::INFINITY, random) + medium.emitted_radiance(&ray, f32::INFINITY, random);
        assert!(distance_sample.weight.is_finite() && light.is_finite(), "{distance_sample:?} {light}");
    }
}

#[test]
fn medium_predicates_are_correct() {
    let (zero, one) = (Vec3::ZERO, Vec3::ONE);
    let glow = medium_from_coefficients(zero, zero, one, None);
    assert!(glow.emits() && !glow.scatters() && !glow.is_empty() && glow.is_homogeneous());
    let fog = medium_from_coefficients(zero, one, zero, unit_cube_density_grid(vec![2.0], [1; 3]));
    assert!(!fog.emits() && fog.scatters() && !fog.is_homogeneous());
    assert_eq!([fog.density_at(X * 0.5), fog.density_at(X * 1.5)], [2.0, 0.0]);
    assert_eq!(fog.translated(DVec3::X).density_at(X * 1.5), 2.0);
    assert_eq!(glow.translated(DVec3::X).density_at(X), 1.0);
    assert_eq!(glow.emitted_radiance(&Ray::new(zero, X), 3.0, &mut test_rng(10)), one * 3.0);
}
