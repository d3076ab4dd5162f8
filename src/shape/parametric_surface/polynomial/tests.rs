use super::*;
use crate::sampling::{Dimension, Key, Purpose};

/// Pseudorandom number `i` in \[−1, 1].
fn random_signed(i: u64) -> f64 {
    f64::from(Key::new(8).purpose_key(Purpose::Test).child_key(i).uniform_1d(Dimension::LightPosition)) * 2.0 - 1.0
}

/// Pseudorandom control points of a plane Bézier curve.
fn random_bezier(degree: usize) -> Vec<Coefficient<2>> {
    (0..=degree as u64).map(|i| [random_signed(2 * i), random_signed(2 * i + 1)]).collect()
}

/// Point of a Bézier curve at the parameter `s` in \[0, 1], by de Casteljau's algorithm.
fn evaluate_by_de_casteljau(controls: &[Coefficient<2>], s: f64) -> Coefficient<2> {
    split_bezier(controls, s).1[0]
}

/// Evaluation in the power basis agrees with de Casteljau's algorithm.
///
/// Coefficients of degree 24 reach C(24, 12), so the error may reach as many ulps.
#[test]
fn power_basis_agrees_with_de_casteljau() {
    for degree in 1..=MAX_DEGREE {
        let controls = random_bezier(degree);
        let mut a = controls.clone();
        bernstein_to_power_basis(&mut a, 0, 1, degree);
        for i in 0..=20 {
            let x = f64::from(i) / 10.0 - 1.0;
            let ([px, py], slope) = evaluate_with_derivative(&a, x);
            let truth = evaluate_by_de_casteljau(&controls, 0.5 + 0.5 * x);
            let bound = f64::EPSILON * 4.0 * binomial_coefficient(degree, degree / 2);
            assert!((px - truth[0]).abs().max((py - truth[1]).abs()) < bound, "{degree} {x}");
            let step = 1e-5;
            let [before, after] = [x - step, x + step].map(|x| evaluate_with_derivative(&a, x).0);
            let difference = (after[0] - before[0]) / (2.0 * step);
            assert!((slope[0] - difference).abs() < 1e-6 * (1.0 + bound / f64::EPSILON), "{degree} {x}");
        }
    }
}

#[test]
fn reparametrized_polynomials_keep_their_values() {
    let mut a = random_bezier(7);
    bernstein_to_power_basis(&mut a, 0, 1, 7);
    let mut b = a.clone();
    reparametrize(&mut b, 0.25, 0.5);
    for i in 0..=10 {
        let x = f64::from(i) / 5.0 - 1.0;
        let (p, q) = (evaluate_with_derivative(&a, 0.25 + 0.5 * x).0, evaluate_with_derivative(&b, x).0);
        assert!((p[0] - q[0]).abs() < 1e-13 && (p[1] - q[1]).abs() < 1e-13);
    }
    let mut c = random_bezier(7);
    let mut d = c.clone();
    reparametrize(&mut c, -0.5, 0.25);
    reparametrize_rows(&mut d, 1, -0.5, 0.25);
    assert_eq!(c, d);
}

#[test]
fn tensor_products_evaluate_as_nested_curves() {
    let (p, q) = (3, 5);
    let mut a: Vec<Coefficient<1>> = (0..24).map(|i| [random_signed(i)]).collect();
    let rows = a.clone();
    (0..=p).for_each(|i| bernstein_to_power_basis(&mut a, i * (q + 1), 1, q));
    (0..=q).for_each(|j| bernstein_to_power_basis(&mut a, j, q + 1, p));
    let at = |x: f64, y: f64| {
        let column: Vec<Coefficient<1>> = rows.chunks(q + 1).map(|row| split_bezier(row, 0.5 + 0.5 * y).1[0]).collect();
        split_bezier(&column, 0.5 + 0.5 * x).1[0][0]
    };
    let (x, y, h) = (0.3, -0.6, 1e-6);
    let [[v], [vx], [vy]] = evaluate_2d_with_derivatives(&a, q + 1, x, y);
    assert!((v - at(x, y)).abs() < 1e-14);
    assert!((vx - (at(x + h, y) - at(x - h, y)) / (2.0 * h)).abs() < 1e-8);
    assert!((vy - (at(x, y + h) - at(x, y - h)) / (2.0 * h)).abs() < 1e-8);
}
