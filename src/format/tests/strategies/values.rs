//! Random numbers, vectors, names and transform steps.

use glam::{DMat4, DVec2, DVec3};
use proptest::prelude::*;

use crate::format::description::{Span, Spanned, TransformStep};

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

pub fn random_vec2() -> impl Strategy<Value = DVec2> {
    [random_finite_number(), random_finite_number()].prop_map(DVec2::from_array)
}

pub fn random_transform_step() -> impl Strategy<Value = TransformStep> {
    let scale = || prop_oneof![0.01..100.0, -100.0..-0.01];
    let angle = || -1e3..1e3;
    prop_oneof![
        [scale(), scale(), scale()].prop_map(|s| TransformStep::Scale(DVec3::from_array(s))),
        scale().prop_map(TransformStep::UniformScale),
        random_direction().prop_map(TransformStep::Translate),
        angle().prop_map(TransformStep::RotateX),
        angle().prop_map(TransformStep::RotateY),
        angle().prop_map(TransformStep::RotateZ),
        (random_direction(), angle()).prop_map(|(axis, angle)| TransformStep::Rotate { axis, angle }),
        ([scale(), scale(), scale()], random_direction()).prop_map(|(s, t)| {
            TransformStep::Matrix(DMat4::from_translation(t) * DMat4::from_scale(DVec3::from_array(s)))
        }),
    ]
}

/// Returns a random step of a motion. If `scales` is false, it is no scale.
pub fn random_motion_step(scales: bool) -> impl Strategy<Value = TransformStep> {
    random_transform_step().prop_filter("cannot grow", move |map| match *map {
        TransformStep::Matrix(_) => false,
        TransformStep::Scale(s) => scales && s.min_element() > 0.0,
        TransformStep::UniformScale(s) => scales && s > 0.0,
        _ => true,
    })
}

pub fn with_empty_span<T>(value: T) -> Spanned<T> {
    Spanned::new(value, Span::default())
}
