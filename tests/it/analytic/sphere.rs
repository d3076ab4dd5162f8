//! A diffuse sphere seen from inside: each bounce lights the whole wall uniformly, wherever the
//! light is.

use crate::support::*;
use caustica::photon::{PhotonMap, StoreMask};
use caustica::scene::{LightStrength, Material, SceneBuilder, UnscaledDeltaLight};
use caustica::shape::{Disc, Shape, Sphere};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

const FLUX: f64 = 8.0;

fn sphere_scene(radius: f64, albedo: f64, light: DVec3) -> SceneBuilder {
    let mut b = SceneBuilder::new();
    let wall = b.add_material(Material::diffuse(grey(albedo)));
    b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, radius)), wall, grey(0.0));
    b.add_delta_light(UnscaledDeltaLight::Point { position: light }, LightStrength::Power(grey(FLUX)));
    b
}

/// Returns the chi-square statistic of `counts` against a uniform distribution, converted to a
/// standard normal variable.
///
/// By Wilson and Hilferty, (χ²/ν)^⅓ is normal with mean 1 − 2/(9ν) and variance 2/(9ν), for ν
/// degrees of freedom.
fn chi_square(counts: &[u32]) -> f64 {
    let mean = counts.iter().map(|c| f64::from(*c)).sum::<f64>() / counts.len() as f64;
    let chi2: f64 = counts.iter().map(|c| (f64::from(*c) - mean) * (f64::from(*c) - mean) / mean).sum();
    let nu = counts.len() as f64 - 1.0;
    (libm::cbrt(chi2 / nu) - 1.0 + 2.0 / (9.0 * nu)) / (2.0 / (9.0 * nu)).sqrt()
}

/// Returns the index of the cell that contains `p`. Cells have equal area: zones of equal height,
/// cut by azimuth.
fn sphere_cell(p: DVec3, radius: f64) -> usize {
    const N: f64 = 32.0;
    let z = ((p.z / radius * 0.5 + 0.5) * N).clamp(0.0, N - 1.0) as usize;
    let turn = ((libm::atan2(p.y, p.x) / TAU + 0.5) * N).clamp(0.0, N - 1.0) as usize;
    z * N as usize + turn
}

/// Photons that the wall of a sphere has reflected cover the wall uniformly.
///
/// From any point of the wall, a cosine lobe covers the sphere uniformly. So all reflected photons
/// are independent and uniform, even if emission is stratified. Counts in cells are exactly
/// multinomial. The limit of 4.9 σ has a false-alarm rate of 10⁻⁶.
#[test]
fn reflected_photons_cover_sphere_uniformly() {
    let scene = photon_only_scene(sphere_scene(2.0, 0.6, dvec3(0.3, -0.2, 1.6)));
    for bounces in [1, 1000] {
        let mut counts = vec![0; 32 * 32];
        for t in trace_photon_passes(&scene, StoreMask::INDIRECT, bounces, 4, 1 << 16) {
            t.deposits.surface_photons.iter().for_each(|p| counts[sphere_cell(photon_position(&scene, p), 2.0)] += 1);
        }
        let z = chi_square(&counts);
        eprintln!("chi-square of {bounces} bounces: z = {z:.2}");
        assert!(z.abs() < 4.9, "{bounces} bounces: z = {z}");
    }
}

/// The photons of bounce k carry the flux ρᵏΦ.
///
/// Random numbers are keyed by path and bounce. So a higher bounce limit adds photons and changes
/// none.
#[test]
fn flux_by_bounce_is_power_of_albedo() {
    let scene = photon_only_scene(sphere_scene(2.0, 0.6, dvec3(0.3, -0.2, 1.6)));
    let landed = |n| {
        let passes = trace_photon_passes(&scene, StoreMask::INDIRECT, n, PASSES, 1 << 14);
        passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, |_| true).x).collect::<Vec<f64>>()
    };
    let mut before = landed(0);
    assert!(before.iter().all(|f| *f == 0.0), "the first surface holds direct photons only");
    let mut expected = FLUX;
    for k in 1..=5 {
        expected *= 0.6;
        let now = landed(k);
        let bounce: Vec<f64> = now.iter().zip(&before).map(|(a, b)| a - b).collect();
        assert_mean(&format!("flux of bounce {k}"), &bounce, expected, expected * STORED_COLOR_ROUNDING, 0.012);
        before = now;
    }
}

/// Density estimates on a sphere have no bias, and give the irradiance ρΦ/(4πR²(1 − ρ)) after
/// reflection.
///
/// A cap of chord r has exactly the area πr², and kernels are functions of the chord.
#[test]
fn sphere_estimates_match_uniform_irradiance() {
    let (radius, albedo) = (2.0, 0.6);
    let scene = photon_only_scene(sphere_scene(radius, albedo, dvec3(0.3, -0.2, 1.6)));
    let expected = albedo * FLUX / (4.0 * PI * radius * radius * (1.0 - albedo));
    let maps: Vec<PhotonMap> = trace_photon_passes(&scene, StoreMask::INDIRECT, 1000, PASSES, 1 << 15)
        .into_iter()
        .map(|t| PhotonMap::build(t.deposits.surface_photons))
        .collect();
    // Each estimate adds 800 photons in single precision, with a relative error of at most 800 ·
    // 2⁻²⁴ = 5·10⁻⁵. Stored colors are accurate to 2·10⁻⁵.
    for kernel in KERNELS {
        let mean = |map: &PhotonMap| {
            let at = |p: &DVec3| estimated_irradiance(&scene, map, *p * radius, -*p, fixed_bandwidth(0.5), kernel).x;
            fibonacci_directions(200).iter().map(at).sum::<f64>() / 200.0
        };
        let samples: Vec<f64> = maps.iter().map(mean).collect();
        assert_mean(&format!("irradiance of a sphere, {kernel:?}"), &samples, expected, expected * 2e-4, 3e-3);
    }
}

/// A light at the center gives the wall the uniform radiance ρΦ/(4π²R²(1 − ρ)).
///
/// Direct light is the fraction 1 − ρ of this radiance.
#[test]
fn sphere_interior_has_uniform_radiance() {
    let (radius, albedo) = (2.0, 0.6);
    let b = sphere_scene(radius, albedo, DVec3::ZERO);
    let scene = b.build(square_camera(dvec3(0.5, 0.3, 0.1), dvec3(-1.0, 0.2, 0.4), 60.0, 12)).unwrap();
    let expected = albedo * FLUX / (4.0 * PI * PI * radius * radius * (1.0 - albedo));
    let samples = red_channels(&mean_radiance_per_pass(&scene, fixed_radius_settings(1 << 16, 0, 0.4), PASSES));
    assert_mean("radiance of a sphere", &samples, expected, expected * 2.0 * STORED_COLOR_ROUNDING, 4e-3);
    let direct = red_channels(&mean_radiance_per_pass(&scene, fixed_radius_settings(0, 0, 0.4), 4));
    // Unit vectors, intensity and 1/d² have rounding errors of a few f32 ulps each.
    assert!(direct.iter().all(|l| (l / (expected * (1.0 - albedo)) - 1.0).abs() < 1e-5), "{direct:?}");
}

/// A cavity reflects with its effective albedo.
///
/// A plate cuts a cap off the sphere, with the fraction f of its area. The plate emits Lambertian
/// light of flux Φ, which reaches the wall as uniformly as light from the cap. The wall receives
/// Φ/(1 − ρ(1 − f)) over all bounces, and returns Φρf/(1 − ρ(1 − f)) to the plate.
#[test]
fn cavity_returns_effective_albedo() {
    for (albedo, height) in [(0.9, 0.6), (0.5, -0.5)] {
        let mut b = SceneBuilder::new();
        let wall = b.add_material(Material::diffuse(grey(albedo)));
        let black = b.add_material(Material::black());
        b.add_shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0)), wall, grey(0.0));
        let plate = Disc::circular_disc(DVec3::Z * height, -DVec3::Z, (1.0 - height * height).sqrt());
        b.add_shape(Shape::Disc(plate), black, grey(1.0));
        let scene = photon_only_scene(b);
        let f = 0.5 * (1.0 - height);
        let flux = PI * PI * (1.0 - height * height);
        let series = 1.0 / (1.0 - albedo * (1.0 - f));
        let passes = trace_photon_passes(&scene, StoreMask::ALL, 1000, PASSES, 1 << 15);
        let landed: Vec<f64> =
            passes.iter().map(|t| flux_where(&scene, &t.deposits.surface_photons, |_| true).x).collect();
        assert_mean(
            &format!("landed in a cavity, f = {f}"),
            &landed,
            flux * series,
            flux * series * STORED_COLOR_ROUNDING,
            3e-3,
        );
        let returned: Vec<f64> =
            passes.iter().zip(&landed).map(|(t, l)| t.audit.absorbed[0] - (1.0 - albedo) * l).collect();
        assert_mean(
            &format!("returned by a cavity, f = {f}"),
            &returned,
            flux * albedo * f * series,
            flux * STORED_COLOR_ROUNDING,
            0.012,
        );
    }
}
