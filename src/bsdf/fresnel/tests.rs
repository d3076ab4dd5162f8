//! Tests of Fresnel's equations and Snell's law.

use super::*;

/// The reflectance at index 1.5 agrees with closed forms: at normal incidence, at Brewster's angle,
/// and averaged over the hemisphere on either side.
#[test]
fn reflectance_matches_closed_forms() {
    let n = 1.5f32;
    let (r, cos_t) = dielectric_reflectance_and_cosine(1.0, n);
    assert!((r - 0.04).abs() < 1e-7 && cos_t == 1.0);
    // At Brewster's angle only the perpendicular part is reflected: ((n² − 1)/(n² + 1))²/2.
    let brewster = libm::cosf(libm::atanf(n));
    let expected = 0.5 * (1.25f32 / 3.25) * (1.25 / 3.25);
    assert!((dielectric_reflectance_and_cosine(brewster, n).0 - expected).abs() < 1e-6);
    // ∫ R 2cosθ dcosθ by midpoints: the slope of the integrand is bounded, so the error is
    // below 10⁻⁶.
    let hemispherical = |eta: f32| {
        let steps = 1_000_000;
        (0..steps)
            .map(|i| {
                let c = (i as f32 + 0.5) / steps as f32;
                f64::from(dielectric_reflectance_and_cosine(c, eta).0 * 2.0 * c)
            })
            .sum::<f64>()
            / f64::from(steps)
    };
    assert!((hemispherical(1.5) - 0.091_778_0).abs() < 1e-6);
    assert!((hemispherical(1.0 / 1.5) - 0.596_346).abs() < 2e-6);
}

#[test]
fn the_critical_angle_divides_transmission_from_reflection() {
    let eta = 1.0f32 / 1.5;
    let critical = (1.0 - f64::from(eta) * f64::from(eta)).sqrt();
    assert!((libm::acos(critical).to_degrees() - 41.8103).abs() < 1e-4);
    let below = (critical as f32).next_up().next_up();
    let above = (critical as f32).next_down().next_down();
    assert!(dielectric_reflectance_and_cosine(below, eta).0 < 1.0);
    assert_eq!(dielectric_reflectance_and_cosine(above, eta), (1.0, 0.0));
}

/// The reflectance of metals agrees with closed forms at normal and grazing incidence, and with a
/// dielectric if absorption is 0.
///
/// At other angles, the expected values come from the complex Fresnel coefficients, computed in
/// f64.
#[test]
fn conductors_match_closed_and_complex_forms() {
    let at = |cos: f32, eta: f32, k: f32| conductor_reflectance(cos, Rgb::splat(eta), Rgb::splat(k)).x;
    let complex = |cos: f64, eta: f64, k: f64| {
        let (re, im) = (eta * eta - k * k - (1.0 - cos * cos), 2.0 * eta * k);
        let (modulus, angle) = (libm::hypot(re, im).sqrt(), 0.5 * libm::atan2(im, re));
        let root = (modulus * libm::cos(angle), modulus * libm::sin(angle));
        let quotient2 = |n: (f64, f64), d: (f64, f64)| (n.0 * n.0 + n.1 * n.1) / (d.0 * d.0 + d.1 * d.1);
        let s = quotient2((cos - root.0, -root.1), (cos + root.0, root.1));
        let m2 = ((eta * eta - k * k) * cos, 2.0 * eta * k * cos);
        let p = quotient2((m2.0 - root.0, m2.1 - root.1), (m2.0 + root.0, m2.1 + root.1));
        0.5 * (s + p)
    };
    for (eta, k) in [(0.2f32, 3.9129f32), (1.1022, 2.1421), (0.05, 4.2), (2.95, 2.93), (1.5, 0.0), (1.0, 0.3)] {
        let normal = ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k);
        assert!((at(1.0, eta, k) - normal).abs() < 1e-6, "{eta} {k}");
        for i in 1..100 {
            let cos = i as f32 / 100.0;
            let expected = complex(f64::from(cos), f64::from(eta), f64::from(k));
            // About twelve f32 operations on numbers up to 1 have this error.
            assert!((f64::from(at(cos, eta, k)) - expected).abs() < 1e-6, "{eta} {k} at {cos}: {expected}");
            if k == 0.0 {
                assert!((at(cos, eta, k) - dielectric_reflectance_and_cosine(cos, eta).0).abs() < 1e-6);
            }
        }
        assert!(at(0.0, eta, k) > 1.0 - 1e-4 || (eta, k) == (1.0, 0.0));
    }
    for cos in [0.0, 0.3, 1.0] {
        assert_eq!((at(cos, 0.0, 1.0), at(cos, 0.0, 0.0)), (1.0, 1.0), "no real part, no loss");
    }
}

#[test]
fn an_index_of_one_neither_reflects_nor_refracts() {
    let wo = Vec3::new(0.3, 0.1, 0.6).normalize();
    let r = refract(wo, Vec3::Z, 1.0);
    assert_eq!((r.reflectance, r.transmitted), (0.0, -wo));
}

#[test]
fn refraction_obeys_snell_and_reverses() {
    let n = Vec3::Y;
    for i in 1..90 {
        let (sin, cos) = libm::sincosf((i as f32).to_radians());
        let wo = Vec3::new(sin, cos, 0.0);
        let there = refract(wo, n, 1.5);
        assert!((there.transmitted.x * 1.5 + sin).abs() < 1e-6 && there.transmitted.y < 0.0);
        let back = refract(there.transmitted, -n, 1.0 / 1.5);
        // Each refraction rounds its direction by a few ulps. Snell's law magnifies this error by
        // 1/cosθ.
        let error = (back.transmitted - wo).length();
        assert!(error < 8.0 * f32::EPSILON / cos, "{i}: {error}");
        let (f, b) = (there.reflectance, dielectric_reflectance_and_cosine(there.transmitted.dot(-n), 1.0 / 1.5).0);
        assert!((f - b).abs() < 2e-6 / cos, "{i}: {f} {b}");
    }
}
