mod chi_square;
mod direct;
mod emission;
mod emission_texture;
mod environment;
mod intensity_maps;
mod light_bvh;

use super::*;
use crate::math::warp;
use crate::sampling::{Dimension, Key, Purpose};
use crate::shape::{Disc, Rectangle, Shape, Sphere as SphereShape};
use glam::DVec3;

fn test_key(i: u64) -> Key {
    Key::new(21).purpose_key(Purpose::Test).child_key(i)
}

fn area_light(shape: Shape, radiance: f32) -> Light {
    Light::Area(AreaLight::with_uniform_radiance(LightSurface::Shape(shape), Rgb::splat(radiance)))
}

/// Mean of `f` over `n` random keys, and the variance of this mean.
fn estimate_mean_and_variance(n: u64, f: impl Fn(Key) -> f64) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..n {
        let x = f(test_key(i));
        sum += x;
        squares += x * x;
    }
    let mean = sum / n as f64;
    (mean, (squares / n as f64 - mean * mean).max(0.0) / n as f64)
}

/// Irradiance that `light` gives at `p` on a surface with normal `n`, estimated from 100,000
/// samples, and the variance of this estimate.
fn estimate_irradiance(light: &Light, p: Vec3, n: Vec3) -> (f64, f64) {
    estimate_mean_and_variance(100_000, |k| {
        let sample = light.sample_li(p, k.uniform_2d(Dimension::LightPosition));
        sample.map_or(0.0, |s| f64::from(s.weight.x * s.wi.dot(n).max(0.0)))
    })
}

/// Asserts that an estimated mean agrees with `truth` within five standard errors. `variance` is
/// the variance of the mean.
///
/// This gives less than one false alarm in a million comparisons.
fn assert_within_five_sigma((mean, variance): (f64, f64), truth: f64) {
    assert!((mean - truth).abs() < 5.0 * variance.sqrt() + 2e-6 * truth, "{mean} against {truth}");
}

fn point_on_y_axis(v: f64) -> DVec3 {
    DVec3::new(0.0, v, 0.0)
}

/// The irradiance of a point light is intensity times cosine over squared distance.
#[test]
fn point_light_irradiance_is_exact() {
    let light = Light::Point(PointLight { position: Vec3::new(0.0, 2.0, 0.0), intensity: Rgb::splat(3.0) });
    let (h, x) = (2.0f64, 1.5);
    assert_within_five_sigma(
        estimate_irradiance(&light, Vec3::new(x as f32, 0.0, 0.0), Vec3::Y),
        3.0 * h / libm::pow(h * h + x * x, 1.5),
    );
}

/// The irradiance of a disc light agrees with closed forms, on the disc's axis and beside it. The
/// disc faces down.
#[test]
fn disc_light_irradiance_is_exact() {
    let (r, h, l) = (0.8f64, 1.1, 2.0);
    let light = area_light(Shape::Disc(Disc::new(point_on_y_axis(h), DVec3::X * r, DVec3::Z * r)), l as f32);
    let truth = |a: f64| {
        let s = h * h + a * a;
        std::f64::consts::FRAC_PI_2 * l * (1.0 - (s - r * r) / ((s + r * r) * (s + r * r) - 4.0 * r * r * a * a).sqrt())
    };
    assert!((truth(0.0) - std::f64::consts::PI * l * r * r / (r * r + h * h)).abs() < 1e-12);
    for a in [0.0, 0.5, 2.0] {
        assert_within_five_sigma(estimate_irradiance(&light, Vec3::new(a as f32, 0.0, 0.0), Vec3::Y), truth(a));
    }
    assert!(light.sample_li(Vec3::new(0.0, 5.0, 0.0), glam::Vec2::splat(0.5)).is_none(), "its back is black");
}

/// The irradiance of a sphere light agrees with its closed form.
#[test]
fn sphere_light_irradiance_is_exact() {
    let light = area_light(Shape::Sphere(SphereShape::new(DVec3::new(3.0, 4.0, 0.0), 0.5)), 7.0);
    assert_within_five_sigma(estimate_irradiance(&light, Vec3::ZERO, Vec3::Y), std::f64::consts::PI * 7.0 * 0.01 * 0.8);
}

/// The irradiance below the corner of a rectangle light agrees with its closed form.
#[test]
fn rectangle_light_irradiance_is_exact() {
    let (a, b, h) = (1.2f64, 0.7, 0.9);
    let light = area_light(Shape::Rectangle(Rectangle::new(point_on_y_axis(h), DVec3::X * a, DVec3::Z * b)), 5.0);
    let (u, v) = (a / h, b / h);
    let term = |p: f64, q: f64| p / (1.0 + p * p).sqrt() * libm::atan(q / (1.0 + p * p).sqrt());
    assert_within_five_sigma(estimate_irradiance(&light, Vec3::ZERO, Vec3::Y), 2.5 * (term(u, v) + term(v, u)));
}
