//! Fresnel's equations and Snell's law for unpolarised light at a smooth dielectric interface.

use glam::Vec3;

/// Fraction of light reflected where `cos_i ≥ 0` is the cosine on the incident side and `eta` the index of the far side
/// over that of the near side; with the cosine on the far side. Total internal reflection gives `(1, 0)`.
///
/// An `eta` of 1 reflects nothing, exactly. (Pharr, Jakob, Humphreys 2023, section 9.3.5.)
#[inline]
#[must_use]
pub fn dielectric_reflectance(cos_i: f32, eta: f32) -> (f32, f32) {
    if eta == 1.0 {
        return (0.0, cos_i);
    }
    // In f64, so that within an ulp of the critical angle the sign of cos²θt is that of the inputs.
    let (cos_i, eta) = (f64::from(cos_i.clamp(0.0, 1.0)), f64::from(eta));
    let cos2_t = 1.0 - (1.0 - cos_i * cos_i) / (eta * eta);
    if cos2_t <= 0.0 {
        return (1.0, 0.0);
    }
    let cos_t = cos2_t.sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    ((0.5 * (parallel * parallel + perpendicular * perpendicular)) as f32, cos_t as f32)
}

/// Both continuations of a ray at an interface.
#[derive(Clone, Copy, Debug)]
pub struct Refraction {
    /// Fraction reflected.
    pub reflectance: f32,
    /// Unit direction of the transmitted ray; meaningless where `reflectance` is 1.
    pub transmitted: Vec3,
}

/// Snell's law: `wo` points away from the interface on the side of `n`; `eta` is the far index over the near one.
#[inline]
#[must_use]
pub fn refract(wo: Vec3, n: Vec3, eta: f32) -> Refraction {
    let cos_i = wo.dot(n);
    let (reflectance, cos_t) = dielectric_reflectance(cos_i, eta);
    if eta == 1.0 {
        return Refraction { reflectance, transmitted: -wo };
    }
    let transmitted = (n * cos_i - wo) / eta - n * cos_t;
    Refraction { reflectance, transmitted: transmitted.normalize_or(-n) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// analytic-truths 12: normal incidence, Brewster's angle, and both hemispherical means at n = 1.5.
    #[test]
    fn reflectance_matches_closed_forms() {
        let n = 1.5f32;
        let (r, cos_t) = dielectric_reflectance(1.0, n);
        assert!((r - 0.04).abs() < 1e-7 && cos_t == 1.0);
        // At Brewster's angle only the perpendicular part returns: ((n² − 1)/(n² + 1))²/2.
        let brewster = libm::cosf(libm::atanf(n));
        let expected = 0.5 * (1.25f32 / 3.25) * (1.25 / 3.25);
        assert!((dielectric_reflectance(brewster, n).0 - expected).abs() < 1e-6);
        // ∫ R 2cosθ dcosθ by midpoints: the integrand's slope is bounded, so the error is below 10⁻⁶.
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
            // Each refraction rounds its direction by a few ulps; Snell's slope magnifies that by 1/cosθ towards grazing.
            let error = (back.transmitted - wo).length();
            assert!(error < 8.0 * f32::EPSILON / cos, "{i}: {error}");
            let (f, b) = (there.reflectance, dielectric_reflectance(there.transmitted.dot(-n), 1.0 / 1.5).0);
            assert!((f - b).abs() < 2e-6 / cos, "{i}: {f} {b}");
        }
    }
}
