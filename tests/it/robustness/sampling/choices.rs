//! Discrete choice by weights that differ by hundreds of orders of magnitude.

use super::{ENDS, corners};
use crate::support::test_key;
use caustica::image::Image;
use caustica::light::{EnvironmentLight, Light, LightBvhSampler, PointLight};
use caustica::math::BoundingSphere;
use caustica::sampling::{Dimension, DiscreteDistribution, PiecewiseConstant2d};
use glam::Vec3;
use std::sync::Arc;

/// The probability of a chosen element is never zero, and its inverse never overflows f32.
///
/// Samples are divided by this probability.
#[test]
fn chosen_elements_have_positive_probability() {
    for weights in [
        vec![1e-60, 1.0],
        vec![1e-300, 1e-200, 1e300],
        vec![0.0, 1e-45, 1.0, 1e-45, 0.0],
        vec![5e-324, 0.0, 5e-324],
        vec![1e-39, 1.0, 1e-37],
    ] {
        let choice = DiscreteDistribution::new(weights.iter().copied()).unwrap();
        for u in ENDS {
            let (i, p) = choice.sample(u);
            assert!(p >= f32::MIN_POSITIVE && (1.0 / p).is_finite() && weights[i] > 0.0, "{weights:?} {u}: {i} {p:e}");
            assert_eq!(p, choice.probability(i));
            let rest = choice.remapped_sample(u, i);
            assert!((0.0..1.0).contains(&rest), "{weights:?} {u}: {rest}");
        }
        let all: f64 = (0..weights.len()).map(|i| f64::from(choice.probability(i))).sum();
        assert!((all - 1.0).abs() < 1e-6 && choice.weight_sum() == weights.iter().sum::<f64>());
    }
    for n in 1..200u64 {
        let weights: Vec<f64> = (0..n)
            .map(|i| {
                libm::pow(
                    10.0,
                    600.0 * f64::from(test_key(80).child_key(n).child_key(i).uniform_1d(Dimension::Light)) - 320.0,
                )
            })
            .collect();
        let choice = DiscreteDistribution::new(weights).unwrap();
        for u in ENDS {
            let (i, p) = choice.sample(u);
            assert!(p >= f32::MIN_POSITIVE && (0.0..1.0).contains(&choice.remapped_sample(u, i)), "{n} {u}: {p:e}");
        }
    }
}

#[test]
fn cells_of_any_weight_match_their_pdf() {
    let weights = [1e-300, 1e300, 0.0, 1e-10, 1.0, 1e299, 0.0, 0.0, 0.0];
    let grid = PiecewiseConstant2d::new(3, 3, |x, y| weights[3 * y + x]).unwrap();
    for u in corners() {
        let (cell, within, pdf) = grid.sample(u);
        assert!(pdf > 0.0 && pdf.is_finite() && pdf == grid.pdf(cell), "{u}: {cell} {pdf}");
        assert!(within.cmpge(glam::Vec2::ZERO).all() && within.cmplt(glam::Vec2::ONE).all());
    }
}

/// With one bright pixel in a black environment, extreme random numbers sample that pixel, with its
/// pdf.
#[test]
fn environments_are_sampled_by_radiance() {
    for (x, y) in [(0, 0), (3, 1), (7, 3), (0, 3)] {
        for value in [1e-30f32, 1.0, 1e30] {
            let mut pixels = vec![Vec3::ZERO; 32];
            pixels[8 * y + x] = Vec3::splat(value);
            let sky = EnvironmentLight::new(Image::from_pixels(8, 4, pixels).unwrap(), 0.3, Vec3::ONE).unwrap();
            for u in corners() {
                let Some((direction, pdf)) = sky.sample(u) else { continue };
                assert!(
                    (direction.length() - 1.0).abs() < 1e-5 && pdf > 0.0 && pdf.is_finite(),
                    "{u}: {direction} {pdf}"
                );
                assert_eq!(pdf, sky.pdf(direction));
                assert!((sky.radiance(direction) / pdf).is_finite());
            }
        }
    }
    assert!(EnvironmentLight::with_constant_radiance(Vec3::ZERO).unwrap().sample(glam::Vec2::ZERO).is_none());
}

/// Sampling a light returns the same probability as a query for that light.
///
/// The lights are near and far, with powers over sixty orders of magnitude, and one is an
/// environment light.
#[test]
fn chosen_light_has_positive_probability() {
    let mut lights: Vec<Light> = (0..40u64)
        .map(|i| {
            let u = test_key(81).child_key(i);
            let exponent = 60.0 * u.uniform_1d(Dimension::Light) - 30.0;
            let place = u.uniform_2d(Dimension::LightPosition).extend(0.5) * 10.0;
            Light::Point(PointLight { position: place, intensity: Vec3::splat(libm::powf(10.0, exponent)) })
        })
        .collect();
    lights.push(Light::Environment(Arc::new(EnvironmentLight::with_constant_radiance(Vec3::ONE).unwrap())));
    let choice = LightBvhSampler::new(&lights, BoundingSphere { center: Vec3::ZERO, radius: 20.0 }).unwrap();
    for p in [Vec3::ZERO, Vec3::new(5.0, 5.0, 5.0), Vec3::splat(1e6), Vec3::splat(1e12)] {
        for n in [None, Some(Vec3::Z), Some(-Vec3::X)] {
            for u in ENDS {
                let Some((light, probability, rest)) = choice.sample(p, n, u) else { continue };
                assert!(
                    probability > 0.0 && probability <= 1.0 && (0.0..1.0).contains(&rest),
                    "{p} {u}: {probability}"
                );
                assert_eq!(probability, choice.probability(p, n, light));
            }
        }
    }
}
