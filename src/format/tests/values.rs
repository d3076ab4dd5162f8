//! Random numbers, vectors and names for proptest.

use glam::DVec3;
use proptest::prelude::*;

pub fn random_finite_number() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO
}

/// Returns a random number above 0 that single precision can hold.
pub fn random_positive() -> impl Strategy<Value = f64> {
    let any = proptest::num::f64::POSITIVE | proptest::num::f64::NORMAL;
    any.prop_map(|x| if x > f64::from(f32::MAX) { 1.0 / x } else { x })
}

/// Returns random absorption or scattering coefficients \[1/length].
pub fn random_coefficients() -> impl Strategy<Value = DVec3> {
    let one = || prop_oneof![Just(0.0), 0.0..=1e12, 0.0..1.0];
    [one(), one(), one()].prop_map(DVec3::from_array)
}

pub fn random_point() -> impl Strategy<Value = DVec3> {
    [random_finite_number(), random_finite_number(), random_finite_number()].prop_map(DVec3::from_array)
}

/// Returns a random vector whose squared length neither overflows nor underflows.
pub fn random_direction() -> impl Strategy<Value = DVec3> {
    let one = -1e3..1e3;
    ([one.clone(), one.clone(), one], -100..100_i32).prop_filter_map("no length", |(v, exponent)| {
        let v = DVec3::from_array(v);
        (v.length() > 1e-3).then_some(v * f64::from(exponent).exp2())
    })
}

pub fn random_color() -> impl Strategy<Value = DVec3> {
    [random_positive(), random_positive(), random_positive()].prop_map(DVec3::from_array)
}

pub fn random_fractions() -> impl Strategy<Value = DVec3> {
    let one = 1e-9..=1.0;
    [one.clone(), one.clone(), one].prop_map(DVec3::from_array)
}

/// Returns a random name: bare, quoted, or easily mistaken for other syntax.
pub fn random_name() -> impl Strategy<Value = String> {
    prop_oneof!["[a-z_][a-z0-9_.-]{0,8}", "[a-z/{}\\[\\]#\" \\\\\u{e9}]{1,8}", "//x", "#x", "[^\r\n]{1,8}"]
}

pub fn random_corner_and_edges() -> impl Strategy<Value = (DVec3, DVec3, DVec3)> {
    (random_point(), random_direction(), random_direction())
        .prop_filter("no area", |(_, a, b)| a.normalize().cross(b.normalize()).length() > 1e-9)
}
