//! Fresnel's equations and Snell's law for unpolarised light at smooth interfaces.

use crate::color::Rgb;
use glam::{DVec3, Vec3};

/// Fresnel reflectance of a dielectric, and the cosine on the far side.
///
/// `cos_i ≥ 0` is the cosine on the near side, `eta` the far index over the near index. Total
/// internal reflection returns `(1, 0)`; an `eta` of 1 reflects exactly nothing. (Pharr, Jakob,
/// Humphreys 2023, section 9.3.5.)
#[inline]
#[must_use]
pub fn dielectric_reflectance(cos_i: f32, eta: f32) -> (f32, f32) {
    if eta == 1.0 {
        return (0.0, cos_i);
    }
    let (reflectance, cos_t) = reflectance_f64(f64::from(cos_i.clamp(0.0, 1.0)), f64::from(eta));
    (reflectance as f32, cos_t as f32)
}

/// [`dielectric_reflectance`] for a cosine in \[0, 1].
///
/// (η − 1)(η + 1) and cos² of f32 numbers are exact in f64. So their sum has the sign of cos²θt,
/// even within an ulp of the critical angle.
#[inline]
pub(super) fn reflectance_f64(cos_i: f64, eta: f64) -> (f64, f64) {
    let cos2_t = ((eta - 1.0) * (eta + 1.0) + cos_i * cos_i) / (eta * eta);
    if cos2_t <= 0.0 {
        return (1.0, 0.0);
    }
    let cos_t = cos2_t.sqrt();
    (reflectance_of(cos_i, cos_t, eta), cos_t)
}

/// Fresnel reflectance for two cosines that obey Snell's law.
#[inline]
fn reflectance_of(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Fresnel transmittance for two cosines that obey Snell's law: 1 − reflectance, without
/// cancellation.
#[inline]
pub(super) fn transmittance_f64(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let (parallel, perpendicular) = (eta * cos_i + cos_t, cos_i + eta * cos_t);
    2.0 * eta * cos_i * cos_t * (1.0 / (parallel * parallel) + 1.0 / (perpendicular * perpendicular))
}

/// Fresnel reflectance of a conductor with complex relative index `eta` + i`k`, per channel.
///
/// `cos_i ≥ 0` is the cosine outside. (Born and Wolf 1999, section 14.2; Pharr, Jakob, Humphreys
/// 2023, section 9.3.6.) With (a + ib)² = (η + ik)² − sin²θ, both polarisations are quotients of
/// sums of squares, in which nothing cancels.
#[inline]
#[must_use]
pub fn conductor_reflectance(cos_i: f32, eta: Rgb, k: Rgb) -> Rgb {
    // A cosine of exactly 0 would lead to 0/0 at index 1.
    let cos = cos_i.clamp(1e-6, 1.0);
    let sin2 = (1.0 - cos) * (1.0 + cos);
    let channel = |eta: f32, k: f32| {
        let (real, half_imaginary) = (eta * eta - k * k - sin2, eta * k);
        let modulus = (real * real + 4.0 * half_imaginary * half_imaginary).sqrt();
        // One of a² = (modulus + real)/2 and b² = (modulus − real)/2 cancels; it follows from a·b =
        // ηk.
        let larger = 0.5 * (modulus + real.abs());
        let smaller = if larger > 0.0 { half_imaginary * half_imaginary / larger } else { 0.0 };
        let (a2, b2) = if real > 0.0 { (larger, smaller) } else { (smaller, larger) };
        let a = a2.sqrt();
        let quotient = |x: f32, y: f32, z2: f32| {
            let (minus, plus) = ((x - y) * (x - y) + z2, (x + y) * (x + y) + z2);
            if plus > 0.0 { minus / plus } else { 1.0 }
        };
        let perpendicular = quotient(a, cos, b2);
        // The quotient of parallel and perpendicular reflectance, without tangents.
        0.5 * perpendicular * (1.0 + quotient(a * cos, sin2, b2 * cos * cos))
    };
    Rgb::new(channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z))
}

/// Reflection and refraction at an interface.
#[derive(Clone, Copy, Debug)]
pub struct Refraction {
    /// Fresnel reflectance.
    pub reflectance: f32,
    /// Fresnel transmittance, accurate even if tiny; 0 under total internal reflection.
    pub transmittance: f32,
    /// Unit direction of the refracted ray; undefined if `transmittance` is 0.
    pub transmitted: Vec3,
}

/// Refraction by Snell's law.
///
/// `wo` points away from the interface on the side of `n`; `eta` is the far index over the near
/// index. The sine comes from the cross product. Towards an index of 10⁶ light leaves within 10⁻⁶
/// rad of the normal, where a cosine in f32 is 1.
#[inline]
#[must_use]
pub fn refract(wo: Vec3, n: Vec3, eta: f32) -> Refraction {
    if eta == 1.0 {
        return Refraction { reflectance: 0.0, transmittance: 1.0, transmitted: -wo };
    }
    let (o, n, eta) = (wo.as_dvec3(), n.as_dvec3(), f64::from(eta));
    let (dot, cross2, n2) = (o.dot(n), o.cross(n).length_squared(), n.length_squared());
    let all2 = dot * dot + cross2;
    let (cos2, sin2) = (dot * dot / all2, cross2 / all2);
    // A small sine is accurate in its square, a large one in the cosine.
    let cos2_t = if sin2 < 0.5 { eta * eta - sin2 } else { (eta - 1.0) * (eta + 1.0) + cos2 } / (eta * eta);
    if cos2_t.is_nan() || cos2_t <= 0.0 {
        return Refraction { reflectance: 1.0, transmittance: 0.0, transmitted: (-n).as_vec3() };
    }
    let (cos_i, cos_t) = (cos2.sqrt(), cos2_t.sqrt());
    let transmitted: DVec3 = (n * (dot / n2) - o) / eta - n * cos_t;
    Refraction {
        reflectance: reflectance_of(cos_i, cos_t, eta) as f32,
        transmittance: transmittance_f64(cos_i, cos_t, eta) as f32,
        transmitted: transmitted.normalize().as_vec3(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// analytic-truths 12: normal incidence, Brewster's angle, and both hemispherical means at n =
    /// 1.5.
    #[test]
    fn reflectance_matches_closed_forms() {
        let n = 1.5f32;
        let (r, cos_t) = dielectric_reflectance(1.0, n);
        assert!((r - 0.04).abs() < 1e-7 && cos_t == 1.0);
        // At Brewster's angle only the perpendicular part is reflected: ((n² − 1)/(n² + 1))²/2.
        let brewster = libm::cosf(libm::atanf(n));
        let expected = 0.5 * (1.25f32 / 3.25) * (1.25 / 3.25);
        assert!((dielectric_reflectance(brewster, n).0 - expected).abs() < 1e-6);
        // ∫ R 2cosθ dcosθ by midpoints: the slope of the integrand is bounded, so the error is
        // below 10⁻⁶.
        let hemispherical = |eta: f32| {
            let steps = 1_000_000;
            (0..steps)
                .map(|i| {
                    let c = (i as f32 + 0.5) / steps as f32;
                    f64::from(dielectric_reflectance(c, eta).0 * 2.0 * c)
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
        assert!((critical.acos_degrees() - 41.8103).abs() < 1e-4);
        let below = (critical as f32).next_up().next_up();
        let above = (critical as f32).next_down().next_down();
        assert!(dielectric_reflectance(below, eta).0 < 1.0);
        assert_eq!(dielectric_reflectance(above, eta), (1.0, 0.0));
    }

    /// Closed forms at normal and grazing incidence, and a dielectric's without absorption.
    /// Between, the moduli of the complex coefficients, by complex arithmetic in f64.
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
                // A dozen operations in f32, each within half an ulp of numbers up to 1.
                assert!((f64::from(at(cos, eta, k)) - expected).abs() < 1e-6, "{eta} {k} at {cos}: {expected}");
                if k == 0.0 {
                    assert!((at(cos, eta, k) - dielectric_reflectance(cos, eta).0).abs() < 1e-6);
                }
            }
            assert!(at(0.0, eta, k) > 1.0 - 1e-4 || (eta, k) == (1.0, 0.0));
        }
        for cos in [0.0, 0.3, 1.0] {
            assert_eq!((at(cos, 0.0, 1.0), at(cos, 0.0, 0.0)), (1.0, 1.0), "no real part, no loss");
        }
    }

    trait Degrees {
        fn acos_degrees(self) -> f64;
    }
    impl Degrees for f64 {
        fn acos_degrees(self) -> f64 {
            libm::acos(self).to_degrees()
        }
    }

    #[test]
    fn an_index_of_one_changes_nothing() {
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
            // Each refraction rounds its direction by a few ulps; Snell's law magnifies that by
            // 1/cosθ.
            let error = (back.transmitted - wo).length();
            assert!(error < 8.0 * f32::EPSILON / cos, "{i}: {error}");
            let (f, b) = (there.reflectance, dielectric_reflectance(there.transmitted.dot(-n), 1.0 / 1.5).0);
            assert!((f - b).abs() < 2e-6 / cos, "{i}: {f} {b}");
        }
    }
}
