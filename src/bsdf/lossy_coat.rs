//! Energy that a coat of a layered BSDF loses between its interface and its base.

use super::coat_albedo::{FACET_LATTICE, mean_coat_albedo};
use super::fresnel::fresnel_reflectance_and_cosine;
use super::microfacet::Ggx;
use super::{MAX_COAT_INDEX, MIN_ROUGH_ALPHA};
use glam::{DVec3, Vec2, Vec3};

/// Number of directions in a mean over the hemisphere. They are evenly spaced in the squared
/// cosine.
const DIRECTION_COUNT: u32 = 64;

/// Least refractive index of a coat relative to its surroundings. A smaller index is replaced by
/// this one.
const MIN_LOSSY_COAT_INDEX: f64 = 1.01;

/// Energy balance of a diffuse base under a lossy coat, as the layered BSDF of pbrt-v4 simulates it
/// (Guo et al. 2018).
///
/// The pbrt importer uses this balance to find the base of a lossless
/// [`CoatedDiffuse`](super::CoatedDiffuse) with equal albedo.
///
/// Light that would scatter at two microfacets of the interface is lost. The coat also absorbs
/// light: it transmits the fraction exp(−τ) along the normal, where τ is its optical thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LossyCoat {
    /// Fraction of diffuse light from outside that reaches the base.
    entering_fraction: f64,
    /// Fraction of diffuse light from the base that leaves the coat.
    leaving_fraction: f64,
    /// Fraction of diffuse light from the base that the coat's interface sends back to the base.
    returning_fraction: f64,
    /// Fraction of diffuse light from outside that would enter a lossless coat of equal index and
    /// α.
    lossless_entering_fraction: f64,
    /// Fraction of diffuse light from the base that would leave a lossless coat of equal index and
    /// α.
    lossless_leaving_fraction: f64,
}

impl LossyCoat {
    /// Creates the coat. `eta` is its relative index, which is clamped to \[1.01, 4]. `alpha` in
    /// \[0, 1] is its GGX roughness, and `thickness` ≥ 0 its optical thickness.
    #[must_use]
    pub fn new(eta: f64, alpha: f64, thickness: f64) -> Self {
        let eta = eta.clamp(MIN_LOSSY_COAT_INDEX, f64::from(MAX_COAT_INDEX));
        let transmittance = |cos: f64| libm::exp(-thickness / cos);
        let [mut entering, mut leaving, mut returning] = [0.0; 3];
        for i in 0..DIRECTION_COUNT {
            let cos = ((f64::from(i) + 0.5) / f64::from(DIRECTION_COUNT)).sqrt();
            for_each_scattered_direction(cos, eta, alpha, |weight, cos_i| {
                if cos_i < 0.0 {
                    entering += weight * transmittance(-cos_i);
                }
            });
            for_each_scattered_direction(cos, 1.0 / eta, alpha, |weight, cos_i| match cos_i < 0.0 {
                true => leaving += weight * transmittance(cos),
                false => returning += weight * transmittance(cos) * transmittance(cos_i),
            });
        }
        let [entering, leaving, returning] = [entering, leaving, returning].map(|sum| sum / f64::from(DIRECTION_COUNT));
        let lossless_entering = 1.0 - f64::from(mean_coat_albedo(eta as f32, alpha as f32));
        let lossless_leaving = lossless_entering / (eta * eta);
        Self {
            entering_fraction: entering,
            leaving_fraction: leaving,
            returning_fraction: returning,
            lossless_entering_fraction: lossless_entering,
            lossless_leaving_fraction: lossless_leaving,
        }
    }

    /// Returns the fraction of diffuse light from outside that a base of this reflectance sends
    /// back out through the coat.
    ///
    /// Reflection on the outside of the coat is not included.
    #[must_use]
    pub fn base_albedo_through_coat(&self, reflectance: f64) -> f64 {
        self.entering_fraction * reflectance * self.leaving_fraction / (1.0 - reflectance * self.returning_fraction)
    }

    /// Returns the reflectance with which a base under a lossless coat has the albedo of a base of
    /// `reflectance` in \[0, 1] under this coat.
    ///
    /// Both coats have equal index and α. The albedo is [`Self::base_albedo_through_coat`] of
    /// `reflectance`. Results outside \[0, 1] are clamped.
    #[must_use]
    pub fn equivalent_lossless_reflectance(&self, reflectance: f64) -> f64 {
        let albedo = self.base_albedo_through_coat(reflectance);
        let returning = 1.0 - self.lossless_leaving_fraction;
        (albedo / (self.lossless_entering_fraction * self.lossless_leaving_fraction + albedo * returning))
            .clamp(0.0, 1.0)
    }
}

/// Scatters light at an interface, and visits the directions in which it leaves. The light arrives
/// with the cosine of incidence `cos`.
///
/// For each direction, calls `visit` with two numbers: the fraction of the light that leaves in
/// this direction, and the direction's cosine, which is below 0 on the far side. `eta` is the
/// refractive index of the far side, relative to the near side. Light that meets a second
/// microfacet is left out.
fn for_each_scattered_direction(cos: f64, eta: f64, alpha: f64, mut visit: impl FnMut(f64, f64)) {
    if alpha < f64::from(MIN_ROUGH_ALPHA) {
        let (reflectance, cos_t) = fresnel_reflectance_and_cosine(cos, eta);
        visit(reflectance, cos);
        if reflectance < 1.0 {
            visit(1.0 - reflectance, -cos_t);
        }
        return;
    }
    let (ggx, wo) = (Ggx::new(alpha as f32), DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos));
    let (facets, generator) = FACET_LATTICE;
    for i in 0..facets {
        let u = (Vec2::new(i as f32, (i * generator % facets) as f32) + 0.5) / facets as f32;
        let m = ggx.sample_visible_normal(wo, Vec3::Z, u);
        let cos_m = wo.dot(m);
        if cos_m <= 0.0 {
            continue;
        }
        let (reflectance, cos_t) = fresnel_reflectance_and_cosine(cos_m.min(1.0), eta);
        let reflected = 2.0 * cos_m * m.z - wo.z;
        if reflected > 0.0 {
            let masking = ggx.reflection_g2_over_cosines(cos, reflected);
            visit(reflectance * ggx.unshadowed_microfacet_fraction(masking, cos, reflected) / facets as f64, reflected);
        }
        let refracted = m.z * (cos_m / eta - cos_t) - wo.z / eta;
        if reflectance < 1.0 && refracted < 0.0 {
            // pbrt-v4 uses the height-correlated function for both sides.
            let masking = ggx.reflection_g2_over_cosines(cos, -refracted);
            let seen = ggx.unshadowed_microfacet_fraction(masking, cos, -refracted);
            visit((1.0 - reflectance) * seen / facets as f64, refracted);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// [`LossyCoat::base_albedo_through_coat`] agrees with random walks in the layers.
    ///
    /// The expected albedos come from another program with 40 million walks. Their standard error
    /// is below 0.0002.
    #[test]
    fn lossy_coat_albedos_match_random_walks() {
        for (alpha, thickness, reflectance, expected) in WALKS {
            let albedo = LossyCoat::new(1.5, alpha, thickness).base_albedo_through_coat(reflectance);
            assert!((albedo - expected).abs() < 0.001, "{alpha} {thickness} {reflectance}: {albedo} {expected}");
        }
    }

    /// Rows of (GGX α, optical thickness, reflectance of the base, albedo by random walks), for a
    /// coat of index 1.5.
    const WALKS: [(f64, f64, f64, f64); 6] = [
        (0.0, 0.0, 0.5, 0.26119),
        (0.0, 0.01, 0.5, 0.25010),
        (0.1, 0.01, 0.6, 0.31960),
        (0.387, 0.01, 0.5, 0.21146),
        (0.387, 0.1, 0.9, 0.31201),
        (0.8, 0.01, 0.3, 0.09197),
    ];

    #[test]
    fn smooth_lossless_coats_change_no_reflectance() {
        for reflectance in [0.0, 0.2, 0.9, 1.0] {
            let equivalent = LossyCoat::new(1.5, 0.0, 0.0).equivalent_lossless_reflectance(reflectance);
            assert!((equivalent - reflectance).abs() < 2e-3, "{reflectance}: {equivalent}");
        }
        let lossy = LossyCoat::new(1.5, 0.4, 0.01);
        assert!(lossy.equivalent_lossless_reflectance(1.0) < 0.97 && lossy.equivalent_lossless_reflectance(0.0) == 0.0);
    }
}
