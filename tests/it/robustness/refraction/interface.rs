//! A single interface: the critical angle to the last bit, indices from 10⁻⁶ to 10⁶, and the choice
//! between lobes.

use crate::support::test_key;
use caustica::bsdf::{Bsdf, Dielectric, ThinDielectric, TransportMode, dielectric_reflectance_and_cosine, refract};
use caustica::math::{Frame, warp};
use caustica::sampling::Dimension;
use glam::{DVec3, Vec2, Vec3};

/// Returns a positive f32 as an exact integer in units of 2⁻³⁶. The value must be a multiple of
/// 2⁻³⁶.
fn to_fixed_point(x: f32) -> i128 {
    let (mantissa, exponent) = (i128::from(x.to_bits() & 0x7f_ffff | 0x80_0000), (x.to_bits() >> 23) as i32 - 150);
    mantissa << (exponent + 36)
}

/// Returns relative indices below 1, at which total internal reflection occurs.
///
/// They are indices of common glasses, and values that approach 1.
fn refractive_indices() -> impl Iterator<Item = f32> {
    let random = |i: u64| test_key(3).child_key(i).uniform_1d(Dimension::Light);
    (0..4000u64).map(move |i| match i % 3 {
        0 => 1.0 / (1.0 + 3.0 * random(i)),
        // From 10⁻⁷ to a tenth below 1, evenly by logarithm.
        1 => 1.0 - libm::powf(10.0, -1.0 - 6.0 * random(i)),
        _ => 1.0 - f32::EPSILON * 0.5 * (1 + i / 3) as f32,
    })
}

/// Total reflection begins at exactly the right cosine, to the last bit.
///
/// By Snell's law, the transmitted cosine is real if η² + cos² > 1. Squares of f32 are exact in
/// integers. So the right answer is known for each cosine within three ulps of the critical one.
#[test]
fn total_reflection_begins_at_exact_ulp() {
    let one = 1i128 << 72;
    let (mut total, mut not) = (0, 0);
    for eta in refractive_indices().filter(|eta| *eta < 1.0) {
        let critical = ((1.0 - f64::from(eta)) * (1.0 + f64::from(eta))).sqrt() as f32;
        for ulps in -3..=3i32 {
            let cos = f32::from_bits(critical.to_bits().wrapping_add_signed(ulps));
            // Cosines down to 2⁻¹² have their last bit at 2⁻³⁶.
            if !(1.0 / 4096.0..1.0).contains(&cos) {
                continue;
            }
            let real = to_fixed_point(eta) * to_fixed_point(eta) + to_fixed_point(cos) * to_fixed_point(cos) > one;
            let (reflectance, cos_t) = dielectric_reflectance_and_cosine(cos, eta);
            assert_eq!(cos_t > 0.0, real, "η = {eta:e}, cos = {cos:e}");
            assert!(if real { (0.0..=1.0).contains(&reflectance) } else { reflectance == 1.0 });
            *if real { &mut not } else { &mut total } += 1;
        }
    }
    assert!(total > 9000 && not > 9000, "{total} {not}");
}

/// Near the critical angle, refraction is finite and consistent.
///
/// Directions stay unit vectors on their side of the interface. Reflectance and transmittance sum
/// to 1. Transmittance grows as the root of the distance to the critical sine.
#[test]
fn fresnel_is_finite_around_critical_angle() {
    for i in 0..3000u64 {
        let key = test_key(4).child_key(i);
        let n = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightDirection));
        let eta = 1.0 / (1.05 + 2.0 * key.uniform_1d(Dimension::Light));
        let around = Frame::from_normal(n);
        let (sin_phi, cos_phi) = libm::sincosf(6.0 * key.uniform_1d(Dimension::Film));
        for step in -8..=8i32 {
            let sin = eta * (1.0 + step as f32 * f32::EPSILON);
            let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
            let wo = around.to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos)).normalize();
            let bent = refract(wo, n, eta);
            assert!((bent.reflectance + bent.transmittance - 1.0).abs() <= f32::EPSILON);
            // T < 4n cosθt/cosθi. cos²θt = 1 − sin²/η² is below twice the sum of the 24 ulps and
            // the roundings of wo and n.
            let most = 4.0 / eta * (2.0 * 24.0 * f32::EPSILON).sqrt() / cos;
            assert!(bent.transmittance <= most, "{} {most}", bent.transmittance);
            if bent.transmittance > 0.0 {
                // Components have relative rounding errors of 2⁻²⁴, and the incident direction has
                // length 1 within 2⁻²³. A direction in the plane may point above it by √3·2⁻²⁵.
                assert!((bent.transmitted.length() - 1.0).abs() < 2e-7 && bent.transmitted.dot(n) < 1e-7);
            }
            let s = Bsdf::Dielectric(Dielectric { eta: 1.0 / eta });
            for lobe in [0.0, 0.5, 1.0 - f32::EPSILON / 2.0] {
                // The path is inside, so the interface's outer normal points away from `wo`.
                let s = s.sample(wo, -n, -n, lobe, Vec2::ZERO, TransportMode::Radiance);
                assert!(s.is_some_and(|s| s.wi.is_finite() && s.weight.is_finite()), "{wo} {n} {eta}");
            }
        }
    }
}

/// Along the normal, the transmittance is T = 4n/(n+1)² from both sides. At n = 10⁶, the f32
/// difference 1 − R would have no correct digit.
#[test]
fn fresnel_keeps_precision_at_any_index() {
    for n in [1e-6f64, 1e-3, 0.5, 0.999, 1.000_1, 1.5, 2.4, 1e3, 1e6] {
        for eta in [n as f32, (1.0 / n) as f32] {
            let exact = f64::from(eta);
            let t = 4.0 * exact / ((1.0 + exact) * (1.0 + exact));
            let bent = refract(Vec3::Z, Vec3::Z, eta);
            // The transmittance is rounded only once, from f64.
            assert!((f64::from(bent.transmittance) / t - 1.0).abs() < 6.1e-8, "{eta}: {} {t}", bent.transmittance);
            assert!((f64::from(bent.reflectance) - (1.0 - t)).abs() < 6.1e-8);
            assert_eq!(bent.transmitted, -Vec3::Z);
            // A pane of two interfaces transmits t/(2 − t).
            let pane = ThinDielectric { eta, internal_transmittance: Vec3::ONE }.reflectance_and_transmittance(1.0);
            // Some eight roundings of 2⁻²⁴.
            assert!((f64::from(pane.1.x) / (t / (2.0 - t)) - 1.0).abs() < 8.0 / 16_777_216.0, "{eta}: {pane:?}");
            assert!((pane.0.x + pane.1.x - 1.0).abs() < 2.0 * f32::EPSILON);
        }
    }
}

/// A body of index 10⁶ transmits the right fraction of light.
///
/// Light leaves it only within 10⁻⁶ rad of the normal. All these directions have a cosine of 1 in
/// f32.
#[test]
fn densest_body_transmits_exact_fraction() {
    let eta = 1e-6f32;
    for (sin, sin_t) in
        [(0.0f32, Some(0.0f64)), (5e-7, Some(0.5)), (9.9e-7, Some(0.99)), (1.01e-6, None), (1e-5, None), (2e-4, None)]
    {
        let wo = Vec3::new(sin, 0.0, 1.0).normalize();
        assert_eq!(wo.z, 1.0);
        let bent = refract(wo, Vec3::Z, eta);
        match sin_t {
            // sin and η each have the relative rounding error 2⁻²⁴. tanθ = 7 amplifies the error at
            // sinθ = 0.99.
            Some(sin_t) => {
                assert!((f64::from(-bent.transmitted.x) - sin_t).abs() < 5e-7 && bent.transmittance > 0.0, "{bent:?}")
            }
            None => assert_eq!((bent.reflectance, bent.transmittance), (1.0, 0.0)),
        }
    }
    // From any incident direction, light enters within 10⁻⁶ rad of the normal. The result rounds by
    // √3·2⁻²⁵, and n has length 1 within 2⁻²³.
    for i in 0..1000u64 {
        let key = test_key(5).child_key(i);
        let n = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightDirection));
        let wo = Frame::from_normal(n)
            .to_world(warp::square_to_cosine_hemisphere(key.uniform_2d(Dimension::BsdfDirection)))
            .normalize();
        if wo.dot(n) > 0.0 {
            let bent = refract(wo, n, 1e6);
            assert!(bent.transmitted.dot(n) < 0.0 && (bent.transmitted + n).length() < 1e-6 + 5.0 / 16_777_216.0);
            // The transmittances of the polarisations are at most 4cosθ/η and 4/(η cosθ). The limit
            // is the mean of both.
            let cos = wo.dot(n);
            assert!(bent.transmittance > 0.0 && bent.transmittance <= 2.1e-6 * (cos + 1.0 / cos), "{bent:?}");
        }
    }
}

/// Refraction keeps n·sinθ (Snell's law) in both directions, from the smallest to the largest
/// index.
#[test]
fn refraction_keeps_the_sine_at_any_index() {
    for i in 0..20_000u64 {
        let key = test_key(6).child_key(i);
        let n = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::LightDirection));
        let wo = warp::square_to_uniform_sphere(key.uniform_2d(Dimension::BsdfDirection));
        let wo = if wo.dot(n) < 0.0 { -wo } else { wo };
        let eta = libm::powf(10.0, 6.0 * key.uniform_1d(Dimension::Light) - 3.0);
        let bent = refract(wo, n, eta);
        if bent.transmittance == 0.0 {
            continue;
        }
        let sin = |a: Vec3| {
            let (a, n): (DVec3, DVec3) = (a.as_dvec3(), n.as_dvec3());
            a.cross(n).length() / (a.length() * n.length())
        };
        // The result rounds by 2⁻²⁴ in each coordinate, and this error is multiplied by η.
        let slack = f64::from(f32::EPSILON) * (1.0 + f64::from(eta));
        assert!((f64::from(eta) * sin(bent.transmitted) - sin(wo)).abs() < slack, "{wo} {n} {eta}");
    }
}

/// The fraction of all 2²⁴ random numbers that choose a lobe is the lobe's probability.
///
/// If the transmittance is small, the weight makes the product exact to full precision. Otherwise,
/// one number at the threshold may be on either side.
#[test]
fn lobe_choice_matches_probability_over_all_numbers() {
    const STEPS: u32 = 1 << 24;
    for (eta, cos) in [
        (1e6f32, 1.0f32),
        (1e-6, 1.0),
        (1e3, 0.3),
        (1.5, 1.0),
        (1.5, 0.3),
        (1.5, 1e-3),
        (1.0 / 1.5, 0.7455),
        (1.000_1, 0.9),
    ] {
        let wo = Vec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
        let draw = |step: u32| {
            let glass = Bsdf::Dielectric(Dielectric { eta });
            glass
                .sample(wo, Vec3::Z, Vec3::Z, step as f32 / STEPS as f32, Vec2::ZERO, TransportMode::Importance)
                .unwrap()
        };
        // Small random numbers choose reflection.
        let (mut low, mut high) = (0, STEPS);
        while low < high {
            let middle = low + (high - low) / 2;
            if draw(middle).is_transmitted { high = middle } else { low = middle + 1 }
        }
        let bent = refract(wo, Vec3::Z, eta);
        let t = f64::from(bent.transmittance);
        let mean = f64::from(STEPS - low) / f64::from(STEPS) * f64::from(draw(STEPS - 1).weight.x);
        // A probability and its weight round by 2⁻²⁴ each, and so does their quotient.
        let slack = if t < 0.5 { 3.0 / 16_777_216.0 * t } else { 1.0 / f64::from(STEPS) };
        assert!((mean - t).abs() <= slack, "η = {eta}, cos = {cos}: {mean:e} {t:e}");
        let reflected = f64::from(low) / f64::from(STEPS);
        assert!((reflected - f64::from(bent.reflectance)).abs() <= 1.0 / f64::from(STEPS));
    }
}
