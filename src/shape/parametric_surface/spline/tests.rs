use super::super::polynomial::split_bezier;
use super::*;

/// Value of B-spline basis function `i` of degree `p` at `t`, by the Cox–de Boor recurrence.
fn cox_de_boor(knots: &[f64], i: usize, p: usize, t: f64) -> f64 {
    if p == 0 {
        return f64::from(knots[i] <= t && t < knots[i + 1]);
    }
    let part = |numerator: f64, denominator: f64, i: usize| {
        if denominator > 0.0 { numerator / denominator * cox_de_boor(knots, i, p - 1, t) } else { 0.0 }
    };
    part(t - knots[i], knots[i + p] - knots[i], i) + part(knots[i + p + 1] - t, knots[i + p + 1] - knots[i + 1], i + 1)
}

#[test]
fn bezier_pieces_match_the_spline_recurrence() {
    let cases = [
        (3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 3.5, 4.0, 4.0, 4.0, 4.0]),
        (2, vec![-1.0, 0.0, 0.5, 2.0, 3.0, 3.25, 7.0]),
        (1, vec![0.0, 1.0, 2.0, 3.0]),
        (5, (0..13).map(f64::from).collect()),
    ];
    for (p, knots) in cases {
        let n = knots.len() - p - 1;
        let controls: Vec<Coefficient<1>> = (0..n).map(|i| [libm::sin(3.0 * i as f64)]).collect();
        let basis = SplineBasis::new(p, n, knots.clone()).unwrap();
        let (first, last) = (knots[p], knots[n]);
        let mut end = 0.0;
        for span in basis.knot_spans() {
            assert_eq!(span.range[0], end);
            end = span.range[1];
            let piece = basis.bezier_control_points(span, &controls, (0, 1));
            for s in [0.0, 0.1, 0.5, 0.9] {
                let t = first + (span.range[0] + s * (span.range[1] - span.range[0])) * (last - first);
                let truth: f64 = (0..n).map(|i| controls[i][0] * cox_de_boor(&knots, i, p, t)).sum();
                assert!((split_bezier(&piece, s).1[0][0] - truth).abs() < 1e-13, "{p} {t}");
            }
        }
        assert_eq!(end, 1.0);
    }
}

#[test]
fn bezier_curves_form_one_piece() {
    let controls = [[1.0], [5.0], [-2.0]];
    let basis = SplineBasis::bezier_basis(3).unwrap();
    let spans: Vec<KnotSpan> = basis.knot_spans().collect();
    assert_eq!((spans.len(), spans[0].range), (1, [0.0, 1.0]));
    assert_eq!(basis.bezier_control_points(spans[0], &controls, (0, 1)), controls);
}

#[test]
fn invalid_splines_are_refused() {
    let knots = |k: &[f64]| k.to_vec();
    assert_eq!(SplineBasis::bezier_basis(1), Err(SplineError::InvalidDegree(0)));
    assert_eq!(SplineBasis::bezier_basis(99), Err(SplineError::InvalidDegree(98)));
    assert_eq!(
        SplineBasis::uniform_spline_basis(3, 3),
        Err(SplineError::TooFewControlPoints { controls: 3, degree: 3 })
    );
    assert_eq!(
        SplineBasis::new(1, 2, knots(&[0.0, 1.0])),
        Err(SplineError::WrongKnotCount { knots: 2, controls: 2, degree: 1 })
    );
    assert_eq!(SplineBasis::new(1, 2, knots(&[0.0, 1.0, 0.5, 2.0])), Err(SplineError::DecreasingKnots(2)));
    assert_eq!(
        SplineBasis::new(1, 2, knots(&[0.0, 1.0, 1.0, 2.0])),
        Err(SplineError::EmptyKnotRange { first: 1, last: 2 })
    );
    assert_eq!(SplineBasis::new(1, 2, knots(&[0.0, 1.0, 2.0, f64::NAN])), Err(SplineError::TooLarge));
    assert_eq!(SplineBasis::new(1, 3, knots(&[0.0, 0.0, 1e-7, 1.0, 1.0])), Err(SplineError::NarrowKnotSpan(1)));
    assert_eq!(SplineBasis::new(1, 3, knots(&[0.0, 3.0, 4e7 - 3.0, 4e7, 5e7])), Err(SplineError::NarrowKnotSpan(2)));
    assert!(SplineBasis::new(1, 3, knots(&[0.0, 0.0, MIN_RELATIVE_KNOT_SPAN, 1.0, 1.0])).is_ok());
}
