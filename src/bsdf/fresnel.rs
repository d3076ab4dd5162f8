//! Fresnel's equations and Snell's law, for unpolarized light.

use crate::color::Rgb;
use glam::{DVec3, Vec3};

/// Returns the Fresnel reflectance of a dielectric, and the cosine between the refracted ray and
/// the normal.
///
/// `cos_i` ≥ 0 is the cosine of incidence. `eta` is the refractive index of the far side, relative
/// to the near side. Under total internal reflection, the result is `(1, 0)`. Source: Pharr, Jakob,
/// Humphreys 2023, section 9.3.5.
#[inline]
#[must_use]
pub fn dielectric_reflectance_and_cosine(cos_i: f32, eta: f32) -> (f32, f32) {
    if eta == 1.0 {
        return (0.0, cos_i);
    }
    let (reflectance, cos_t) = fresnel_reflectance_and_cosine(f64::from(cos_i.clamp(0.0, 1.0)), f64::from(eta));
    (reflectance as f32, cos_t as f32)
}

/// Computes [`dielectric_reflectance_and_cosine`] in f64: the reflectance, and the cosine of
/// refraction.
///
/// `cos_i` in \[0, 1] is the cosine of incidence. `eta` is the refractive index of the far side,
/// relative to the near side. Under total internal reflection, the result is `(1, 0)`.
#[inline]
pub(super) fn fresnel_reflectance_and_cosine(cos_i: f64, eta: f64) -> (f64, f64) {
    // If `cos_i` and `eta` were converted from f32, both products are exact. So the sum has the
    // right sign even if `cos_i` is within an ulp of the critical angle's cosine.
    let cos2_t = ((eta - 1.0) * (eta + 1.0) + cos_i * cos_i) / (eta * eta);
    if cos2_t <= 0.0 {
        return (1.0, 0.0);
    }
    let cos_t = cos2_t.sqrt();
    (fresnel_reflectance_from_cosines(cos_i, cos_t, eta), cos_t)
}

/// Fresnel reflectance from the cosines of incidence `cos_i` and of refraction `cos_t`.
///
/// `eta` is the refractive index of the far side, relative to the near side.
#[inline]
fn fresnel_reflectance_from_cosines(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Fresnel transmittance from the cosines of incidence `cos_i` and of refraction `cos_t`.
///
/// `eta` is the refractive index of the far side, relative to the near side. The transmittance
/// equals 1 − reflectance, but it keeps its digits where it is near 0.
#[inline]
pub(super) fn fresnel_transmittance(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let (parallel, perpendicular) = (eta * cos_i + cos_t, cos_i + eta * cos_t);
    2.0 * eta * cos_i * cos_t * (1.0 / (parallel * parallel) + 1.0 / (perpendicular * perpendicular))
}

/// Fresnel reflectance of a conductor with the complex refractive index `eta` + i`k`, by channel.
///
/// The index is relative to the surroundings. `cos_i` ≥ 0 is the cosine of incidence. Sources: Born
/// and Wolf 1999, section 14.2; Pharr, Jakob, Humphreys 2023, section 9.3.6.
#[inline]
#[must_use]
pub fn conductor_reflectance(cos_i: f32, eta: Rgb, k: Rgb) -> Rgb {
    // With (a + ib)² = (η + ik)² − sin²θ, both polarizations are quotients of sums of squares.
    // A cosine of exactly 0 would lead to 0/0 at index 1.
    let cos = cos_i.clamp(1e-6, 1.0);
    let sin2 = (1.0 - cos) * (1.0 + cos);
    let channel = |eta: f32, k: f32| {
        let (real, half_imaginary) = (eta * eta - k * k - sin2, eta * k);
        let modulus = (real * real + 4.0 * half_imaginary * half_imaginary).sqrt();
        // a² = (modulus + real)/2 and b² = (modulus − real)/2. In the smaller of the two, digits
        // would cancel, so it is computed from a·b = ηk.
        let larger = 0.5 * (modulus + real.abs());
        let smaller = if larger > 0.0 { half_imaginary * half_imaginary / larger } else { 0.0 };
        let (a2, b2) = if real > 0.0 { (larger, smaller) } else { (smaller, larger) };
        let a = a2.sqrt();
        let quotient = |x: f32, y: f32, z2: f32| {
            let (minus, plus) = ((x - y) * (x - y) + z2, (x + y) * (x + y) + z2);
            if plus > 0.0 { minus / plus } else { 1.0 }
        };
        let perpendicular = quotient(a, cos, b2);
        // The second quotient is parallel over perpendicular reflectance, in a form without
        // tangents.
        0.5 * perpendicular * (1.0 + quotient(a * cos, sin2, b2 * cos * cos))
    };
    Rgb::new(channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z))
}

/// The refracted direction at a smooth interface, with the Fresnel reflectance and transmittance.
#[derive(Clone, Copy, Debug)]
pub struct Refraction {
    /// Fresnel reflectance.
    pub reflectance: f32,
    /// Fresnel transmittance; 0 under total internal reflection.
    pub transmittance: f32,
    /// Unit direction of the refracted ray; undefined if `transmittance` is 0.
    pub transmitted: Vec3,
}

/// Refracts unit direction `wo` at a smooth interface by Snell's law.
///
/// `wo` points away from the interface, on the side of the normal `n`. `eta` is the refractive
/// index of the far side, relative to the side of `wo`.
#[inline]
#[must_use]
pub fn refract(wo: Vec3, n: Vec3, eta: f32) -> Refraction {
    if eta == 1.0 {
        return Refraction { reflectance: 0.0, transmittance: 1.0, transmitted: -wo };
    }
    let (o, n, eta) = (wo.as_dvec3(), n.as_dvec3(), f64::from(eta));
    // The sine comes from the cross product. If `eta` is 10⁶, light leaves within 10⁻⁶ rad of the
    // normal, where the cosine in f32 is 1.
    let (dot, cross2, n2) = (o.dot(n), o.cross(n).length_squared(), n.length_squared());
    let all2 = dot * dot + cross2;
    let (cos2, sin2) = (dot * dot / all2, cross2 / all2);
    // The sum is computed from sin² below 45°, and from cos² above, as the smaller of the two is
    // more accurate.
    let cos2_t = if sin2 < 0.5 { eta * eta - sin2 } else { (eta - 1.0) * (eta + 1.0) + cos2 } / (eta * eta);
    if cos2_t.is_nan() || cos2_t <= 0.0 {
        return Refraction { reflectance: 1.0, transmittance: 0.0, transmitted: (-n).as_vec3() };
    }
    let (cos_i, cos_t) = (cos2.sqrt(), cos2_t.sqrt());
    let transmitted: DVec3 = (n * (dot / n2) - o) / eta - n * cos_t;
    Refraction {
        reflectance: fresnel_reflectance_from_cosines(cos_i, cos_t, eta) as f32,
        transmittance: fresnel_transmittance(cos_i, cos_t, eta) as f32,
        transmitted: transmitted.normalize().as_vec3(),
    }
}

#[cfg(test)]
mod tests;
