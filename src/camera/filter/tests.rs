//! Tests of reconstruction filters.

use super::*;

/// Compares second moments of samples with 1/12 (box), 1/6 (tent) and quadrature.
///
/// The tolerance is the error of the first and last interval of the quantile table, where it is
/// greatest. Each holds 1/1024 of the samples, at offsets x from at least 1 to at most 1.5 pixels.
/// Interpolation changes x² by at most (1.5² − 1)/2 there, and so the moment by at most 1.2·10⁻³.
#[test]
fn filter_second_moments_match_quadrature() {
    let n = 100_000;
    let second = |kind: FilterKind| {
        let f = Filter::new(kind);
        (0..n).map(|i| f64::from(f.sample_axis_offset((i as f32 + 0.5) / n as f32))).map(|x| x * x).sum::<f64>()
            / f64::from(n)
    };
    let quadrature = |kind: FilterKind| {
        let r = kind.radius();
        let xs = (0..n).map(|i| r * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0));
        let (w, wx2) = xs.fold((0.0, 0.0), |(a, b), x| {
            (a + kind.unnormalized_axis_value(x), b + kind.unnormalized_axis_value(x) * x * x)
        });
        wx2 / w
    };
    assert!((second(FilterKind::Box) - 1.0 / 12.0).abs() < 1.2e-3);
    assert!((second(FilterKind::Tent) - 1.0 / 6.0).abs() < 1.2e-3);
    for kind in [FilterKind::Gaussian, FilterKind::BlackmanHarris] {
        let (a, b) = (second(kind), quadrature(kind));
        assert!((a - b).abs() < 1.2e-3, "{kind:?}: {a} {b}");
    }
}

/// Checks that the mean weight is 1, and that weighted samples have the moments of the filter.
///
/// The tolerance is the error of 2¹⁸ independent points. The Sobol' points used here have much
/// smaller errors.
#[test]
fn signed_filter_weights_average_one() {
    use crate::sampling::{Dimension, Key, Purpose, sobol_2d};
    let n = 1 << 18;
    let key = Key::new(3).purpose_key(Purpose::Test);
    let filter = Filter::new(FilterKind::Mitchell);
    let xs: Vec<f64> = (0..4000).map(|i| -2.0 + (f64::from(i) + 0.5) / 1000.0).collect();
    let total: f64 = xs.iter().map(|x| FilterKind::Mitchell.unnormalized_axis_value(*x)).sum();
    let within =
        xs.iter().filter(|x| **x > 0.3).map(|x| FilterKind::Mitchell.unnormalized_axis_value(*x)).sum::<f64>() / total;
    let (mut weight, mut right, mut negative) = (0.0, 0.0, 0);
    for i in 0..n {
        let sample = filter.sample(sobol_2d(i, key, Dimension::Film));
        weight += f64::from(sample.weight);
        right += if sample.offset.x > 0.3 { f64::from(sample.weight) } else { 0.0 };
        negative += u32::from(sample.weight < 0.0);
    }
    let (weight, right) = (weight / f64::from(n), right / f64::from(n));
    let bound = 2.0 * 5.0 / f64::from(n).sqrt();
    assert!((weight - 1.0).abs() < bound && (right - within).abs() < bound, "{weight} {right} {within}");
    assert!(filter.has_negative_values() && negative > 0 && !Filter::new(FilterKind::Gaussian).has_negative_values());
}

#[test]
fn filter_offsets_are_within_the_radius() {
    for kind in
        [FilterKind::Box, FilterKind::Tent, FilterKind::Gaussian, FilterKind::BlackmanHarris, FilterKind::Mitchell]
    {
        let f = Filter::new(kind);
        let r = kind.radius() as f32;
        assert!(f.sample_axis_offset(0.0) >= -r && f.sample_axis_offset(1.0 - f32::EPSILON / 2.0) <= r);
    }
    assert!("lanczos".parse::<FilterKind>().unwrap_err().to_string().contains("blackman-harris"));
}

/// Checks that normalized filter values have integral 1 and the second moment of the filter, and
/// vanish beyond the radius.
///
/// The error of linear interpolation between 256 values is below 10⁻⁴ for these filters. No
/// midpoint lies on the jump of the box filter at its radius.
#[test]
fn normalized_values_have_integral_one() {
    let kinds =
        [FilterKind::Box, FilterKind::Tent, FilterKind::Gaussian, FilterKind::BlackmanHarris, FilterKind::Mitchell];
    for kind in kinds {
        let filter = Filter::new(kind);
        let n = 40_000;
        let r = kind.radius();
        let xs = || (0..n).map(|i| r * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0));
        let step = 2.0 * r / f64::from(n);
        let normalized_value = |x: f64| f64::from(filter.normalized_axis_value(x as f32)) * step;
        let integral = xs().map(normalized_value).sum::<f64>();
        let second_moment = xs().map(|x| x * x * normalized_value(x)).sum::<f64>();
        let weights: f64 = xs().map(|x| kind.unnormalized_axis_value(x)).sum();
        let second = xs().map(|x| x * x * kind.unnormalized_axis_value(x)).sum::<f64>() / weights;
        assert!((integral - 1.0).abs() < 1e-4, "{kind:?}: {integral}");
        assert!((second_moment - second).abs() < 1e-4, "{kind:?}: {second_moment} {second}");
        assert_eq!(filter.normalized_axis_value(filter.radius()), 0.0);
        assert_eq!(filter.normalized_axis_value(0.3), filter.normalized_axis_value(-0.3));
    }
}

/// The pdf of offsets has integral 1, and its integral over a quarter plane is the fraction of
/// samples there. The pdf is piecewise constant, so the error of the midpoint rule is about the
/// integral over one step.
#[test]
fn filter_offsets_follow_their_pdf() {
    let n = 20_000;
    for kind in [FilterKind::Box, FilterKind::Tent, FilterKind::BlackmanHarris, FilterKind::Mitchell] {
        let f = Filter::new(kind);
        let step = 2.0 * f.radius() / n as f32;
        let offset = |i: i32| (i as f32 + 0.5) * step - f.radius();
        let integral = |below: f32| {
            (0..n).map(offset).filter(|x| *x < below).map(|x| f64::from(f.axis_offset_pdf(x) * step)).sum::<f64>()
        };
        let samples = (0..n).map(|i| f.sample_axis_offset((i as f32 + 0.5) / n as f32));
        let within = samples.filter(|x| *x < 0.3).count() as f64 / f64::from(n);
        assert!((integral(f32::INFINITY) - 1.0).abs() < 1e-3, "{kind:?}: {}", integral(f32::INFINITY));
        assert!((integral(0.3) - within).abs() < 1e-3, "{kind:?}: {} {within}", integral(0.3));
        assert_eq!(f.sample_pdf(Vec2::new(0.1, f.radius() + 0.01)), 0.0);
        let both = f.sample_pdf(Vec2::new(0.1, -0.2));
        assert_eq!(both, f.axis_offset_pdf(0.1) * f.axis_offset_pdf(-0.2));
    }
}
