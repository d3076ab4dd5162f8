//! Tests of environment lights.

use super::chi_square::{DirectionCells, INTEGRAL_ERROR, sidak_significance_level};
use super::*;
use crate::image::Image;
use glam::Vec2;
use std::f64::consts::PI;

/// A sky picture with a black lower part, a bright sun and random colours.
pub fn random_sky_picture() -> Image {
    let pixel = |i: u32| {
        let (x, y) = (i % 12, i / 12);
        let grey = test_key(u64::from(i)).uniform_1d(Dimension::Film) * if y > 4 { 0.0 } else { 1.0 };
        if (x, y) == (7, 2) { Vec3::new(40.0, 30.0, 20.0) } else { Vec3::new(grey, 0.5 * grey, 0.25) * grey }
    };
    Image::from_pixels(12, 8, (0..96).map(pixel).collect()).unwrap()
}

/// The environment light of [`random_sky_picture`], rotated by `angle` \[radians].
pub fn random_sky_light(angle: f64) -> EnvironmentLight {
    EnvironmentLight::new(random_sky_picture(), angle, Rgb::splat(1.5)).unwrap()
}

fn constant_environment_light() -> EnvironmentLight {
    EnvironmentLight::with_constant_radiance(Rgb::splat(2.0)).unwrap()
}

#[test]
fn environment_samples_follow_the_pdf() {
    let skies = [constant_environment_light(), random_sky_light(0.0), random_sky_light(0.4)];
    for (i, environment) in skies.iter().enumerate() {
        for axis in [Vec3::Y, Vec3::new(0.3, -0.5, 1.0)] {
            let cells = DirectionCells::new(axis, PI);
            let draw = |u| {
                environment.sample(u).map(|(w, pdf)| {
                    assert_eq!(pdf.to_bits(), environment.pdf(w).to_bits());
                    w
                })
            };
            let (chance, total) = cells.test_samples_against_pdf(&draw, &|w| f64::from(environment.pdf(w)));
            assert!(chance > sidak_significance_level(2 * skies.len()), "{i} {axis}: {chance}");
            assert!((total - 1.0).abs() < INTEGRAL_ERROR, "{i} {axis}: {total}");
        }
    }
}

/// `inverse_sample` returns the random point `u` from which a direction was sampled. Rounding
/// causes exceptions near the poles and the cell edges, for fewer than 1 in 1,000 directions.
#[test]
fn inverse_sample_returns_the_original_random_point() {
    for environment in [constant_environment_light(), random_sky_light(0.0), random_sky_light(0.4)] {
        let mut exceptions = 0;
        for i in 0..20_000 {
            let u = test_key(i).uniform_2d(Dimension::LightDirection);
            let Some((w, _)) = environment.sample(u) else { continue };
            let inverse = environment.inverse_sample(w).unwrap();
            exceptions += u32::from((inverse - u).abs().max_element() > 1e-5);
        }
        assert!(exceptions <= 20, "{exceptions}");
    }
}

#[test]
fn environment_pdf_is_positive_where_radiance_is() {
    let environment = random_sky_light(0.3);
    let directions =
        (0..100_000).map(|i| warp::square_to_uniform_sphere(test_key(i).uniform_2d(Dimension::LightDirection)));
    let mut dark = 0;
    for w in directions.chain([Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::Z, Vec3::NEG_Z]) {
        let black = environment.radiance(w) == Rgb::ZERO;
        dark += u32::from(black);
        assert!(black || environment.pdf(w) > 0.0, "{w}");
    }
    assert!(dark > 10_000, "the lower part is black");
}

/// The power through a sphere of radius r is π r² · 4π L for an environment of constant radiance L,
/// and π r² times the integral of the radiance for a map.
#[test]
fn power_is_the_integral_of_radiance() {
    let disc = BoundingSphere { center: Vec3::ONE, radius: 3.0 };
    let area = PI * 9.0;
    assert!((f64::from(constant_environment_light().power(disc).x) / (area * 8.0 * PI) - 1.0).abs() < 1e-6);
    for environment in [random_sky_light(0.0), random_sky_light(1.0)] {
        let seen = estimate_mean_and_variance(400_000, |k| {
            let w = warp::square_to_uniform_sphere(k.uniform_2d(Dimension::LightDirection));
            4.0 * PI * area * f64::from(environment.radiance(w).x)
        });
        assert_within_five_sigma(seen, f64::from(environment.power(disc).x));
    }
}

/// The power of a one-column map agrees with a midpoint rule of 10⁵ points over the angle from +y.
/// The error of the rule is below 10⁻⁹.
#[test]
fn one_column_map_power_matches_quadrature() {
    for h in [1u32, 2, 3, 8] {
        let pixels = (0..h).map(|row| Rgb::splat(((row * 5 + 1) % 7) as f32)).collect();
        let environment = EnvironmentLight::new(Image::from_pixels(1, h, pixels).unwrap(), 0.0, Rgb::ONE).unwrap();
        let n = 100_000;
        let ring = |i: u32| {
            let (sin, cos) = libm::sincos((f64::from(i) + 0.5) * PI / f64::from(n));
            f64::from(environment.radiance(Vec3::new(sin as f32, cos as f32, 0.0)).x) * sin
        };
        let truth = 2.0 * PI * PI / f64::from(n) * (0..n).map(ring).sum::<f64>();
        // The disc has area 1. The tolerance allows for three roundings of the power to f32.
        let disc = BoundingSphere { center: Vec3::ZERO, radius: (1.0 / PI).sqrt() as f32 };
        let power = f64::from(environment.power(disc).x);
        assert!((power / truth - 1.0).abs() < 1e-6, "{h}: {power} {truth}");
    }
}

/// An environment of constant radiance L gives a plane the irradiance π L. It sends the flux 4π² L
/// r² through a ball of radius r.
#[test]
fn constant_environment_irradiance_is_pi_times_radiance() {
    let light = Light::Environment(constant_environment_light().into());
    assert_within_five_sigma(estimate_irradiance(&light, Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.6, 0.0, 0.8)), 2.0 * PI);
    let domain = BoundingSphere { center: Vec3::new(0.5, 0.0, 0.0), radius: 2.0 };
    let (a, ball) = (0.7f64, Vec3::new(-0.3, 0.2, 0.5));
    let flux = estimate_mean_and_variance(200_000, |k| {
        let (u, v) = (k.uniform_2d(Dimension::LightPosition), k.uniform_2d(Dimension::LightDirection));
        let e = light.sample_le(domain, u, v).unwrap();
        assert!((e.ray.origin - domain.center).dot(e.ray.direction) < -0.99 * domain.radius, "it starts outside");
        if (ball - e.ray.origin).cross(e.ray.direction).length() < a as f32 { f64::from(e.weight.x) } else { 0.0 }
    });
    let truth = PI * a * a * 4.0 * PI * 2.0;
    assert_within_five_sigma(flux, truth);
    // If photons are aimed at the ball only, each carries the whole flux. Aim spheres are larger
    // than the balls by about 10⁻⁵.
    let aim = PhotonAim::new([BoundingSphere { center: ball, radius: a as f32 }]);
    for i in 0..100 {
        let (u, v) =
            (test_key(i).uniform_2d(Dimension::LightPosition), test_key(i).uniform_2d(Dimension::LightDirection));
        let aimed = f64::from(light.sample_le_towards(&aim, domain, u, v).unwrap().weight.x);
        assert!((aimed / truth - 1.0).abs() < 1e-4, "{aimed} {truth}");
    }
}

/// Importance sampling has less variance than uniform sampling, whose variance is large because of
/// the bright sun.
#[test]
fn importance_sampling_reduces_variance() {
    let environment = random_sky_light(0.4);
    let n = environment.sample(Vec2::splat(0.5)).unwrap().0;
    let by_map = estimate_irradiance(&Light::Environment(environment.clone().into()), Vec3::ZERO, n);
    let uniformly = estimate_mean_and_variance(100_000, |k| {
        let w = warp::square_to_uniform_sphere(k.uniform_2d(Dimension::LightPosition));
        4.0 * PI * f64::from(environment.radiance(w).x * w.dot(n).max(0.0))
    });
    assert_within_five_sigma(uniformly, by_map.0);
    eprintln!("uniform directions have {:.1} times the variance", uniformly.1 / by_map.1);
    assert!(uniformly.1 > 10.0 * by_map.1);
}

#[test]
fn environment_map_orientation_matches_documentation() {
    // Four columns and two rows of pixels, each with its own brightness.
    let pixels: Vec<Rgb> = (0..8).map(|i| Rgb::splat(i as f32)).collect();
    let at = |angle: f64, w: Vec3| {
        let map = Image::from_pixels(4, 2, pixels.clone()).unwrap();
        EnvironmentLight::new(map, angle, Rgb::splat(10.0)).unwrap().radiance(w.normalize()).x
    };
    let close = |a: f32, b: f32| assert!((a - b).abs() < 1e-4, "{a} {b}");
    // In this order: towards −z, between columns 1 and 2; to the right of it; at the seam, towards
    // +z; at the lower left; level, between the rows.
    close(at(0.0, Vec3::new(0.0, 1.0, -1.0)), 15.0);
    close(at(0.0, Vec3::new(1.0, 2f32.sqrt(), -1.0)), 20.0);
    close(at(0.0, Vec3::new(0.0, 1.0, 1.0)), 15.0);
    close(at(0.0, Vec3::new(-1.0, -(2f32.sqrt()), -1.0)), 50.0);
    close(at(0.0, Vec3::NEG_Z), 35.0);
    // A quarter turn anticlockwise moves the part of the map at −z to −x.
    close(at(PI / 2.0, Vec3::new(-1.0, 1.0, 0.0)), 15.0);
    close(at(PI / 2.0, Vec3::new(-1.0, 2f32.sqrt(), -1.0)), 20.0);
}

#[test]
fn invalid_environment_pictures_are_errors() {
    for (bad, scale) in [(-0.1, 1.0), (f32::NAN, 1.0), (f32::INFINITY, 1.0), (1.0, f32::NAN), (1e30, 1e30), (1.0, -1.0)]
    {
        let pixels = vec![Rgb::ZERO, Rgb::ZERO, Rgb::ZERO, Rgb::ZERO, Rgb::new(0.0, bad, 0.0), Rgb::ZERO];
        let refused = EnvironmentLight::new(Image::from_pixels(3, 2, pixels).unwrap(), 0.0, Rgb::splat(scale));
        assert!(matches!(refused, Err(EmissionPictureError::InvalidPixel { .. })), "{bad} {scale}");
        if scale == 1.0 {
            assert!(refused.unwrap_err().to_string().contains("column 1, row 1"));
        }
    }
    let black = Light::Environment(EnvironmentLight::with_constant_radiance(Rgb::ZERO).unwrap().into());
    assert!(black.sample_li(Vec3::ZERO, Vec2::ZERO).is_none() && black.pdf_li(Vec3::ZERO, Vec3::X, None) == 0.0);
}
