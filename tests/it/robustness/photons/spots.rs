//! Spotlights as narrow as a laser.

use caustica::camera::Camera;
use caustica::color::Rgb;
use caustica::light::Light;
use caustica::math::BoundingSphere;
use caustica::scene::{LightStrength, SceneBuilder, UnscaledDeltaLight};
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

const NOWHERE: BoundingSphere = BoundingSphere { center: Vec3::ZERO, radius: 0.0 };

/// Full angles of the tested cones \[degrees].
const ANGLES: [f64; 8] = [0.001, 0.01, 0.028, 0.05, 0.1, 1.0, 40.0, 200.0];

/// Returns a spotlight at the origin along z, of half angles `inner` and `outer`.
fn spot(inner: f64, outer: f64, strength: LightStrength) -> Light {
    let mut b = SceneBuilder::new();
    b.add_delta_light(UnscaledDeltaLight::Spot { position: DVec3::ZERO, axis: DVec3::Z, inner, outer }, strength);
    let scene = b.build(Camera::perspective(DVec3::ZERO, DVec3::Z, DVec3::Y, 1.0, 4, 4).unwrap()).unwrap();
    scene.lights()[0].clone()
}

/// Returns 1 − cos x to full precision.
fn one_minus_cos(x: f64) -> f64 {
    let s = libm::sin(0.5 * x);
    2.0 * s * s
}

/// Spotlights of any width emit their power: stated power, emitted photons and arriving flux agree.
///
/// The flux of a sharp cone of half angle θ is 2π(1 − cos θ) times its intensity. The soft rim has
/// half of the intensity on average over its solid angle. 1 − cos θ rounds to 2⁻²⁴, and so do a few
/// products.
#[test]
fn spotlights_of_any_width_emit_their_power() {
    for outer in ANGLES.map(|angle| 0.5 * angle.to_radians()) {
        for (inner, part) in [(outer, 1.0), (0.0, 0.5)] {
            let expected = part * TAU * one_minus_cos(outer);
            let light = spot(inner, outer, LightStrength::Physical(Rgb::ONE));
            let power = f64::from(light.power(NOWHERE).x);
            assert!((power / expected - 1.0).abs() < 1e-6, "{outer}: stated power {}", power / expected);
            let strong = spot(inner, outer, LightStrength::Power(Rgb::ONE));
            let sample = strong.sample_li(Vec3::Z * 2.0, Vec2::ZERO).unwrap();
            let seen = f64::from(sample.weight.x) * 4.0 * expected;
            assert!((seen - 1.0).abs() < 1e-6, "{outer} on the axis: {seen}");

            // The cone is divided into 4096 equal parts. The integrand is a cubic with a second
            // derivative below 6, so the error of the midpoint rule is 6/24·4096⁻².
            let n = 4096;
            let place = |i: i32| Vec2::new((i as f32 + 0.5) / n as f32, (0.618_034 * i as f32).fract());
            let emitted = (0..n).filter_map(|i| light.sample_le(NOWHERE, Vec2::ZERO, place(i)));
            let emitted = emitted.map(|e| f64::from(e.weight.x)).sum::<f64>() / f64::from(n);
            assert!((emitted / expected - 1.0).abs() < 2e-6, "{outer} emitted: {}", emitted / expected);

            // Rings around the axis on a sphere of radius 1. One of them lies across a sharp edge.
            let rings = 4000;
            let reach = (1.2 * outer).min(PI);
            let arriving = |i: i32| {
                let (near, far) = [i, i + 1].map(|i| reach * f64::from(i) / f64::from(rings)).into();
                let (sin, cos) = libm::sincos(0.5 * (near + far));
                let p = DVec3::new(sin, 0.0, cos).as_vec3();
                let sample = light.sample_li(p, Vec2::ZERO);
                sample.map_or(0.0, |s| f64::from(s.weight.x)) * TAU * (one_minus_cos(far) - one_minus_cos(near))
            };
            let arriving: f64 = (0..rings).map(arriving).sum();
            let ring = 2.4 / f64::from(rings);
            assert!((arriving / expected - 1.0).abs() < ring, "{outer} arriving: {}", arriving / expected);
        }
    }
}
